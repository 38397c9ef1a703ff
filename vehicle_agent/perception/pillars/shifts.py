"""How far objects moved between two turns: the shift by which the older turn's returns lie on the newer's."""

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from contract.geometry import Array, IntArray
from vehicle_agent.signals import PEDESTRIAN

Array32 = NDArray[np.float32]

# Returns this far outside a box belong to it.
_BESIDE_M = 0.15
# Shifts that are tried: of people in all directions, of what has wheels along its yaw and a little aside.
_REACH_PERSON_M, _REACH_WHEELED_M, _REACH_ASIDE_M, _STEP_M = 0.7, 2.4, 0.2, 0.1
_CELL_M = 0.1
_POINTS_MIN, _POINTS_MAX = 3, 100
# A shift must explain so much more for each metre: what shows a plain wall may stand.
_PER_M = 0.12
_NEAR_M = 0.3
_ROUNDS = 3
_GRID = 96
# How returns are sorted, so that those about an object are found without a look at all of them.
_STRIP_M = 1.0
_REACH_MAX_M = 8.0


@njit(cache=True)
def shifts_of(kinds: NDArray[np.int64], boxes: Array, points: Array32, is_older: NDArray[np.bool_]) -> Array:
    """(n, 2) shift of each object since the older turn, m; NaN where fewer than 3 returns of either show it.

    boxes (n, 5+) x, y, yaw, length, width at the newer turn; points (m, 2+) of both turns, finite, as
    `standing_points` leaves them
    Shifts are tried on a grid of 0.1 m, then the best one is refined by nearest returns.
    """
    shifts = np.full((boxes.shape[0], 2), np.nan)
    newer = np.empty((points.shape[0], 2))
    older = np.empty((points.shape[0], 2))
    strips = _in_strips(points)
    near = np.zeros((_GRID + 1, _GRID + 1))
    for row in range(boxes.shape[0]):
        x, y, yaw, length, width = boxes[row, 0], boxes[row, 1], boxes[row, 2], boxes[row, 3], boxes[row, 4]
        cos, sin = math.cos(yaw), math.sin(yaw)
        is_person = kinds[row] == PEDESTRIAN
        along_m = _REACH_PERSON_M if is_person else _REACH_WHEELED_M
        aside_m = _REACH_PERSON_M if is_person else _REACH_ASIDE_M
        reach_m = math.hypot(0.5 * length + along_m, 0.5 * width + aside_m) + 2.0 * _BESIDE_M
        n_newer, n_older = 0, 0
        for k in _about(strips, x, y, min(reach_m, _REACH_MAX_M), points):
            dx, dy = points[k, 0] - x, points[k, 1] - y
            # In the box's own frame from here on.
            u, v = cos * dx + sin * dy, -sin * dx + cos * dy
            over_u, over_v = abs(u) - 0.5 * length - _BESIDE_M, abs(v) - 0.5 * width - _BESIDE_M
            if is_older[k]:
                if over_u < along_m and over_v < aside_m:
                    older[n_older, 0], older[n_older, 1] = u, v
                    n_older += 1
            elif over_u < 0.0 and over_v < 0.0:
                newer[n_newer, 0], newer[n_newer, 1] = u, v
                n_newer += 1
        if n_newer < _POINTS_MIN or n_older < _POINTS_MIN:
            continue
        stride = max(1, n_newer // _POINTS_MAX)
        u, v = _best_shift(newer[:n_newer:stride], older[:n_older], along_m, aside_m, near)
        u, v = _refined(newer[:n_newer:stride], older[: n_older : max(1, n_older // 400)], u, v)
        shifts[row, 0], shifts[row, 1] = cos * u - sin * v, sin * u + cos * v
    return shifts


class _Strips(NamedTuple):
    """Points by strips of _STRIP_M across x, from low_m on.

    Those of strip i are order[first[i]:first[i + 1]].
    """

    low_m: float
    first: IntArray
    order: IntArray


@njit(cache=True)
def _in_strips(points: Array32) -> _Strips:
    low_m, high_m = np.inf, -np.inf
    for k in range(points.shape[0]):
        low_m, high_m = min(low_m, float(points[k, 0])), max(high_m, float(points[k, 0]))
    count = int((high_m - low_m) / _STRIP_M) + 1 if points.shape[0] else 0
    first = np.zeros(count + 1, np.int64)
    for k in range(points.shape[0]):
        first[int((points[k, 0] - low_m) / _STRIP_M) + 1] += 1
    first = np.cumsum(first)
    order, filled = np.empty(points.shape[0], np.int64), first.copy()
    for k in range(points.shape[0]):
        strip = int((points[k, 0] - low_m) / _STRIP_M)
        order[filled[strip]] = k
        filled[strip] += 1
    return _Strips(low_m, first, order)


@njit(cache=True)
def _about(strips: _Strips, x: float, y: float, reach_m: float, points: Array32) -> IntArray:
    """The points in the square of reach_m around (x, y), in their order."""
    last = strips.first.shape[0] - 2
    found, count = np.empty(256, np.int64), 0
    begin = max(0, math.floor((x - reach_m - strips.low_m) / _STRIP_M))
    end = min(last, math.floor((x + reach_m - strips.low_m) / _STRIP_M))
    for strip in range(begin, end + 1):
        for i in range(strips.first[strip], strips.first[strip + 1]):
            k = strips.order[i]
            if abs(points[k, 0] - x) > reach_m or abs(points[k, 1] - y) > reach_m:
                continue
            if count == found.shape[0]:
                found = np.concatenate((found, np.empty_like(found)))
            found[count] = k
            count += 1
    return np.sort(found[:count])


@njit(cache=True)
def _best_shift(
    newer: Array, older: Array, along_m: float, aside_m: float, near: Array
) -> tuple[float, float]:
    """The shift under which most newer returns have an older one near them.

    near (_GRID + 1, _GRID + 1): room to work in. Its last row and column are all that is beyond the grid, and
    count nothing.
    """
    near[:] = 0.0
    half = 0.5 * _GRID * _CELL_M
    for k in range(older.shape[0]):
        i, j = int((older[k, 0] + half) / _CELL_M), int((older[k, 1] + half) / _CELL_M)
        if not (0 < i < _GRID - 1 and 0 < j < _GRID - 1):
            continue
        for a in range(i - 1, i + 2):
            for b in range(j - 1, j + 2):
                near[a, b] = max(near[a, b], 1.0 if a == i and b == j else 0.4)
    steps_u, steps_v = round(along_m / _STEP_M), round(aside_m / _STEP_M)
    rows, columns = _cells_after(newer[:, 0], steps_u), _cells_after(newer[:, 1], steps_v)
    best, best_u, best_v = -1e9, 0.0, 0.0
    for a in range(2 * steps_u + 1):
        for b in range(2 * steps_v + 1):
            u, v = (a - steps_u) * _STEP_M, (b - steps_v) * _STEP_M
            total = 0.0
            for k in range(newer.shape[0]):
                total += near[rows[a, k], columns[b, k]]
            score = total / newer.shape[0] - _PER_M * math.hypot(u, v)
            if score > best:
                best, best_u, best_v = score, u, v
    return best_u, best_v


@njit(cache=True)
def _cells_after(places: Array, steps: int) -> IntArray:
    """(2 steps + 1, n) the cell of each place (n,) when it is taken back by each shift; _GRID is beyond."""
    cells = np.empty((2 * steps + 1, places.shape[0]), np.int64)
    half = 0.5 * _GRID * _CELL_M
    for a in range(2 * steps + 1):
        shift = (a - steps) * _STEP_M
        for k in range(places.shape[0]):
            cell = int((places[k] - shift + half) / _CELL_M)
            cells[a, k] = cell if 0 <= cell < _GRID else _GRID
    return cells


@njit(cache=True)
def _refined(newer: Array, older: Array, u: float, v: float) -> tuple[float, float]:
    """The shift after some rounds of nearest returns; those farther than 0.3 m are left out."""
    older = older[np.argsort(older[:, 0])]
    for _ in range(_ROUNDS):
        sum_u, sum_v, count = 0.0, 0.0, 0
        for k in range(newer.shape[0]):
            at = _nearest(newer[k, 0] - u, newer[k, 1] - v, older)
            if at >= 0:
                sum_u += newer[k, 0] - u - older[at, 0]
                sum_v += newer[k, 1] - v - older[at, 1]
                count += 1
        if count == 0:
            break
        u += sum_u / count
        v += sum_v / count
    return u, v


@njit(cache=True)
def _nearest(x: float, y: float, places: Array) -> int:
    """The nearest of the places (n, 2) that is less than _NEAR_M from (x, y), -1 for none.

    They are in order of their first coordinate.
    """
    least, at = _NEAR_M * _NEAR_M, -1
    middle = np.searchsorted(places[:, 0], x)
    for k in range(middle, places.shape[0]):
        dx, dy = places[k, 0] - x, places[k, 1] - y
        if dx * dx >= least:
            break
        if dx * dx + dy * dy < least:
            least, at = dx * dx + dy * dy, k
    for k in range(middle - 1, -1, -1):
        dx, dy = places[k, 0] - x, places[k, 1] - y
        if dx * dx >= least:
            break
        if dx * dx + dy * dy < least:
            least, at = dx * dx + dy * dy, k
    return at
