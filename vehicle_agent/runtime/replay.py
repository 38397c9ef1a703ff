"""Runs a recorded segment again and compares bit for bit: the first tick, room and field that differ."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import msgspec

from contract.roads.load import decode_map
from contract.roads.model import RoadMap
from contract.runlog.arrays import dec_hook
from contract.runlog.reader import RunLogError, open_segment, ticks
from vehicle_agent.config import Profile
from vehicle_agent.onboard.car import Car
from vehicle_agent.runtime.computer import VehicleComputer
from vehicle_agent.runtime.recording.recorder import SIGNALS, FlowEncoder
from vehicle_agent.runtime.recording.snapshot import decode_state
from vehicle_agent.signals import InboxItem

# The room of each recorded signal.
ROOM_OF = {
    "motion": "can",
    "ego": "localization",
    "detections": "perception",
    "world": "world",
    "task": "mission",
    "path": "planning",
    "command": "control",
    "actuation": "guard",
    "guard_status": "guard",
    "hmi": "hmi",
    "frames": "can",
    "events": "mission or guard",
    "answers": "mission",
}

BuildCar = Callable[[Profile, RoadMap, str], Car]


@dataclass(frozen=True, slots=True)
class Difference:
    """The first difference between replay and recorded run, with both values.

    room: the room whose output differs; signal: the field of `Flow`
    """

    tick: int
    room: str
    signal: str
    field: str
    recorded: object
    computed: object

    def __str__(self) -> str:
        return (
            f"tick {self.tick}, room {self.room}, field {self.signal}.{self.field}: "
            f"recorded {self.recorded!r}, now {self.computed!r}"
        )


@dataclass(frozen=True, slots=True)
class ReplayResult:
    """cut_short: the segment ends within a record, as after a kill; the records before it were run."""

    ticks: int
    difference: Difference | None
    cut_short: str = ""


def replay_segment(
    path: Path,
    build_car: BuildCar,
    profile: Profile | None = None,
    progress: Callable[[int], None] = lambda _ticks: None,
) -> ReplayResult:
    """The result of feeding the segment's input tape to a new computer and comparing every output.

    profile  another vehicle profile than the recorded one, to see where the vehicle would drive differently
    Raises RunLogError for a segment that cannot be read or is damaged.
    """
    computer = _computer_at_start(path, build_car, profile)
    decoder = msgspec.msgpack.Decoder(tuple[InboxItem, ...], dec_hook=dec_hook)
    encoder = FlowEncoder()
    count = 0
    try:
        for record in ticks(path):
            if record.tick != computer.state.tick:
                detail = f"{path}: tick {record.tick} follows {computer.state.tick - 1}; ticks are missing"
                raise RunLogError("damaged", detail)
            outputs = computer.run_tick(decoder.decode(record.items), record.stamp_ns, record.late_ns)
            computed = encoder.encode(outputs)
            if bytes(computed) != bytes(record.rooms):
                return ReplayResult(count, _first_difference(record.tick, record.rooms, computed))
            count += 1
            progress(count)
    except RunLogError as error:
        if error.code != "truncated":
            raise
        return ReplayResult(count, None, error.detail)
    return ReplayResult(count, None)


def _computer_at_start(path: Path, build_car: BuildCar, profile: Profile | None) -> VehicleComputer:
    """The computer in the state that the segment begins with."""
    segment = open_segment(path)
    if profile is None:
        profile = msgspec.msgpack.decode(segment.profile, type=Profile)
    car = build_car(profile, decode_map(segment.road_map), segment.header.localization_map)
    try:
        return VehicleComputer(car, decode_state(segment.state, car))
    except msgspec.DecodeError as error:
        raise RunLogError(
            "other_software", f"{path} holds the state of another software version: {error}"
        ) from error


def _first_difference(tick: int, recorded: msgspec.Raw, computed: msgspec.Raw) -> Difference:
    """The first difference in flow order, then in the order of the fields, within structs and lists too."""
    before: dict[str, object] = msgspec.msgpack.decode(recorded)
    after: dict[str, object] = msgspec.msgpack.decode(computed)
    for signal in SIGNALS:
        found = _differing("", before.get(signal), after.get(signal))
        if found is not None:
            field, old, new = found
            return Difference(tick, ROOM_OF[signal], signal, field.lstrip("."), old, new)
    return Difference(tick, "?", "?", "encoding", len(recorded), len(computed))


def _differing(name: str, old: object, new: object) -> tuple[str, object, object] | None:
    if isinstance(old, dict) and isinstance(new, dict):
        keys = list(old) + [key for key in new if key not in old]
        pairs = [(f"{name}.{key}", old.get(key), new.get(key)) for key in keys]
    elif isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        pairs = [(f"{name}[{i}]", a, b) for i, (a, b) in enumerate(zip(old, new, strict=True))]
    else:
        return None if _same(old, new) else (name, old, new)
    for key, a, b in pairs:
        found = _differing(key, a, b)
        if found is not None:
            return found
    return None


def _same(old: object, new: object) -> bool:
    """True if equal bit for bit: nan equals nan, 0.0 differs from -0.0 and 1 from 1.0."""
    return type(old) is type(new) and msgspec.msgpack.encode(old) == msgspec.msgpack.encode(new)
