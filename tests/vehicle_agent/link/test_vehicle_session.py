import base64

import pytest

from contract.geometry import Pose2
from contract.wire.codec import WireError, decode_from_vehicle, encode
from contract.wire.messages import (
    Challenge,
    ClockProbe,
    ClockSample,
    Command,
    CommandDone,
    EventReport,
    EventsAcknowledged,
    Goodbye,
    Hello,
    MapPublished,
    Message,
    OrderProgress,
    Presence,
    Status,
    Welcome,
    signed_hello,
)
from contract.wire.sequence import EventLog
from vehicle_agent.link.clock import ClockOffset
from vehicle_agent.link.session import REPEAT_AFTER_NS, SILENT_AFTER_NS, Identity, VehicleSession
from vehicle_agent.signals import LinkState, PedestrianPresence

S = 1_000_000_000
ME = Identity("shuttle-1", "boot-1", "0.1", "gem", "map-1", 6, 1)


def a_session(log: EventLog | None = None) -> VehicleSession:
    progress = OrderProgress("order-1", 3, ())
    return VehicleSession(
        ME, lambda text: base64.b64encode(text).decode(), log or EventLog("boot-1"), progress
    )


def a_status() -> Status:
    return Status(0, 1, Pose2(0, 0, 0), 0, 0, 0, "held", 1.0, False, "l", 0, "", 0, "")


def sent(session: VehicleSession) -> list[Message]:
    return [decode_from_vehicle(frame) for frame in session.take_outgoing()]


def opened(log: EventLog | None = None, epoch: int = 4) -> VehicleSession:
    session = a_session(log)
    session.connected(0)
    session.received(encode(Challenge("nonce", 1, 1, 100 * S)), 0)
    session.take_outgoing()
    session.received(encode(Welcome(epoch, 1, 100 * S)), 1 * S)
    return session


def test_the_hello_signs_the_servers_nonce_and_says_what_the_vehicle_holds() -> None:
    session = a_session()
    session.connected(0)
    assert sent(session) == []
    session.received(encode(Challenge("nonce-9", 1, 1, 5)), 7)
    (hello,) = sent(session)
    assert isinstance(hello, Hello)
    assert base64.b64decode(hello.signature) == signed_hello("nonce-9", "shuttle-1", "boot-1", 1)
    assert hello.progress == OrderProgress("order-1", 3, ())
    assert (hello.vehicle_ns, hello.seats, hello.wheelchair_places) == (7, 6, 1)


def test_after_the_welcome_everything_unacknowledged_is_sent_under_the_new_epoch() -> None:
    log = EventLog("boot-1")
    log.append(5, CommandDone("a", True))
    log.append(6, CommandDone("b", True))
    messages = sent(opened(log, epoch=9))
    assert [m.epoch for m in messages if isinstance(m, EventReport)] == [9, 9]
    assert any(isinstance(m, ClockProbe) for m in messages)


def test_an_event_is_sent_once_and_repeated_only_when_nothing_is_acknowledged() -> None:
    log = EventLog("boot-1")
    session = opened(log)
    session.take_outgoing()
    log.append(5, CommandDone("a", True))
    session.send_new_events(2 * S)
    session.send_new_events(2 * S)
    assert [type(m) for m in sent(session)] == [EventReport]
    session.advance(2 * S + REPEAT_AFTER_NS // 2)
    assert not [m for m in sent(session) if isinstance(m, EventReport)]
    session.advance(2 * S + REPEAT_AFTER_NS)
    assert [m.sequence for m in sent(session) if isinstance(m, EventReport)] == [0]
    session.received(encode(EventsAcknowledged(4, "boot-1", 1)), 6 * S)
    session.advance(20 * S)
    assert not [m for m in sent(session) if isinstance(m, EventReport)]


def test_words_of_an_older_epoch_are_ignored() -> None:
    session = opened(epoch=4)
    session.take_messages()
    session.received(encode(Command(3, "old", "hold")), 2 * S)
    session.received(encode(Command(4, "new", "hold")), 2 * S)
    assert session.take_messages() == [Command(4, "new", "hold")]


def test_before_the_welcome_nobody_commands_the_vehicle() -> None:
    session = a_session()
    session.connected(0)
    for epoch in (0, 1):
        session.received(encode(Command(epoch, f"of epoch {epoch}", "hold")), 1 * S)
    assert session.take_messages() == []


def test_a_vehicle_whose_key_another_agent_uses_is_told_to_hold() -> None:
    session = opened(epoch=4)
    session.take_messages()
    session.received(encode(Goodbye("key_conflict", "two agents")), 2 * S)
    (command,) = session.take_messages()
    assert isinstance(command, Command)
    assert (command.epoch, command.kind) == (4, "hold")


def test_another_goodbye_or_one_before_any_welcome_stops_no_vehicle() -> None:
    session = opened(epoch=4)
    session.take_messages()
    session.received(encode(Goodbye("superseded", "newer")), 2 * S)
    assert session.take_messages() == []
    stranger = a_session()
    stranger.connected(0)
    stranger.received(encode(Goodbye("key_conflict", "two agents")), 2 * S)
    assert stranger.take_messages() == []


def test_a_status_before_the_welcome_is_not_kept_for_later() -> None:
    session = a_session()
    session.connected(0)
    session.report(a_status())
    assert sent(session) == []


def test_the_vehicle_learns_the_offset_of_the_server_clock() -> None:
    session = opened()
    session.received(encode(ClockSample(2 * S, 103 * S)), 4 * S)
    states = [word for word in session.take_messages() if isinstance(word, LinkState)]
    assert states[-1].connected
    assert states[-1].server_offset_ns == 100 * S


def test_the_shortest_round_trip_decides_the_offset() -> None:
    clock = ClockOffset()
    clock.add(0, 1000, 10)
    clock.add(100, 5100, 2100)
    assert (clock.offset_ns, clock.round_trip_ns) == (995, 10)


def test_a_cut_is_told_to_the_vehicle_and_loses_no_event() -> None:
    log = EventLog("boot-1")
    session = opened(log)
    log.append(5, CommandDone("a", True))
    session.send_new_events(2 * S)
    session.disconnected(3 * S)
    states = [word for word in session.take_messages() if isinstance(word, LinkState)]
    assert not states[-1].connected
    assert len(log.pending()) == 1
    assert sent(session) == []


def test_a_goodbye_is_kept_so_that_the_operator_can_read_it() -> None:
    session = opened()
    session.received(encode(Goodbye("key_unknown", "enrol this vehicle")), 2 * S)
    assert session.refusal == Goodbye("key_unknown", "enrol this vehicle")


def test_an_unknown_message_closes_the_connection() -> None:
    with pytest.raises(WireError, match="type"):
        opened().received(b'{"type":"teleport"}', 2 * S)


def test_a_connection_on_which_nothing_comes_is_given_up() -> None:
    session = opened()
    assert not session.is_silent(S + SILENT_AFTER_NS)
    assert session.is_silent(S + SILENT_AFTER_NS + 1)


def test_a_cameras_word_is_stamped_in_the_vehicles_own_clock() -> None:
    session = opened(epoch=4)
    session.take_messages()
    session.received(encode(Presence(4, "zebra", 105 * S, 2)), 7 * S)
    session.received(encode(Presence(3, "zebra", 105 * S, 9)), 7 * S)
    (word,) = session.take_messages()
    assert isinstance(word, PedestrianPresence)
    assert (word.area_id, word.count) == ("zebra", 2)
    offset_ns = 105 * S - word.stamp_ns
    assert abs(offset_ns - 99 * S) <= S


def test_a_new_connection_has_its_full_time_before_it_counts_as_silent() -> None:
    session = opened()
    session.disconnected(2 * S)
    session.connected(100 * S)
    assert not session.is_silent(100 * S + SILENT_AFTER_NS)
    assert session.is_silent(100 * S + SILENT_AFTER_NS + 1)


def test_the_clock_is_compared_every_ten_seconds() -> None:
    session = opened()
    session.take_outgoing()
    for now_s, asks in ((10, False), (11, True), (12, False), (20, False), (21, True)):
        session.advance(now_s * S)
        assert [type(message) for message in sent(session)] == ([ClockProbe] if asks else []), now_s


def test_what_is_not_acknowledged_is_repeated_every_three_seconds() -> None:
    log = EventLog("boot-1")
    session = opened(log)
    session.take_outgoing()
    log.append(5, CommandDone("a", True))
    session.send_new_events(2 * S)
    repeats = []
    for now_ns in range(2 * S, 9 * S, S // 2):
        session.advance(now_ns)
        repeats += [now_ns / S for message in sent(session) if isinstance(message, EventReport)]
    assert repeats == [2.0, 5.0, 8.0]


def with_three_events_sent() -> VehicleSession:
    log = EventLog("boot-1")
    session = opened(log)
    session.take_outgoing()
    for number in range(3):
        log.append(5, CommandDone(f"c{number}", True))
    session.send_new_events(2 * S)
    session.take_outgoing()
    return session


def test_every_acknowledgement_puts_the_next_repeat_off() -> None:
    session = with_three_events_sent()
    session.received(encode(EventsAcknowledged(4, "boot-1", 1)), 4 * S)
    session.advance(4 * S + REPEAT_AFTER_NS - 1)
    assert not [m for m in sent(session) if isinstance(m, EventReport)]
    session.advance(4 * S + REPEAT_AFTER_NS)
    assert [m.sequence for m in sent(session) if isinstance(m, EventReport)] == [1, 2]


def test_an_acknowledgement_of_nothing_new_asks_for_what_the_server_lacks() -> None:
    session = with_three_events_sent()
    session.received(encode(EventsAcknowledged(4, "boot-1", 1)), 3 * S)
    session.take_outgoing()
    session.received(encode(EventsAcknowledged(4, "boot-1", 1)), 3 * S + REPEAT_AFTER_NS)
    assert [m.sequence for m in sent(session) if isinstance(m, EventReport)] == [1, 2]


def test_an_acknowledgement_of_nothing_new_right_after_sending_has_only_crossed_it() -> None:
    session = with_three_events_sent()
    session.received(encode(EventsAcknowledged(4, "boot-1", 1)), 3 * S)
    session.take_outgoing()
    session.received(encode(EventsAcknowledged(4, "boot-1", 1)), 3 * S + REPEAT_AFTER_NS - 1)
    assert sent(session) == []


def test_a_published_map_is_for_the_link_and_not_for_the_tick() -> None:
    session = opened()
    session.take_messages()
    published = MapPublished(4, "map-2", 64 * "a", 10)
    session.received(encode(published), 2 * S)
    assert session.take_messages() == []
    assert session.take_published_map() == published
    assert session.take_published_map() is None
    session.received(encode(MapPublished(3, "map-3", 64 * "a", 10)), 2 * S)
    assert session.take_published_map() is None, "of a session that was replaced"
