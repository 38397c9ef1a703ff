"""The waypoints of a recorded run, driven by hand or by the shuttle."""

from collections.abc import Sequence
from pathlib import Path

import msgspec

from contract.roads.load import decode_map
from contract.roads.model import Origin
from contract.runlog.reader import RunLogError, open_segment, ticks
from vehicle_agent.signals import Ego
from vehicle_agent.waypoints.recorder import Waypoint, WaypointRecorder


class _Localized(msgspec.Struct):
    """The part of a tick's record that is read."""

    ego: Ego


def recorded_waypoints(
    segments: Sequence[Path], spacing_m: float = 1.0
) -> tuple[tuple[Waypoint, ...], Origin]:
    """(a waypoint every spacing_m along the segments, in the given order; the origin of their frame).

    Raises RunLogError for a segment that cannot be read, and `other_map` if the origins differ.
    """
    recorder = WaypointRecorder(spacing_m)
    decoder = msgspec.msgpack.Decoder(_Localized)
    origin: Origin | None = None
    for path in segments:
        segment_origin = decode_map(open_segment(path).road_map).origin
        if origin is not None and segment_origin != origin:
            raise RunLogError("other_map", f"{path} was recorded on a map with another origin")
        origin = segment_origin
        for record in ticks(path):
            recorder.observe(decoder.decode(record.rooms).ego)
    if origin is None:
        raise RunLogError("empty", "no segments were given")
    return tuple(recorder.waypoints), origin
