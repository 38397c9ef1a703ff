"""Returns that stand out of the ground, gathered in small cells."""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from vehicle_agent.perception.points.cells import PointHeights
from vehicle_agent.perception.points.grid import PointGrid

# Small cells to a cell of the grid, along each side.
FINE = 2
# Columns of `FineCells.values`.
X, Y, TOP, LOW, TALL, COUNT, UPPER = range(7)
VALUES = 7
# Returns above this are of a body, not of feet or things on the ground.
_UPPER_M = 0.8
# As far up as the height of a post or trunk is looked at; crowns begin higher.
_TALL_M = 2.7
# The ground's own roughness.
_FLOOR_M = 0.2


class FineCells(NamedTuple):
    """The small cells with returns above the ground.

    places (k, 2) int32      row and column
    number_at (r, c) int32   number of the cell there, -1 without returns
    values (k, 7) float32    mean x, y; highest and lowest return that does not pass over the vehicle; highest
                             up to 2.7 m; number of returns, and of those above 0.8 m
    """

    places: np.ndarray
    number_at: np.ndarray
    values: np.ndarray


def fine_cells(points: np.ndarray, heights: PointHeights, grid: PointGrid) -> FineCells:
    """The returns of the obstacle cells; points (n, 3) float32, base frame, as `heights` was made of."""
    return FineCells(*_gather(points, heights.heights_m, heights.cell_of, heights.is_obstacle, grid))


@njit(cache=True)
def _gather(
    points: np.ndarray, heights: np.ndarray, cell_of: np.ndarray, is_obstacle: np.ndarray, grid: PointGrid
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    columns = is_obstacle.shape[1]
    index = np.full((is_obstacle.shape[0] * FINE, columns * FINE), -1, np.int32)
    chosen = 0
    for p in range(points.shape[0]):
        cell = cell_of[p]
        if cell >= 0 and heights[p] > _FLOOR_M and is_obstacle[cell // columns, cell % columns]:
            chosen += 1
    places = np.empty((chosen, 2), np.int32)
    values = np.empty((chosen, VALUES), np.float32)
    per_m = FINE / grid.cell_m
    found = 0
    for p in range(points.shape[0]):
        cell = cell_of[p]
        height = heights[p]
        if cell < 0 or not _FLOOR_M < height <= max(grid.above_m, _TALL_M):
            continue
        if not is_obstacle[cell // columns, cell % columns]:
            continue
        i = min(int((points[p, 0] + grid.reach_back_m) * per_m), index.shape[0] - 1)
        j = min(int((points[p, 1] + grid.reach_side_m) * per_m), index.shape[1] - 1)
        k = index[i, j]
        if k < 0:
            if height > grid.above_m:
                # Crowns alone make no cell; a later return of the same turn may.
                continue
            k = found
            index[i, j] = k
            places[k, 0], places[k, 1] = i, j
            values[k] = 0.0
            values[k, LOW] = 99.0
            found += 1
        values[k, TALL] = max(values[k, TALL], height)
        if height > grid.above_m:
            continue
        values[k, X] += points[p, 0]
        values[k, Y] += points[p, 1]
        values[k, TOP] = max(values[k, TOP], height)
        values[k, LOW] = min(values[k, LOW], height)
        values[k, COUNT] += 1.0
        if height > _UPPER_M:
            values[k, UPPER] += 1.0
    for k in range(found):
        values[k, X] /= values[k, COUNT]
        values[k, Y] /= values[k, COUNT]
    return places[:found].copy(), index, values[:found].copy()


@njit(cache=True)
def cells_apart(values: np.ndarray, k: int, near_cells: int, far_cells: int, per_m: float) -> int:
    """How many cells a gap inside one object may be wide at this cell's distance."""
    apart = math.hypot(values[k, X], values[k, Y])
    return near_cells if apart < 12.0 else min(far_cells, near_cells + int((apart - 12.0) * per_m) + 1)
