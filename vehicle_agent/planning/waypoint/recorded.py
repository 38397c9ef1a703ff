"""A recorded way on an order's line: its places and speeds at the line's arc lengths (GEM, section IV)."""

import msgspec
import numpy as np

from contract.geometry import Array, IntArray
from contract.roads.routing import ReferenceLine
from vehicle_agent.planning.waypoint.waypoints import (
    WaypointRules,
    Waypoints,
    limited_speeds,
    waypoints_from_line,
)

# A recording farther beside the line is of another lane; one with a longer gap is not followed.
BESIDE_M_MAX, GAP_M_MAX = 1.5, 5.0


class RecordedWay(msgspec.Struct, frozen=True):
    """points_map (n, 2) in the order driven, speeds_mps (n,)."""

    points_map: np.ndarray
    speeds_mps: np.ndarray


def waypoints_on_line(
    recorded: RecordedWay, line: ReferenceLine, from_s_m: float, rules: WaypointRules
) -> tuple[Waypoints, float]:
    """(waypoints a metre apart, how far along the line they are recorded ones).

    From from_s_m on they are the recorded places abreast of the line, without a gap. Beyond the recording the
    speed is 0. A line that is not covered at from_s_m is not covered at all.
    """
    road = waypoints_from_line(line, rules)
    needed = np.flatnonzero((road.s_m >= from_s_m) & (road.s_m <= line.s[-1]))
    points, speeds = road.points_map.copy(), road.speeds_mps.copy()
    places, allowed_mps, is_there = _abreast(recorded, road.points_map, needed)
    count = len(needed) if is_there.all() else int(np.argmin(is_there))
    covered = needed[:count]
    points[covered], speeds[covered] = places[:count], np.minimum(allowed_mps[:count], speeds[covered])
    # The rest goes on beside the line as the recording ends.
    last = int(covered[-1]) if count else -1
    points[last + 1 :] += points[last] - road.points_map[last] if count else 0.0
    if count < len(needed):
        speeds[last + 1 :] = 0.0
    covered_m = float(line.s[-1]) if count == len(needed) else float(road.s_m[last]) if count else 0.0
    straight = np.zeros(len(points))
    speeds = limited_speeds(road.s_m, straight, speeds, rules.lateral_accel_mps2, rules.decel_mps2)
    return Waypoints(points, road.s_m, speeds), covered_m


def _abreast(recorded: RecordedWay, points: Array, needed: IntArray) -> tuple[Array, Array, Array]:
    """(places, speeds, found) of the recording abreast of points[needed], between two recorded waypoints."""
    tangents = np.gradient(points, axis=0)
    tangents = (tangents / np.hypot(*tangents.T)[:, None])[needed]
    way = _with_run_out(recorded)
    starts, steps = way.points_map[:-1], np.diff(way.points_map, axis=0)
    # Along the tangent at each point: (n, m) where each recorded segment begins, and its length.
    begins = tangents @ starts.T - np.einsum("ij,ij->i", tangents, points[needed])[:, None]
    lengths = tangents @ steps.T
    # A recorded segment leads the same way, and is crossed by the normal at the point.
    crossed = (lengths > 1e-6) & (begins <= 1e-6) & (begins + lengths >= -1e-6)
    share = np.clip(-begins / np.where(crossed, lengths, 1.0), 0.0, 1.0)
    normals = np.column_stack((-tangents[:, 1], tangents[:, 0]))
    beside = normals @ starts.T - np.einsum("ij,ij->i", normals, points[needed])[:, None]
    beside = np.where(crossed, np.abs(beside + share * (normals @ steps.T)), np.inf)
    best = np.argmin(beside, axis=1)
    rows = np.arange(len(needed))
    at = share[rows, best]
    places = starts[best] + at[:, None] * steps[best]
    speeds = way.speeds_mps[best] + at * np.diff(way.speeds_mps)[best]
    return places, speeds, beside[rows, best] <= BESIDE_M_MAX


def _with_run_out(recorded: RecordedWay) -> RecordedWay:
    """The way, straight on at both ends for half a gap: recording begins and ends between two waypoints."""
    points, speeds = recorded.points_map, recorded.speeds_mps
    first, last = points[0] - points[1], points[-1] - points[-2]
    first, last = first / np.hypot(*first), last / np.hypot(*last)
    run_out_m = 0.5 * GAP_M_MAX
    return RecordedWay(
        np.vstack((points[:1] + run_out_m * first, points, points[-1:] + run_out_m * last)),
        np.concatenate((speeds[:1], speeds, speeds[-1:])),
    )
