"""Every message both ways, and what is none."""

import contextlib
import typing

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from contract.wire.codec import MAX_MESSAGE_BYTES, WireError, decode_from_server, decode_from_vehicle, encode
from contract.wire.events import EventLogState
from contract.wire.infrastructure import PresenceReport
from contract.wire.messages import (
    ClockProbe,
    FaultReport,
    Message,
    ServerMessage,
    VehicleEvent,
    VehicleMessage,
)

VEHICLE_KINDS: tuple[type[Message], ...] = typing.get_args(VehicleMessage)
SERVER_KINDS: tuple[type[Message], ...] = typing.get_args(ServerMessage)


def built(kind: type) -> st.SearchStrategy[object]:
    """Any value of a struct, from its own type hints."""
    hints = typing.get_type_hints(kind, include_extras=True)
    return st.builds(kind, **{name: of_hint(hints[name]) for name in kind.__struct_fields__})


def of_hint(hint: object) -> st.SearchStrategy[object]:
    if isinstance(hint, type) and issubclass(hint, msgspec.Struct):
        return st.deferred(lambda: built(hint))
    origin, arguments = typing.get_origin(hint), typing.get_args(hint)
    if origin is typing.Annotated:
        return within(arguments[0], arguments[1])
    if origin is tuple and len(arguments) == 2 and arguments[1] is Ellipsis:
        return st.lists(of_hint(arguments[0]), max_size=3).map(tuple)
    if origin is typing.Literal:
        return st.sampled_from(arguments)
    if arguments:
        return st.one_of(*(of_hint(argument) for argument in arguments))
    if hint is type(None):
        return st.none()
    return st.from_type(hint)  # type: ignore[arg-type]


def within(kind: object, bounds: msgspec.Meta) -> st.SearchStrategy[object]:
    if kind is int:
        return st.integers(bounds.ge, bounds.le)
    if kind is float:
        return st.floats(bounds.ge, bounds.le)
    if kind is str:
        return st.text(min_size=bounds.min_length or 0, max_size=min(bounds.max_length or 0, 20))
    return of_hint(kind)


def structs_of(kind: object) -> set[type[msgspec.Struct]]:
    """A struct and all structs in its fields."""
    if isinstance(kind, type) and issubclass(kind, msgspec.Struct):
        hints = typing.get_type_hints(kind, include_extras=True).values()
        return {kind}.union(*(structs_of(hint) for hint in hints))
    return set().union(*(structs_of(argument) for argument in typing.get_args(kind)))


def unbounded(hint: object) -> list[object]:
    """The parts of a type that take a number, a text or a list of any size."""
    origin, arguments = typing.get_origin(hint), typing.get_args(hint)
    if origin is typing.Annotated:
        kind, meta = arguments[0], arguments[1]
        if kind in (int, float):
            return [hint] if None in (meta.ge, meta.le) else []
        if kind in (str, bytes):
            return [hint] if meta.max_length is None else []
        return unbounded(typing.get_args(kind)[0]) if meta.max_length else [hint]
    if hint in (int, float, str) or origin is tuple:
        return [hint]
    return [part for argument in arguments for part in unbounded(argument) if origin is not typing.Literal]


STRUCTS = sorted(
    set().union(*(structs_of(kind) for kind in (*VEHICLE_KINDS, *SERVER_KINDS, PresenceReport))),
    key=lambda kind: kind.__name__,
)


@pytest.mark.parametrize("kind", STRUCTS, ids=lambda kind: kind.__name__)
def test_every_number_text_and_list_on_the_wire_has_bounds(kind: type[msgspec.Struct]) -> None:
    hints = typing.get_type_hints(kind, include_extras=True)
    found = {name: unbounded(hints[name]) for name in kind.__struct_fields__}
    assert {name: parts for name, parts in found.items() if parts} == {}


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("speed_mps", "-5e200"),
        ("speed_mps", "1e400"),
        ("s_m", "1e7"),
        ("battery_ratio", "null"),
        ("stamp_ns", str(2**63)),
        ("revision", str(2**62)),
        ("pose_map", "[1e7,0.0,0.0]"),
        ("pose_map", "[0.0,0.0,100.0]"),
        ("lane_id", f'"{201 * "l"}"'),
        ("aboard", "[" + ",".join(['"r"'] * 201) + "]"),
    ],
)
def test_a_value_beyond_its_bounds_is_no_message(field: str, value: str) -> None:
    fields = {
        "type": '"status"', "epoch": "1", "stamp_ns": "5", "pose_map": "[0.0,0.0,0.0]", "speed_mps": "1.0",
        "accel_mps2": "0.0", "steer_rad": "0.0", "mode": '"held"', "battery_ratio": "0.5",
        "doors_open": "false", "lane_id": '"l"', "s_m": "0.0", "order_id": '"o"',
        "revision": "0", "visit_id": '""',
    }  # fmt: skip
    decode_from_vehicle("{" + ",".join(f'"{name}":{text}' for name, text in fields.items()) + "}")
    fields[field] = value
    with pytest.raises(WireError, match=field):
        decode_from_vehicle("{" + ",".join(f'"{name}":{text}' for name, text in fields.items()) + "}")


@pytest.mark.parametrize("kind", VEHICLE_KINDS, ids=lambda kind: kind.__name__)
@settings(max_examples=25, deadline=None)
@given(st.data())
def test_what_a_vehicle_says_arrives_as_it_was(kind: type[Message], data: st.DataObject) -> None:
    message = data.draw(built(kind))
    assert decode_from_vehicle(encode(message)) == message  # type: ignore[arg-type]


@pytest.mark.parametrize("kind", SERVER_KINDS, ids=lambda kind: kind.__name__)
@settings(max_examples=25, deadline=None)
@given(st.data())
def test_what_the_server_says_arrives_as_it_was(kind: type[Message], data: st.DataObject) -> None:
    message = data.draw(built(kind))
    assert decode_from_server(encode(message)) == message  # type: ignore[arg-type]


def test_every_message_and_every_event_has_a_tag_of_its_own() -> None:
    tags = [kind.__struct_config__.tag for kind in (*VEHICLE_KINDS, *SERVER_KINDS)]
    assert len(set(tags)) == len(tags)
    events = [kind.__struct_config__.tag for kind in typing.get_args(VehicleEvent)]
    assert len(set(events)) == len(events)


def test_nobody_speaks_with_the_others_voice() -> None:
    for kind in SERVER_KINDS:
        with pytest.raises(WireError):
            decode_from_vehicle(f'{{"type":"{kind.__struct_config__.tag}"}}')


def test_a_newer_peers_additional_field_is_no_error() -> None:
    assert decode_from_vehicle('{"type":"clock_probe","vehicle_ns":7,"mood":"good"}') is not None


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"{}",
        b'{"type":"clock_probe"}',
        b'{"type":"clock_probe","vehicle_ns":1e999}',
        b'{"type":"clock_probe","vehicle_ns":NaN}',
        b'{"type":"teleport"}',
        b"\xff",
        b'{"type":"clock_probe","x":' + b"[" * 100_000,
        b" " * (MAX_MESSAGE_BYTES + 1),
    ],
)
def test_what_is_no_message_is_an_error_that_says_so(data: bytes) -> None:
    for decode in (decode_from_vehicle, decode_from_server):
        with pytest.raises(WireError) as error:
            decode(data)
        assert error.value.detail


def test_a_frame_may_be_exactly_as_long_as_is_allowed() -> None:
    data = b'{"type":"clock_probe","vehicle_ns":7}'
    assert decode_from_vehicle(data.ljust(MAX_MESSAGE_BYTES)) == ClockProbe(7)
    with pytest.raises(WireError, match="at most"):
        decode_from_vehicle(data.ljust(MAX_MESSAGE_BYTES + 1))


def test_a_boot_of_which_a_hello_does_not_say_the_next_number_has_none_known() -> None:
    assert msgspec.convert({"boot_id": "b", "first_unacknowledged": 4}, EventLogState).next_sequence == 0


@pytest.mark.parametrize(
    ("changes", "within"),
    [
        ({"count": 0}, True),
        ({"count": 1000}, True),
        ({"count": -1}, False),
        ({"count": 1001}, False),
        ({"age_s": 0.0}, True),
        ({"age_s": 10.0}, True),
        ({"age_s": -0.1}, False),
        ({"age_s": 10.1}, False),
        ({"area_id": ""}, False),
        ({"area_id": 81 * "a"}, False),
        ({"area_id": 80 * "a"}, True),
    ],
)
def test_a_camera_reports_a_number_of_people_in_a_named_area_a_moment_ago(
    changes: dict[str, object], within: bool
) -> None:
    fields = {"area_id": "crossing-1", "count": 2, "age_s": 0.5} | changes
    with contextlib.nullcontext() if within else pytest.raises(msgspec.ValidationError):
        msgspec.convert(fields, PresenceReport)


@settings(max_examples=200, deadline=None)
@given(st.binary(max_size=300))
def test_no_bytes_raise_anything_else(data: bytes) -> None:
    for decode in (decode_from_vehicle, decode_from_server):
        with contextlib.suppress(WireError):
            decode(data)


def test_a_fault_names_its_device_and_one_of_an_older_vehicle_names_none() -> None:
    text = b'{"code":"lidar_moved","severity":"warning","since_ns":5,"detail":"front_left"}'  # as sent now
    assert msgspec.json.decode(text, type=FaultReport) == FaultReport(
        "lidar_moved", "warning", 5, "front_left"
    )
    older = msgspec.json.decode(b'{"code":"lidar_blind","severity":"stop","since_ns":5}', type=FaultReport)
    assert older.detail == ""
    assert b'"detail":"roof"' in msgspec.json.encode(FaultReport("lidar_blind", "stop", 5, "roof"))
