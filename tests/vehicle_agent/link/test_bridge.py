"""The desk between tick, disk and wire: what is not on disk is not told."""

import os
from pathlib import Path

import pytest

from contract.wire.codec import decode_from_vehicle, encode
from contract.wire.messages import (
    Challenge,
    CommandDone,
    EventReport,
    EventsAcknowledged,
    Hello,
    Message,
    OrderAccepted,
    OrderProgress,
    VehicleEvent,
    Welcome,
)
from tests.full_disk import full_disk
from vehicle_agent.link.bridge import LinkBridge, TickUpdate
from vehicle_agent.link.outbox import Outbox, read_memory
from vehicle_agent.link.session import Identity

S = 1_000_000_000
ME = Identity("shuttle-1", "boot-1", "0.1", "gem", "map-1", 6, 1)
HAPPENED: tuple[VehicleEvent, ...] = (CommandDone("c", True),)
ACCEPTED = OrderAccepted(4, "order-1", 2)
PROGRESS = OrderProgress("order-1", 2, ())


def connect(desk: LinkBridge) -> None:
    desk.session.connected(0)
    desk.session.received(encode(Challenge("nonce", 1, 1, 100 * S)), 0)


def a_desk(folder: Path) -> LinkBridge:
    """Welcomed, with nothing left to send."""
    desk = LinkBridge(folder, ME, lambda text: "", sync=False)
    connect(desk)
    desk.session.received(encode(Welcome(4, 1, 100 * S)), S)
    desk.session.take_outgoing()
    return desk


def sent(desk: LinkBridge) -> list[Message]:
    return [decode_from_vehicle(frame) for frame in desk.session.take_outgoing()]


def test_what_is_told_has_reached_the_disk_unless_the_caller_says_that_it_need_not(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    synced: list[int] = []
    monkeypatch.setattr(os, "fsync", synced.append)
    for folder, sync in (("vehicle", True), ("simulated", False)):
        desk = LinkBridge(tmp_path / folder, ME, lambda text: "", **({} if sync else {"sync": False}))
        synced.clear()
        desk.process_update(TickUpdate(S, events=HAPPENED), S)
        assert bool(synced) == sync


@pytest.mark.parametrize(
    "update",
    [
        TickUpdate(2 * S, events=HAPPENED),
        TickUpdate(2 * S, answers=(ACCEPTED,), memory=b"the order", progress=PROGRESS),
    ],
    ids=["event", "acceptance"],
)
def test_with_a_full_disk_the_vehicle_tells_no_event_and_accepts_no_order(
    tmp_path: Path, update: TickUpdate
) -> None:
    desk = a_desk(tmp_path)
    with full_disk(), pytest.raises(OSError, match="File too large"):
        desk.process_update(update, 2 * S)
    assert sent(desk) == []
    assert read_memory(tmp_path) is None


def test_what_the_vehicle_has_told_is_still_there_after_a_crash(tmp_path: Path) -> None:
    desk = a_desk(tmp_path)
    desk.process_update(
        TickUpdate(2 * S, events=HAPPENED, answers=(ACCEPTED,), memory=b"the order", progress=PROGRESS), 2 * S
    )
    assert sent(desk) == [EventReport(4, "boot-1", 0, 2 * S, HAPPENED[0]), ACCEPTED]
    assert read_memory(tmp_path) == b"the order"
    assert [event.body for event in Outbox(tmp_path, "boot-2").log.pending()] == list(HAPPENED)


def test_the_next_hello_says_what_the_vehicle_follows_now(tmp_path: Path) -> None:
    desk = a_desk(tmp_path)
    desk.process_update(TickUpdate(2 * S, memory=b"the order", progress=PROGRESS), 2 * S)
    desk.process_update(TickUpdate(3 * S), 3 * S)
    connect(desk)
    (hello,) = sent(desk)
    assert isinstance(hello, Hello)
    assert hello.progress == PROGRESS


def test_an_acknowledged_event_is_not_told_again(tmp_path: Path) -> None:
    desk = a_desk(tmp_path)
    desk.process_update(TickUpdate(2 * S, events=HAPPENED), 2 * S)
    assert [m.sequence for m in sent(desk) if isinstance(m, EventReport)] == [0]
    desk.session.received(encode(EventsAcknowledged(4, "boot-1", 1)), 3 * S)
    connect(desk)
    desk.session.received(encode(Welcome(5, 1, 100 * S)), 4 * S)
    assert not [m for m in sent(desk) if isinstance(m, EventReport)]
