"""Heights of points above their ground, and the cells that hold an obstacle."""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from contract.geometry import Array
from vehicle_agent.perception.points.grid import BLOCK, PointGrid
from vehicle_agent.perception.points.ground import ground_blocks, lowest_returns
from vehicle_agent.perception.points.kerbs import kerb_cells
from vehicle_agent.perception.points.outlines import outline
from vehicle_agent.signals import ObstaclePercept


class PointHeights(NamedTuple):
    """The points of one scan on the grid.

    cell_of (n,) int32       cell of each point, -1 outside the grid
    heights_m (n,) float32   above the ground below it
    top_m (r, c) float32     highest return of a cell that does not pass over the vehicle; 0 without one
    is_obstacle (r, c) bool; used: returns on the grid
    ground (b, b) float32, seen (b, b) bool: of the blocks
    """

    cell_of: np.ndarray
    heights_m: np.ndarray
    top_m: np.ndarray
    is_obstacle: np.ndarray
    ground: np.ndarray
    seen: np.ndarray
    used: int


def percept_from_points(points_base: np.ndarray, stamp_ns: int, grid: PointGrid) -> ObstaclePercept:
    """Obstacle cells of one scan; arguments and errors as those of `height_map.percept_from_scan`."""
    return percept_of(point_heights(points_base, grid), stamp_ns, grid)


def point_heights(points_base: np.ndarray, grid: PointGrid) -> PointHeights:
    """The points of one scan above their ground.

    points_base  (n, 3) float32, base frame, z from the ground under the rear axle
    Raises ValueError for another shape.
    """
    if points_base.ndim != 2 or points_base.shape[1] != 3:
        raise ValueError(f"a scan is an (n, 3) array, not {points_base.shape}")
    points = np.ascontiguousarray(points_base, dtype=np.float32)
    lowest, cell_of = lowest_returns(points, grid)
    ground, seen = ground_blocks(lowest, grid)
    heights_m, top_m, up, used = heights_above(points, cell_of, ground, lowest.shape, grid)
    return PointHeights(
        cell_of, heights_m, top_m, obstacle_cells(top_m, up, ground, seen, grid), ground, seen, int(used)
    )


def percept_of(heights: PointHeights, stamp_ns: int, grid: PointGrid) -> ObstaclePercept:
    """The edges of obstacles, and kerbs, as planning takes them."""
    rows, columns = np.nonzero(outline(heights.is_obstacle, grid.gap_cells))
    cells: Array = np.column_stack(
        ((rows + 0.5) * grid.cell_m - grid.reach_back_m, (columns + 0.5) * grid.cell_m - grid.reach_side_m)
    )
    kerbs = kerb_cells(heights.heights_m, heights.cell_of, heights.is_obstacle, grid)
    return ObstaclePercept(
        stamp_ns, cells, heights.top_m[rows, columns].astype(np.float64), heights.used, kerbs_base=kerbs
    )


@njit(cache=True)
def heights_above(
    points: np.ndarray, cell_of: np.ndarray, ground: np.ndarray, shape: tuple[int, int], grid: PointGrid
) -> tuple[np.ndarray, np.ndarray, np.ndarray, int]:
    """((n,) heights above ground, (r, c) highest return, (r, c) number that stands out, returns used).

    The ground between the middles of blocks is interpolated.
    """
    heights = np.zeros(points.shape[0], np.float32)
    top = np.zeros(shape, np.float32)
    up = np.zeros(shape, np.int32)
    block_m = grid.cell_m * BLOCK
    last_i, last_j = ground.shape[0] - 2, ground.shape[1] - 2
    columns = shape[1]
    used = 0
    for p in range(points.shape[0]):
        cell = cell_of[p]
        if cell < 0:
            continue
        used += 1
        u = (points[p, 0] + grid.reach_back_m) / block_m - 0.5
        v = (points[p, 1] + grid.reach_side_m) / block_m - 0.5
        i, j = min(max(int(u), 0), last_i), min(max(int(v), 0), last_j)
        s, t = min(max(u - i, 0.0), 1.0), min(max(v - j, 0.0), 1.0)
        below = (1.0 - s) * ((1.0 - t) * ground[i, j] + t * ground[i, j + 1]) + s * (
            (1.0 - t) * ground[i + 1, j] + t * ground[i + 1, j + 1]
        )
        height = points[p, 2] - below
        heights[p] = height
        if height <= grid.above_m:
            a, b = cell // columns, cell % columns
            top[a, b] = max(top[a, b], height)
            if height > 0.7 * grid.height_m:
                up[a, b] += 1
    return heights, top, up, used


@njit(cache=True)
def lowest_heights(
    points: np.ndarray, heights_m: np.ndarray, cell_of: np.ndarray, places: Array, within_m: float
) -> Array:
    """(k,) the lowest return within within_m of places (k, 2), above ground; inf: none is there.

    points (n, 3), heights_m (n,), cell_of (n,) as `PointHeights` has them; the vehicle's own do not count
    """
    lowest = np.full(len(places), np.inf)
    reach = within_m * within_m
    for k in range(len(places)):
        for p in range(points.shape[0]):
            dx, dy = points[p, 0] - places[k, 0], points[p, 1] - places[k, 1]
            if dx * dx + dy * dy <= reach and cell_of[p] >= 0 and heights_m[p] < lowest[k]:
                lowest[k] = heights_m[p]
    return lowest


@njit(cache=True)
def obstacle_cells(
    top: np.ndarray, up: np.ndarray, ground: np.ndarray, seen: np.ndarray, grid: PointGrid
) -> np.ndarray:
    """(r, c) bool: cells with something that the vehicle must not meet."""
    rows, columns = top.shape
    obstacle = np.zeros((rows, columns), np.bool_)
    for i in range(rows):
        for j in range(columns):
            height = top[i, j]
            if height <= grid.height_m:
                continue
            x = (i + 0.5) * grid.cell_m - grid.reach_back_m
            y = (j + 0.5) * grid.cell_m - grid.reach_side_m
            least = min(grid.height_m + grid.height_per_m * math.hypot(x, y), grid.height_m_max)
            if height < grid.height_m_max:
                known, above = _higher_ground(ground, seen, i // BLOCK, j // BLOCK)
                if not known:
                    least = grid.height_m_max
                # The height above the higher ground beside it: a kerb is no higher than that.
                elif height - (above - ground[i // BLOCK, j // BLOCK]) <= grid.kerb_m:
                    continue
            if height <= least:
                continue
            support = 0
            for a in range(max(0, i - 1), min(rows, i + 2)):
                for b in range(max(0, j - 1), min(columns, j + 2)):
                    support += up[a, b]
            obstacle[i, j] = support >= grid.points_min
    return obstacle


@njit(cache=True)
def _higher_ground(ground: np.ndarray, seen: np.ndarray, i: int, j: int) -> tuple[bool, float]:
    """(whether ground was seen in a block or beside it, the highest ground seen there)."""
    known, above = False, -1e9
    for a in range(max(0, i - 1), min(ground.shape[0], i + 2)):
        for b in range(max(0, j - 1), min(ground.shape[1], j + 2)):
            if seen[a, b]:
                known = True
                above = max(above, ground[a, b])
    return known, above
