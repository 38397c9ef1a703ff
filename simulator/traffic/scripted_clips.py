"""Synthetic recordings: tracks that follow places at constant speed, by the clock.

For actors that wait for the shuttle, or that stop and start, see `simulator.traffic.scripted`.
"""

import itertools
import math
from collections.abc import Sequence

import numpy as np

from contract.geometry import Array
from simulator.traffic.recordings import Clip, RecordedTrack
from vehicle_agent.signals import CYCLIST, PEDESTRIAN, VEHICLE

SIZES_M = {PEDESTRIAN: (0.5, 0.5), CYCLIST: (1.8, 0.6), VEHICLE: (4.5, 1.8)}
CHILD_SIZE_M = (0.4, 0.4)
# Long enough for every scene.
_LASTS_S = 120.0


def walker(
    number: int,
    kind: int,
    places: tuple[tuple[float, float], ...],
    speed_mps: float,
    begins_s: float = 0.0,
    size_m: tuple[float, float] | None = None,
) -> RecordedTrack:
    """A track that stands at the first place until begins_s, then follows the places to the last one.

    ValueError for fewer than two places or a speed that is not positive.
    """
    if len(places) < 2 or speed_mps <= 0.0:
        raise ValueError(f"a walker needs two places and a positive speed, not {places} at {speed_mps} m/s")
    rows: list[tuple[float, ...]] = []
    t = begins_s = begins_s if begins_s > 1e-3 else 0.0
    yaw = math.atan2(places[1][1] - places[0][1], places[1][0] - places[0][0])
    if begins_s > 0.0:
        rows.append((0.0, *places[0], yaw, 0.0, 0.0))
        rows.append((begins_s - 1e-3, *places[0], yaw, 0.0, 0.0))
    for (x0, y0), (x1, y1) in itertools.pairwise(places):
        yaw = math.atan2(y1 - y0, x1 - x0)
        vx, vy = speed_mps * math.cos(yaw), speed_mps * math.sin(yaw)
        rows.append((t, x0, y0, yaw, vx, vy))
        t += math.hypot(x1 - x0, y1 - y0) / speed_mps
        rows.append((t - 1e-3, x1, y1, yaw, vx, vy))
    rows.append((t, *places[-1], yaw, 0.0, 0.0))
    rows.append((max(_LASTS_S, t + 1.0), *places[-1], yaw, 0.0, 0.0))
    return _recorded(number, kind, rows, size_m)


def standing(
    number: int,
    kind: int,
    x_m: float,
    y_m: float,
    yaw_rad: float = 0.0,
    size_m: tuple[float, float] | None = None,
) -> RecordedTrack:
    """A track that does not move."""
    rows = [(0.0, x_m, y_m, yaw_rad, 0.0, 0.0), (_LASTS_S, x_m, y_m, yaw_rad, 0.0, 0.0)]
    return _recorded(number, kind, rows, size_m)


def _recorded(
    number: int, kind: int, rows: Sequence[tuple[float, ...]], size_m: tuple[float, float] | None
) -> RecordedTrack:
    table: Array = np.array(rows)
    return RecordedTrack(number, kind, table[:, 0].copy(), table[:, 1:].copy(), size_m or SIZES_M[kind])


def clip_of(name: str, tracks: tuple[RecordedTrack, ...]) -> Clip:
    """The tracks as a recording."""
    return Clip(name, tracks, _LASTS_S)
