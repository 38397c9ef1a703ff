"""Kerbs in the points of one scan: steps of the ground that a wheel should not meet."""

import numpy as np
from numba import njit

from contract.geometry import Array
from vehicle_agent.perception.points.grid import PointGrid

# Farther away rings are too far apart to show a step.
REACH_M = 12.0
# A step from the lowest return of a cell to those of the cells around it, above the smoothed ground, which
# follows grades, and a kerb a little. What is higher is an obstacle, m.
STEP_M = (0.055, 0.22)
# A step inside a cell: highest and lowest of many returns are apart by their noise as well.
INSIDE_M = 0.09
# So near to an obstacle, in cells, a step is its foot.
_APART_CELLS = 2


@njit(cache=True)
def kerb_cells(heights_m: np.ndarray, cell_of: np.ndarray, obstacle: np.ndarray, grid: PointGrid) -> Array:
    """(k, 2) places of steps, base frame.

    heights_m (n,), cell_of (n,), obstacle (r, c) as `PointHeights` has them
    """
    rows, columns = obstacle.shape
    low, high = np.full((rows, columns), np.inf), np.full((rows, columns), -np.inf)
    for p in range(len(cell_of)):
        if cell_of[p] >= 0 and heights_m[p] <= grid.above_m:
            i, j = cell_of[p] // columns, cell_of[p] % columns
            low[i, j] = min(low[i, j], heights_m[p])
            high[i, j] = max(high[i, j], heights_m[p])
    found = np.empty((rows * columns, 2))
    count = 0
    for i in range(1, rows - 1):
        x = (i + 0.5) * grid.cell_m - grid.reach_back_m
        if abs(x) > REACH_M:
            continue
        for j in range(1, columns - 1):
            y = (j + 0.5) * grid.cell_m - grid.reach_side_m
            step = high[i, j] - low[i, j]
            if not 0.0 <= step <= STEP_M[1] or abs(y) > REACH_M:
                continue
            up_i, up_j = i, j
            if step < INSIDE_M:
                step = 0.0
                for a in range(i - 1, i + 2):
                    for b in range(j - 1, j + 2):
                        if np.isfinite(low[a, b]) and low[a, b] - low[i, j] > step:
                            step, up_i, up_j = low[a, b] - low[i, j], a, b
            if STEP_M[0] <= step <= STEP_M[1] and not _is_any_near(obstacle, i, j):
                # The face is somewhere between the two cells, or in the one.
                found[count, 0] = x + 0.5 * (up_i - i) * grid.cell_m
                found[count, 1] = y + 0.5 * (up_j - j) * grid.cell_m
                count += 1
    return found[:count].copy()


@njit(cache=True)
def _is_any_near(obstacle: np.ndarray, i: int, j: int) -> bool:
    for a in range(max(0, i - _APART_CELLS), min(obstacle.shape[0], i + _APART_CELLS + 1)):
        for b in range(max(0, j - _APART_CELLS), min(obstacle.shape[1], j + _APART_CELLS + 1)):
            if obstacle[a, b]:
                return True
    return False
