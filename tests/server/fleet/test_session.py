import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from contract.geometry import Pose2
from contract.wire.close_reasons import CloseCode
from contract.wire.codec import MAX_MESSAGE_BYTES, encode
from contract.wire.messages import (
    PROTOCOL_VERSION,
    Challenge,
    ClockProbe,
    ClockSample,
    Command,
    EventLogState,
    EventReport,
    EventsAcknowledged,
    Message,
    ModeChanged,
    OrderAccepted,
    Status,
    Welcome,
)
from server.fleet.actions import (
    Action,
    Close,
    FindKey,
    NoteAnswer,
    NoteStatus,
    OpenSession,
    ReportViolation,
    Send,
    StoreEvent,
)
from server.fleet.session import VehicleSession
from tests.server.fleet.vehicle_key import VehicleKeyPair, a_hello

KEY = VehicleKeyPair("shuttle-1")


def a_status(epoch: int = 7) -> Status:
    return Status(
        epoch, 5, Pose2(1.0, 2.0, 0.0), 1.0, 0.0, 0.0, "autonomous", 0.9, False, "l1", 3.0, "o1", 1, "v1"
    )


def an_event(epoch: int = 7, sequence: int = 0) -> EventReport:
    return EventReport(epoch, "boot-1", sequence, 9, ModeChanged("held", detail="operator"))


def an_open_session() -> VehicleSession:
    session = VehicleSession("nonce-1")
    session.received(encode(a_hello("nonce-1")), 0)
    session.key_found(KEY.public)
    session.welcomed(7, (), 0)
    assert session.state == "open"
    return session


def closed_with(actions: tuple[Action, ...]) -> CloseCode:
    """The code of the only action besides reports of violations."""
    (close,) = (action for action in actions if not isinstance(action, ReportViolation))
    assert isinstance(close, Close)
    return close.code


def reported(actions: tuple[Action, ...]) -> str:
    """The violation that is reported, "" for none."""
    return "".join(action.detail for action in actions if isinstance(action, ReportViolation))


def with_seats(hello: bytes, seats: int) -> bytes:
    """The hello with a number of seats that its signature does not cover."""
    return hello.replace(b'"seats":6', b'"seats":%d' % seats)


def test_a_session_begins_with_a_challenge_that_names_the_protocol_versions() -> None:
    (action,) = VehicleSession("nonce-1").begin(5)
    assert isinstance(action, Send)
    assert action.message == Challenge("nonce-1", 1, PROTOCOL_VERSION, 5)


def test_a_signed_hello_opens_the_session() -> None:
    session = VehicleSession("nonce-1")
    hello = a_hello("nonce-1", logs=(EventLogState("boot-0", 3),))
    assert session.received(encode(hello), 0) == (FindKey("shuttle-1"),)
    assert session.key_found(KEY.public) == (OpenSession(hello),)
    welcome = session.welcomed(7, (EventLogState("boot-0", 3),), 11)
    assert welcome == (Send(Welcome(7, PROTOCOL_VERSION, 11, (EventLogState("boot-0", 3),))),)


def test_a_stolen_hello_is_refused_because_it_answers_another_nonce() -> None:
    stolen = encode(a_hello("nonce-1"))
    assert closed_with(VehicleSession("nonce-2").received(stolen, 0)) == "nonce_wrong"


def test_a_stolen_hello_with_the_nonce_exchanged_has_a_wrong_signature() -> None:
    forged = msgspec.structs.replace(a_hello("nonce-1"), nonce="nonce-2")
    session = VehicleSession("nonce-2")
    session.received(encode(forged), 0)
    assert closed_with(session.key_found(KEY.public)) == "signature_wrong"


@pytest.mark.parametrize("signature", ["", "not base64 ü", "AAAA", "A" * 88])
def test_a_signature_that_is_none_is_refused(signature: str) -> None:
    session = VehicleSession("nonce-1")
    session.received(encode(msgspec.structs.replace(a_hello("nonce-1"), signature=signature)), 0)
    assert closed_with(session.key_found(KEY.public)) == "signature_wrong"


def test_another_vehicles_key_does_not_open_the_session() -> None:
    session = VehicleSession("nonce-1")
    session.received(encode(a_hello("nonce-1", key=VehicleKeyPair("thief"))), 0)
    assert closed_with(session.key_found(KEY.public)) == "signature_wrong"


def test_a_repeated_hello_is_refused_at_every_stage() -> None:
    hello = encode(a_hello("nonce-1"))
    checking = VehicleSession("nonce-1")
    checking.received(hello, 0)
    assert closed_with(checking.received(hello, 0)) == "hello_repeated"
    assert checking.key_found(KEY.public) == ()
    assert closed_with(an_open_session().received(hello, 0)) == "hello_repeated"


@pytest.mark.parametrize("protocol", [0, PROTOCOL_VERSION + 1])
def test_a_protocol_version_not_spoken_here_gets_a_goodbye_that_names_those_spoken(protocol: int) -> None:
    (action,) = VehicleSession("n").received(encode(a_hello("n", protocol=protocol)), 0)
    assert isinstance(action, Close)
    assert action.code == "protocol_version"
    assert f"protocol {protocol}" in action.detail
    assert "Update" in action.detail


def test_an_unknown_message_is_named_in_the_goodbye() -> None:
    report, close = an_open_session().received(b'{"type":"teleport","to":"gate"}', 0)
    assert isinstance(close, Close)
    assert close.code == "unknown_message"
    assert "teleport" in close.detail
    assert report == ReportViolation(close.detail)


def test_a_server_message_from_a_vehicle_is_unknown() -> None:
    assert (
        closed_with(an_open_session().received(encode(EventsAcknowledged(7, "b", 1)), 0)) == "unknown_message"
    )


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"\xff\xfe",
        b"null",
        b"[" * 100_000,
        b'{"type":"status"}',
        b'{"type":"clock_probe","vehicle_ns":"soon"}',
        b'{"type":"clock_probe","vehicle_ns":1,"x":' + b"[" * 5_000 + b"]" * 5_000 + b"}",
    ],
)
def test_what_is_no_message_gets_a_typed_goodbye(data: bytes) -> None:
    assert closed_with(an_open_session().received(data, 0)) == "malformed"


def test_an_oversize_frame_gets_a_typed_goodbye() -> None:
    assert closed_with(an_open_session().received(b" " * (MAX_MESSAGE_BYTES + 1), 0)) == "frame_too_large"


@pytest.mark.parametrize("message", [a_status(), an_event(), ClockProbe(1), OrderAccepted(7, "o", 1)])
def test_nothing_but_a_hello_is_heard_before_the_welcome(message: Message) -> None:
    assert closed_with(VehicleSession("n").received(encode(message), 0)) == "hello_expected"
    opening = VehicleSession("nonce-1")
    opening.received(encode(a_hello("nonce-1")), 0)
    assert closed_with(opening.received(encode(message), 0)) == "hello_expected"


@pytest.mark.parametrize("message", [a_status(6), an_event(6), OrderAccepted(6, "o", 1)])
def test_frames_of_an_old_epoch_are_refused(message: Message) -> None:
    assert closed_with(an_open_session().received(encode(message), 0)) == "epoch_stale"


def test_open_frames_become_their_actions() -> None:
    session = an_open_session()
    assert session.received(encode(a_status()), 0) == (NoteStatus(a_status()),)
    assert session.received(encode(an_event()), 7) == (StoreEvent(an_event(), 7),)
    accepted = OrderAccepted(7, "o", 1)
    assert session.received(encode(accepted), 0) == (NoteAnswer(accepted),)
    assert session.received(encode(ClockProbe(3)), 44) == (Send(ClockSample(3, 44)),)


def test_a_gap_is_answered_with_the_event_expected() -> None:
    assert an_open_session().events_stored("boot-1", 4) == (Send(EventsAcknowledged(7, "boot-1", 4)),)


def test_a_closed_session_hears_and_says_nothing() -> None:
    session = an_open_session()
    assert closed_with(session.close("superseded", "newer")) == "superseded"
    assert session.close("malformed", "again") == ()
    assert session.received(encode(an_event()), 0) == ()
    assert session.send(Command(7, "c", "hold")) == ()


NOISE = st.one_of(
    st.binary(max_size=200),
    st.sampled_from(
        [encode(m) for m in (a_hello("nonce-1"), a_hello("other"), a_status(), an_event(), ClockProbe(1))]
    ),
    st.recursive(
        st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
        lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from(["type", "a"]), inner),
        max_leaves=6,
    ).map(lambda value: msgspec.json.encode(value)),
)


@settings(max_examples=300, deadline=None)
@given(st.lists(st.tuples(NOISE, st.booleans()), max_size=8))
def test_no_sequence_of_frames_breaks_a_session_or_opens_it_twice(frames: list[tuple[bytes, bool]]) -> None:
    session = VehicleSession("nonce-1")
    session.begin(0)
    opened = 0
    for data, answers in frames:
        actions = session.received(data, 0)
        if answers and FindKey("shuttle-1") in actions:
            opened += sum(isinstance(action, OpenSession) for action in session.key_found(KEY.public))
            session.welcomed(7, (), 0)
    assert opened <= 1


@settings(max_examples=200, deadline=None)
@given(st.data())
def test_a_hello_with_any_byte_altered_opens_nothing(data: st.DataObject) -> None:
    original = encode(a_hello("nonce-1"))
    place = data.draw(st.integers(0, len(original) - 1))
    altered = bytearray(original)
    altered[place] ^= data.draw(st.integers(1, 255))
    session = VehicleSession("nonce-1")
    for action in session.received(bytes(altered), 0):
        if isinstance(action, FindKey) and action.vehicle_id == "shuttle-1":
            for opened in session.key_found(KEY.public):
                if isinstance(opened, OpenSession):
                    # Only what the signature does not cover may differ: it carries no authority.
                    assert opened.hello.nonce == "nonce-1"
                    assert opened.hello.vehicle_id == "shuttle-1"
                    assert opened.hello.boot_id == "boot-1"


def test_what_a_verified_vehicle_sends_beyond_the_bounds_is_reported_before_the_goodbye() -> None:
    mad = encode(msgspec.structs.replace(a_status(), speed_mps=-5e200))
    actions = an_open_session().received(mad, 0)
    assert "speed_mps" in reported(actions)
    assert isinstance(actions[-1], Close)
    assert reported(an_open_session().received(b" " * (MAX_MESSAGE_BYTES + 1), 0)) != ""


def test_a_hello_beyond_the_bounds_is_reported_once_its_signature_is_verified() -> None:
    session = VehicleSession("nonce-1")
    assert session.received(with_seats(encode(a_hello("nonce-1")), 2**62), 0) == (FindKey("shuttle-1"),)
    actions = session.key_found(KEY.public)
    assert "seats" in reported(actions)
    assert closed_with(actions) == "malformed"


def test_a_hello_beyond_the_bounds_with_another_signature_accuses_no_vehicle() -> None:
    session = VehicleSession("nonce-1")
    session.received(with_seats(encode(a_hello("nonce-1")), 2**62), 0)
    actions = session.key_found(VehicleKeyPair("another").public)
    assert (reported(actions), closed_with(actions)) == ("", "signature_wrong")


def test_a_hello_beyond_the_bounds_for_another_nonce_accuses_no_vehicle() -> None:
    stolen = with_seats(encode(a_hello("nonce-1")), 2**62)
    actions = VehicleSession("nonce-2").received(stolen, 0)
    assert (reported(actions), closed_with(actions)) == ("", "nonce_wrong")


def test_a_stranger_that_sends_no_message_is_not_reported() -> None:
    for frame in (b"{", b" " * (MAX_MESSAGE_BYTES + 1), b'{"type":"hello"}'):
        actions = VehicleSession("nonce-1").received(frame, 0)
        assert reported(actions) == ""
        assert isinstance(actions[-1], Close)


def test_more_wheelchair_places_than_seats_are_reported_of_a_verified_vehicle() -> None:
    session = VehicleSession("nonce-1")
    hello = msgspec.structs.replace(a_hello("nonce-1"), seats=2, wheelchair_places=3)
    session.received(encode(hello), 0)
    actions = session.key_found(KEY.public)
    assert "wheelchair" in reported(actions)
    assert closed_with(actions) == "malformed"
