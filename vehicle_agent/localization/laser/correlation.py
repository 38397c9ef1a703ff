"""Correlative scan matching (Olson 2009): the best pose in a window, whatever the start.

A raster holds how near each cell is to a reference point. A pose's score is the mean over the scan's points.
Coarse cells hold the greatest value that any of their shifts can reach, so that a coarse score is a bound and
the search finds the window's true maximum.
"""

import math

import msgspec
import numpy as np
from numba import njit
from numpy.typing import NDArray

from contract.geometry import Array

Float32Array = NDArray[np.float32]

_COARSE = 8
_RASTER_CELLS_MAX = 30_000_000


class Raster(msgspec.Struct, frozen=True):
    """nearness (rows, columns) 0..1, float32, 1 at a reference point; cell [0, 0] begins at the origin.

    bounds  (rows, columns) the greatest nearness of the square of 8 x 8 cells that begins at each cell
    """

    nearness: Float32Array
    bounds: Float32Array
    origin_x_m: float
    origin_y_m: float
    cell_m: float


class SearchWindow(msgspec.Struct, frozen=True):
    """What is searched around a pose: +-reach_m in x and y, +-reach_rad in direction."""

    reach_m: float
    reach_rad: float


class Correlation(msgspec.Struct, frozen=True):
    """pose (3,) of the greatest score; score 0..1: mean nearness of the scan's points there."""

    pose: Array
    score: float


def rasterized(points: Array, cell_m: float, std_m: float, margin_m: float) -> Raster:
    """The raster of (n, 2) points, one empty cell without any; nearness falls like a Gaussian of std_m.

    margin_m: of empty cells around the points
    """
    if not len(points):
        empty = np.zeros((1, 1), dtype=np.float32)
        return Raster(empty, empty, 0.0, 0.0, cell_m)
    low, high = points.min(axis=0) - margin_m, points.max(axis=0) + margin_m
    columns, rows = (int(count) + 1 for count in np.ceil((high - low) / cell_m))
    assert columns * rows <= _RASTER_CELLS_MAX, "points lie too far apart for one raster"
    nearness = np.zeros((rows, columns), dtype=np.float32)
    _stamp(nearness, points, low[0], low[1], cell_m, std_m)
    return Raster(nearness, _bounds(nearness), float(low[0]), float(low[1]), cell_m)


def correlate(
    points_laser: Array, raster: Raster, start: Array, window: SearchWindow, penalty: Array
) -> Correlation:
    """The pose in the window with the greatest score less its penalty.

    points_laser  (n, 2) of the scan
    start         (3,) centre of the window
    penalty       (2,) score taken away for a deviation of the window's whole reach: (position, direction)
    """
    if not len(points_laser):
        return Correlation(np.asarray(start, dtype=np.float64).copy(), 0.0)
    farthest_m = float(np.hypot(points_laser[:, 0], points_laser[:, 1]).max())
    step_rad = raster.cell_m / max(farthest_m, 1.0)
    turns = max(1, math.ceil(window.reach_rad / step_rad))
    cells = max(1, math.ceil(window.reach_m / raster.cell_m))
    pose, score = _search(
        points_laser,
        raster.nearness,
        raster.bounds,
        raster.origin_x_m,
        raster.origin_y_m,
        raster.cell_m,
        np.asarray(start, dtype=np.float64),
        cells,
        turns,
        window.reach_rad / turns,
        penalty[0],
        penalty[1],
    )
    return Correlation(pose, score)


@njit(cache=True)
def _stamp(
    nearness: Float32Array, points: Array, origin_x_m: float, origin_y_m: float, cell_m: float, std_m: float
) -> None:
    reach = math.ceil(2.5 * std_m / cell_m)
    rows, columns = nearness.shape
    for i in range(points.shape[0]):
        column = int((points[i, 0] - origin_x_m) / cell_m)
        row = int((points[i, 1] - origin_y_m) / cell_m)
        for r in range(max(0, row - reach), min(rows, row + reach + 1)):
            dy = (r + 0.5) * cell_m + origin_y_m - points[i, 1]
            for c in range(max(0, column - reach), min(columns, column + reach + 1)):
                dx = (c + 0.5) * cell_m + origin_x_m - points[i, 0]
                value = math.exp(-0.5 * (dx * dx + dy * dy) / (std_m * std_m))
                nearness[r, c] = max(nearness[r, c], np.float32(value))


@njit(cache=True)
def _bounds(nearness: Float32Array) -> Float32Array:
    """bounds[r, c] = max of nearness[r .. r + 7, c .. c + 7]: what any shift of a coarse step can reach."""
    rows, columns = nearness.shape
    along = np.zeros_like(nearness)
    for r in range(rows):
        for c in range(columns):
            best = nearness[r, c]
            for k in range(1, min(_COARSE, columns - c)):
                best = max(best, nearness[r, c + k])
            along[r, c] = best
    out = np.zeros_like(nearness)
    for r in range(rows):
        last = min(_COARSE, rows - r)
        for c in range(columns):
            best = along[r, c]
            for k in range(1, last):
                best = max(best, along[r + k, c])
            out[r, c] = best
    return out


@njit(cache=True)
def _search(
    points: Array,
    nearness: Float32Array,
    bounds: Float32Array,
    origin_x_m: float,
    origin_y_m: float,
    cell_m: float,
    start: Array,
    cells: int,
    turns: int,
    step_rad: float,
    position_penalty: float,
    turn_penalty: float,
) -> tuple[Array, float]:
    n = points.shape[0]
    rows, columns = nearness.shape
    coarse = (2 * cells + 1 + _COARSE - 1) // _COARSE
    candidates = (2 * turns + 1) * coarse * coarse
    scores = np.empty(candidates)
    at_rows = np.empty((2 * turns + 1, n), dtype=np.int64)
    at_columns = np.empty((2 * turns + 1, n), dtype=np.int64)
    k = 0
    for turn in range(2 * turns + 1):
        yaw = start[2] + (turn - turns) * step_rad
        cos, sin = math.cos(yaw), math.sin(yaw)
        for i in range(n):
            x = start[0] + cos * points[i, 0] - sin * points[i, 1] - origin_x_m
            y = start[1] + sin * points[i, 0] + cos * points[i, 1] - origin_y_m
            at_columns[turn, i] = math.floor(x / cell_m)
            at_rows[turn, i] = math.floor(y / cell_m)
        deviation = abs(turn - turns) / turns
        for block_y in range(coarse):
            for block_x in range(coarse):
                shift_y, shift_x = block_y * _COARSE - cells, block_x * _COARSE - cells
                total = 0.0
                for i in range(n):
                    # A cell before the raster's first can reach into it by a shift.
                    r = at_rows[turn, i] + shift_y
                    c = at_columns[turn, i] + shift_x
                    if -_COARSE < r < rows and -_COARSE < c < columns:
                        total += bounds[max(r, 0), max(c, 0)]
                scores[k] = total / n - turn_penalty * deviation * deviation
                k += 1
    order = np.argsort(-scores)
    best_score = -1e9
    best = (turns, 0, 0)
    for at in range(candidates):
        candidate = order[at]
        if scores[candidate] <= best_score:
            break
        turn = candidate // (coarse * coarse)
        block = candidate % (coarse * coarse)
        deviation = abs(turn - turns) / turns
        first_y = (block // coarse) * _COARSE - cells
        first_x = (block % coarse) * _COARSE - cells
        for shift_y in range(first_y, min(first_y + _COARSE, cells + 1)):
            for shift_x in range(first_x, min(first_x + _COARSE, cells + 1)):
                total = 0.0
                for i in range(n):
                    r = at_rows[turn, i] + shift_y
                    c = at_columns[turn, i] + shift_x
                    if 0 <= r < rows and 0 <= c < columns:
                        total += nearness[r, c]
                away = (shift_x * shift_x + shift_y * shift_y) / (cells * cells)
                score = total / n - turn_penalty * deviation * deviation - position_penalty * away
                if score > best_score:
                    best_score = score
                    best = (turn, shift_y, shift_x)
    turn, shift_y, shift_x = best
    pose = np.array(
        [start[0] + shift_x * cell_m, start[1] + shift_y * cell_m, start[2] + (turn - turns) * step_rad]
    )
    total = 0.0
    for i in range(n):
        r, c = at_rows[turn, i] + shift_y, at_columns[turn, i] + shift_x
        if 0 <= r < rows and 0 <= c < columns:
            total += nearness[r, c]
    return pose, total / n
