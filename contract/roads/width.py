"""How much room a body has to the left and right of the line that it drives."""

from collections.abc import Sequence

import numpy as np
from numba import njit

from contract.geometry import Array
from contract.roads.model import Building
from contract.roads.network import RoadNetwork
from contract.roads.routing import ReferenceLine

_EVERY_M = 4.0
_NEAR_M = 12.0
_HALF_STEP_M = 0.6
# Half of the narrowest lane of a road on which two shuttles can pass, and of the widest one that is trusted.
_LEAST_HALF_M, _MOST_HALF_M = 1.22, 1.75


def drivable_width(
    network: RoadNetwork, line: ReferenceLine, buildings: Sequence[Building]
) -> tuple[Array, Array]:
    """(left_m, right_m), each (n,) at the line's points: from the line to where a body may no longer be.

    Where two vehicles can pass, a lane's own side alone counts: half the way to the line of the opposite
    direction. Elsewhere the line is the middle of the road and both of its sides count. Buildings cut what
    they stand on. Both are 0 where a wall stands on the line.
    """
    numbers = line.lane_number
    lanes = [network.lanes[lane_id] for lane_id in line.lane_ids]
    halves = np.array([0.5 * lane.width_m for lane in lanes])[numbers]
    passable = np.array([lane.can_pass for lane in lanes])[numbers]
    half_m = np.where(passable, np.minimum(halves, _opposite_half_m(network, line, passable)), halves)
    left_m, right_m = half_m.copy(), half_m.copy()
    segments = _segments(buildings, line.points)
    if len(segments):
        _cut(line.points, _yaws(line.points), segments, left_m, right_m)
    return left_m, right_m


def _opposite_half_m(network: RoadNetwork, line: ReferenceLine, passable: np.ndarray) -> Array:
    """(n,) half the distance to the opposite lane, looked up every few metres."""
    n = len(line.s)
    half: Array = np.full(n, _LEAST_HALF_M)
    yaws = _yaws(line.points)
    picked = sorted(
        {int(i) for i in np.searchsorted(line.s, np.arange(0.0, line.s[-1], _EVERY_M))} | {0, n - 1}
    )
    known = []
    for i in picked:
        if not passable[i]:
            known.append(_LEAST_HALF_M)
            continue
        x_m, y_m = line.points[i]
        opposite = network.locate(float(x_m), float(y_m), float(yaws[i]) + np.pi)
        apart_m = 2.0 * _LEAST_HALF_M if opposite is None else abs(opposite[2])
        known.append(min(max(0.5 * apart_m, _LEAST_HALF_M), _MOST_HALF_M))
    half[:] = np.interp(line.s, line.s[picked], known)
    return half


def _yaws(points: Array) -> Array:
    if len(points) < 2:
        return np.zeros(len(points))
    steps = np.gradient(points, axis=0)
    yaws: Array = np.arctan2(steps[:, 1], steps[:, 0])
    return yaws


def _segments(buildings: Sequence[Building], points: Array) -> Array:
    """(m, 4) walls x0, y0, x1, y1 of the buildings near the points."""
    low, high = points.min(axis=0) - _NEAR_M, points.max(axis=0) + _NEAR_M
    walls = []
    for building in buildings:
        outline = np.array(building.outline, dtype=np.float64)
        if np.any(outline.max(axis=0) < low) or np.any(outline.min(axis=0) > high):
            continue
        walls.append(np.hstack((outline, np.roll(outline, -1, axis=0))))
    found: Array = np.vstack(walls) if walls else np.empty((0, 4))
    return found


@njit(cache=True)
def _cut(points: Array, yaws: Array, segments: Array, left: Array, right: Array) -> None:
    """Lower left and right (n,) to the walls (m, 4) that stand within half a step along each point."""
    for i in range(points.shape[0]):
        cos, sin = np.cos(yaws[i]), np.sin(yaws[i])
        for k in range(segments.shape[0]):
            ax, ay = segments[k, 0] - points[i, 0], segments[k, 1] - points[i, 1]
            bx, by = segments[k, 2] - points[i, 0], segments[k, 3] - points[i, 1]
            u0, v0 = cos * ax + sin * ay, -sin * ax + cos * ay
            u1, v1 = cos * bx + sin * by, -sin * bx + cos * by
            if min(u0, u1) > _HALF_STEP_M or max(u0, u1) < -_HALF_STEP_M:
                continue
            t0, t1 = 0.0, 1.0
            if u1 != u0:
                ta, tb = (-_HALF_STEP_M - u0) / (u1 - u0), (_HALF_STEP_M - u0) / (u1 - u0)
                t0, t1 = max(t0, min(ta, tb)), min(t1, max(ta, tb))
            va, vb = v0 + t0 * (v1 - v0), v0 + t1 * (v1 - v0)
            if max(va, vb) >= 0.0:
                left[i] = min(left[i], max(0.0, min(va, vb)))
            if min(va, vb) <= 0.0:
                right[i] = min(right[i], max(0.0, -max(va, vb)))
