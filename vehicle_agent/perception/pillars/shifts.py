"""How far objects moved between two turns: the shift by which the older turn's returns lie on the newer's."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from contract.geometry import Array
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


@njit(cache=True)
def shifts_of(kinds: NDArray[np.int64], boxes: Array, points: Array32, is_older: NDArray[np.bool_]) -> Array:
    """(n, 2) shift of each object since the older turn, m; NaN where fewer than 3 returns of either show it.

    boxes (n, 5+) x, y, yaw, length, width at the newer turn; points (m, 2+) of both turns
    Shifts are tried on a grid of 0.1 m, then the best one is refined by nearest returns.
    """
    shifts = np.full((boxes.shape[0], 2), np.nan)
    newer = np.empty((points.shape[0], 2))
    older = np.empty((points.shape[0], 2))
    for row in range(boxes.shape[0]):
        x, y, yaw, length, width = boxes[row, 0], boxes[row, 1], boxes[row, 2], boxes[row, 3], boxes[row, 4]
        cos, sin = math.cos(yaw), math.sin(yaw)
        is_person = kinds[row] == PEDESTRIAN
        along_m = _REACH_PERSON_M if is_person else _REACH_WHEELED_M
        aside_m = _REACH_PERSON_M if is_person else _REACH_ASIDE_M
        n_newer, n_older = 0, 0
        for k in range(points.shape[0]):
            dx, dy = points[k, 0] - x, points[k, 1] - y
            if abs(dx) > 8.0 or abs(dy) > 8.0:
                continue
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
        u, v = _best_shift(newer[:n_newer:stride], older[:n_older], along_m, aside_m)
        u, v = _refined(newer[:n_newer:stride], older[: n_older : max(1, n_older // 400)], u, v)
        shifts[row, 0], shifts[row, 1] = cos * u - sin * v, sin * u + cos * v
    return shifts


@njit(cache=True)
def _best_shift(newer: Array, older: Array, along_m: float, aside_m: float) -> tuple[float, float]:
    """The shift under which most newer returns have an older one near them."""
    near = np.zeros((_GRID, _GRID))
    half = 0.5 * _GRID * _CELL_M
    for k in range(older.shape[0]):
        i, j = int((older[k, 0] + half) / _CELL_M), int((older[k, 1] + half) / _CELL_M)
        if not (0 < i < _GRID - 1 and 0 < j < _GRID - 1):
            continue
        for a in range(i - 1, i + 2):
            for b in range(j - 1, j + 2):
                near[a, b] = max(near[a, b], 1.0 if a == i and b == j else 0.4)
    best, best_u, best_v = -1e9, 0.0, 0.0
    steps_u, steps_v = round(along_m / _STEP_M), round(aside_m / _STEP_M)
    for a in range(-steps_u, steps_u + 1):
        for b in range(-steps_v, steps_v + 1):
            u, v = a * _STEP_M, b * _STEP_M
            total = 0.0
            for k in range(newer.shape[0]):
                i = int((newer[k, 0] - u + half) / _CELL_M)
                j = int((newer[k, 1] - v + half) / _CELL_M)
                if 0 <= i < _GRID and 0 <= j < _GRID:
                    total += near[i, j]
            score = total / newer.shape[0] - _PER_M * math.hypot(u, v)
            if score > best:
                best, best_u, best_v = score, u, v
    return best_u, best_v


@njit(cache=True)
def _refined(newer: Array, older: Array, u: float, v: float) -> tuple[float, float]:
    """The shift after some rounds of nearest returns; those farther than 0.3 m are left out."""
    for _ in range(_ROUNDS):
        sum_u, sum_v, count = 0.0, 0.0, 0
        for k in range(newer.shape[0]):
            least, at = _NEAR_M * _NEAR_M, -1
            for m in range(older.shape[0]):
                du, dv = newer[k, 0] - u - older[m, 0], newer[k, 1] - v - older[m, 1]
                squared = du * du + dv * dv
                if squared < least:
                    least, at = squared, m
            if at >= 0:
                sum_u += newer[k, 0] - u - older[at, 0]
                sum_v += newer[k, 1] - v - older[at, 1]
                count += 1
        if count == 0:
            break
        u += sum_u / count
        v += sum_v / count
    return u, v
