"""The inbox: the order of the items, and one source that floods it."""

from vehicle_agent.runtime.inbox import SHARE_MAX, UNKNOWN_SOURCE, Inbox
from vehicle_agent.signals import CanFrame, SeatButton


def frame(number: int) -> CanFrame:
    return CanFrame(number, 0x400, number.to_bytes(4, "big"))


def test_items_are_drained_once_in_order_of_arrival_source_and_sequence() -> None:
    inbox = Inbox()
    inbox.put(2, "can", frame(0))
    inbox.put(1, "can", frame(1))
    inbox.put(1, "cabin", SeatButton(1, 3))
    drained = inbox.drain()
    assert [(item.arrival_ns, item.source, item.sequence) for item in drained] == [
        (1, "cabin", 0),
        (1, "can", 1),
        (2, "can", 0),
    ]
    assert inbox.drain() == ()


def test_a_source_that_floods_the_inbox_takes_nothing_from_the_others() -> None:
    inbox = Inbox()
    inbox.put(1, "cabin", SeatButton(1, 3))
    for number in range(5 * SHARE_MAX):
        inbox.put(2, "can", frame(number))
    inbox.put(3, "lidar", frame(7))
    inbox.put(3, "cabin", SeatButton(3, 4))
    drained = inbox.drain()
    assert [item.arrival_ns for item in drained if item.source == "cabin"] == [1, 3]
    assert [item.body for item in drained if item.source == "lidar"] == [frame(7)]
    assert inbox.dropped == {"can": 4 * SHARE_MAX}


def test_of_a_flood_the_newest_items_are_kept_and_the_gap_shows_in_their_sequence() -> None:
    inbox = Inbox(share_max=3)
    for number in range(10):
        inbox.put(number, "can", frame(number))
    assert [(item.sequence, item.body) for item in inbox.drain()] == [(n, frame(n)) for n in (7, 8, 9)]
    inbox.put(11, "can", frame(11))
    assert [item.sequence for item in inbox.drain()] == [10]
    assert inbox.dropped == {"can": 7}


def test_sources_without_end_get_no_share() -> None:
    inbox = Inbox(shares=2)
    for number in range(5):
        inbox.put(1, f"source {number}", frame(number))
    assert [item.source for item in inbox.drain()] == ["source 0", "source 1"]
    assert inbox.dropped == {UNKNOWN_SOURCE: 3}
