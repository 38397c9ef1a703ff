"""Hidden ground that an infrastructure camera has seen to be free of people."""

import numpy as np

from contract.geometry import Array
from contract.roads.areas import inside
from vehicle_agent.planning.behaviour.occlusion import H_BESIDE, H_CLEARED, PathStations
from vehicle_agent.signals import WatchedArea

# Older pictures say nothing; a camera at 1 Hz with its latency is younger.
PICTURE_AGE_NS_MAX = 1_500_000_000


def with_cleared_ground(
    hidden: Array,
    path: PathStations,
    watched: tuple[WatchedArea, ...],
    stamp_ns: int,
    half_m: float,
    reach_m: float,
    step_m: float,
    run_mps: float,
) -> Array:
    """(n, 4) the hidden places, with how far beside the body the ground is cleared.

    On both sides, for the side of a hidden place is not known; less the way of a runner since the picture.
    """
    cleared = hidden.copy()
    rows = np.flatnonzero(np.isfinite(hidden[:, H_BESIDE]))
    if not len(rows):
        return cleared
    steps_m = np.arange(0.0, reach_m + step_m, step_m)
    normals = np.column_stack((-np.sin(path.yaws[rows]), np.cos(path.yaws[rows])))
    middles = path.points[rows] + path.offsets[rows, None] * normals
    sides_m = np.concatenate((half_m + steps_m, -half_m - steps_m))
    places = middles[:, None, :] + sides_m[None, :, None] * normals[:, None, :]
    for area in watched:
        age_ns = stamp_ns - area.clear_ns
        if not area.clear_ns or not area.outline or age_ns > PICTURE_AGE_NS_MAX:
            continue
        free = inside(np.array(area.outline), np.ascontiguousarray(places.reshape(-1, 2)))
        left, right = free.reshape(len(rows), 2, len(steps_m)).swapaxes(0, 1)
        both = left & right
        # The last free step; where all are free, what lies beyond is too far away to matter.
        free_m = np.where(both.all(axis=-1), np.inf, (np.argmin(both, axis=-1) - 1) * step_m)
        free_m -= run_mps * max(age_ns, 0) * 1e-9
        cleared[rows, H_CLEARED] = np.maximum(cleared[rows, H_CLEARED], free_m)
    return cleared
