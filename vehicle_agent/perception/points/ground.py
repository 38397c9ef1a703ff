"""The height of the ground around the vehicle, block by block.

The ground grows outwards from the vehicle, which stands on it: a block's lowest returns are ground if they
are near the height that the blocks known so far expect there. So roofs, hedges and reflections below the
road do not become ground, while slopes, crowns and kerbs do.
"""

import math

import numpy as np
from numba import njit

from vehicle_agent.perception.points.grid import BLOCK, PointGrid

EMPTY = np.float32(3.4e38)
_NOT_YET, _UNSEEN, _SEEN = 0, 1, 2
# The slope that smoothing believes in: a block whose ground is higher than its neighbours' by more is none.
_CONE = 0.25
_CONE_M = 0.12
# Weight of a block without returns when heights are smoothed.
_UNSEEN_WEIGHT = 0.15
# Rings are up to ten blocks apart.
_FILL_SWEEPS = 10
# Blocks without returns widen what the next one may differ by; up to this.
_GAPS_MAX = 5


@njit(cache=True)
def lowest_returns(points: np.ndarray, grid: PointGrid) -> tuple[np.ndarray, np.ndarray]:
    """((rows, columns) float32 lowest return of each cell, (n,) int32 cell of each point or -1).

    points  (n, 3) float32, base frame. Points outside the grid, on the vehicle and not finite have no cell.
    """
    cell_m, back_m, side_m = grid.cell_m, grid.reach_back_m, grid.reach_side_m
    front_m = grid.body_front_m + grid.body_margin_m
    rear_m = grid.body_back_m + grid.body_margin_m + grid.body_trail_m
    half_m = grid.body_half_width_m + grid.body_margin_m
    rows, columns = grid_shape(grid)
    lowest = np.full((rows, columns), EMPTY, np.float32)
    cell_of = np.full(points.shape[0], -1, np.int32)
    per_m = 1.0 / cell_m
    for p in range(points.shape[0]):
        x, y, z = points[p, 0], points[p, 1], points[p, 2]
        if not (-back_m <= x < grid.reach_front_m and -side_m <= y < side_m and abs(z) < 1e3):
            continue
        if -rear_m <= x <= front_m and -half_m <= y <= half_m:
            continue
        i = min(int((x + back_m) * per_m), rows - 1)
        j = min(int((y + side_m) * per_m), columns - 1)
        cell_of[p] = i * columns + j
        lowest[i, j] = min(lowest[i, j], z)
    return lowest, cell_of


@njit(cache=True)
def grid_shape(grid: PointGrid) -> tuple[int, int]:
    """Rows and columns of the cells: whole blocks."""
    rows = math.ceil((grid.reach_front_m + grid.reach_back_m) / (grid.cell_m * BLOCK)) * BLOCK
    columns = math.ceil(2.0 * grid.reach_side_m / (grid.cell_m * BLOCK)) * BLOCK
    return rows, columns


@njit(cache=True)
def ground_blocks(lowest: np.ndarray, grid: PointGrid) -> tuple[np.ndarray, np.ndarray]:
    """((blocks, blocks) float32 ground height at each block's middle, (blocks, blocks) bool: seen there)."""
    rows, columns = lowest.shape[0] // BLOCK, lowest.shape[1] // BLOCK
    height = np.zeros((rows, columns), np.float32)
    state = np.zeros((rows, columns), np.int8)
    gaps = np.zeros((rows, columns), np.int8)
    queue = np.empty((rows * columns, 2), np.int32)
    tail = _seed(state, queue, grid)
    block_m = grid.cell_m * BLOCK
    minima = np.empty(BLOCK * BLOCK, np.float32)
    head = 0
    while head < tail:
        i, j = queue[head]
        head += 1
        if state[i, j] == _NOT_YET:
            expected, gap = _expected(height, state, gaps, i, j)
            tolerance = grid.step_m + grid.slope * block_m * (1 + min(gap, _GAPS_MAX))
            found, value = _ground_in_block(lowest, i, j, expected, tolerance, grid.drop_m, minima)
            height[i, j] = value if found else expected
            state[i, j] = _SEEN if found else _UNSEEN
            gaps[i, j] = 0 if found else min(gap + 1, 100)
        for di in range(-1, 2):
            for dj in range(-1, 2):
                a, b = i + di, j + dj
                if 0 <= a < rows and 0 <= b < columns and state[a, b] == _NOT_YET and gaps[a, b] == 0:
                    gaps[a, b] = -1
                    queue[tail, 0], queue[tail, 1] = a, b
                    tail += 1
    _remove_bumps(height, state, block_m)
    _fill(height, state)
    return _smoothed(height, state), state == _SEEN


@njit(cache=True)
def _seed(state: np.ndarray, queue: np.ndarray, grid: PointGrid) -> int:
    """Enters the blocks under the vehicle, whose ground is at 0; their number."""
    block_m = grid.cell_m * BLOCK
    first_i = int((grid.reach_back_m - grid.body_back_m) / block_m)
    last_i = int((grid.reach_back_m + grid.body_front_m) / block_m)
    first_j = int((grid.reach_side_m - grid.body_half_width_m) / block_m)
    last_j = int((grid.reach_side_m + grid.body_half_width_m) / block_m)
    tail = 0
    for i in range(max(0, first_i), min(state.shape[0], last_i + 1)):
        for j in range(max(0, first_j), min(state.shape[1], last_j + 1)):
            state[i, j] = _UNSEEN
            queue[tail, 0], queue[tail, 1] = i, j
            tail += 1
    return tail


@njit(cache=True)
def _expected(height: np.ndarray, state: np.ndarray, gaps: np.ndarray, i: int, j: int) -> tuple[float, int]:
    """(height by the known blocks up to two away, blocks without returns on the way here)."""
    total, weights, gap = 0.0, 0.0, 100
    for di in range(-2, 3):
        for dj in range(-2, 3):
            a, b = i + di, j + dj
            if not (0 <= a < height.shape[0] and 0 <= b < height.shape[1]) or state[a, b] == _NOT_YET:
                continue
            near = max(abs(di), abs(dj)) == 1
            weight = (1.0 if near else 0.3) * (1.0 if state[a, b] == _SEEN else 0.2)
            total += weight * height[a, b]
            weights += weight
            if near:
                gap = min(gap, gaps[a, b])
    return total / weights, gap


@njit(cache=True)
def _ground_in_block(
    lowest: np.ndarray, i: int, j: int, expected: float, tolerance: float, drop_m: float, minima: np.ndarray
) -> tuple[bool, float]:
    """Whether a block's lowest returns are ground, and its height: the lower quarter of its cells' lowest."""
    count = 0
    least = expected - min(tolerance, drop_m)
    for a in range(i * BLOCK, (i + 1) * BLOCK):
        for b in range(j * BLOCK, (j + 1) * BLOCK):
            value = lowest[a, b]
            if least <= value <= expected + tolerance:
                # Sorted as they come: there are sixteen at most.
                k = count
                while k > 0 and minima[k - 1] > value:
                    minima[k] = minima[k - 1]
                    k -= 1
                minima[k] = value
                count += 1
    if count == 0:
        return False, 0.0
    return True, minima[count // 4]


@njit(cache=True)
def _remove_bumps(height: np.ndarray, state: np.ndarray, block_m: float) -> None:
    """Lowers blocks that stand out of the ground around them: a sill, a low hedge. Two chamfer passes."""
    rows, columns = height.shape
    limit = np.empty((rows, columns), np.float32)
    for i in range(rows):
        for j in range(columns):
            limit[i, j] = height[i, j] if state[i, j] == _SEEN else EMPTY
    rise = np.float32(_CONE * block_m)
    for i in range(rows):
        for j in range(columns):
            if i > 0:
                limit[i, j] = min(limit[i, j], limit[i - 1, j] + rise)
            if j > 0:
                limit[i, j] = min(limit[i, j], limit[i, j - 1] + rise)
    for i in range(rows - 1, -1, -1):
        for j in range(columns - 1, -1, -1):
            if i < rows - 1:
                limit[i, j] = min(limit[i, j], limit[i + 1, j] + rise)
            if j < columns - 1:
                limit[i, j] = min(limit[i, j], limit[i, j + 1] + rise)
            if height[i, j] > limit[i, j] + _CONE_M:
                height[i, j] = limit[i, j]
                state[i, j] = _UNSEEN


@njit(cache=True)
def _fill(height: np.ndarray, state: np.ndarray) -> None:
    """Heights between rings: each block without returns becomes the mean of those beside it, in rounds."""
    rows, columns = height.shape
    for sweep in range(_FILL_SWEEPS):
        for row in range(rows):
            # Forth and back, so that heights spread either way.
            i = row if sweep % 2 == 0 else rows - 1 - row
            for column in range(columns):
                j = column if sweep % 2 == 0 else columns - 1 - column
                if state[i, j] == _SEEN:
                    continue
                total, count = 0.0, 0
                if i > 0:
                    total, count = total + height[i - 1, j], count + 1
                if i < rows - 1:
                    total, count = total + height[i + 1, j], count + 1
                if j > 0:
                    total, count = total + height[i, j - 1], count + 1
                if j < columns - 1:
                    total, count = total + height[i, j + 1], count + 1
                height[i, j] = total / count


@njit(cache=True)
def _smoothed(height: np.ndarray, state: np.ndarray) -> np.ndarray:
    """The mean with the blocks around, each with its weight."""
    rows, columns = height.shape
    smooth = np.empty_like(height)
    for i in range(rows):
        for j in range(columns):
            total, weights = 0.0, 0.0
            for a in range(max(0, i - 1), min(rows, i + 2)):
                for b in range(max(0, j - 1), min(columns, j + 2)):
                    weight = 1.0 if state[a, b] == _SEEN else _UNSEEN_WEIGHT
                    if a == i and b == j:
                        weight *= 4.0
                    total += weight * height[a, b]
                    weights += weight
            smooth[i, j] = total / weights
    return smooth
