"""Obstacle cells of one scan: the height map of GEM, section V."""

from typing import NamedTuple

import numpy as np
from numba import njit

from contract.geometry import Array
from vehicle_agent.signals import ObstaclePercept

_EMPTY = np.float32(3.4e38)
_BLOCK = 8


class HeightMap(NamedTuple):
    """Parameters of the map; the vehicle's outline is in the base frame. A tuple, so that kernels take it.

    cell_m, threshold_m  GEM: a cell whose returns differ by more than threshold_m in height is occupied
    above_m, below_m     returns outside these heights are ignored
    reach_*              extent of the map
    rise_m               a cell with returns of one ring is occupied this far above the ground around it; a
                         person at 20 m may be met by one ring only
    points_min           returns that an occupied cell needs, against dust and dropouts
    body_margin_m        returns this near to the outline are the vehicle's own
    """

    above_m: float
    body_front_m: float
    body_back_m: float
    body_half_width_m: float
    cell_m: float = 0.25
    threshold_m: float = 0.07
    below_m: float = -1.0
    reach_front_m: float = 35.0
    reach_back_m: float = 12.0
    reach_side_m: float = 15.0
    rise_m: float = 0.35
    points_min: int = 2
    body_margin_m: float = 0.1


def percept_from_scan(points_base: np.ndarray, stamp_ns: int, params: HeightMap) -> ObstaclePercept:
    """Occupied cells of one scan.

    points_base  (n, 3) float32, base frame at stamp_ns, z from the ground under the rear axle
    Raises ValueError for another shape.
    """
    if points_base.ndim != 2 or points_base.shape[1] != 3:
        raise ValueError(f"a scan is an (n, 3) array, not {points_base.shape}")
    points = np.ascontiguousarray(points_base, dtype=np.float32)
    cells, heights_m, used = occupied_cells(points, params)
    return ObstaclePercept(stamp_ns, cells, heights_m, int(used))


@njit(cache=True)
def occupied_cells(points: np.ndarray, params: HeightMap) -> tuple[Array, Array, int]:
    """((k, 2) centres, (k,) height differences, number of returns that entered the map)."""
    cell_m, back_m, side_m = params.cell_m, params.reach_back_m, params.reach_side_m
    body_front_m = params.body_front_m + params.body_margin_m
    body_back_m = params.body_back_m + params.body_margin_m
    body_side_m = params.body_half_width_m + params.body_margin_m
    rows = int(np.ceil((params.reach_front_m + back_m) / cell_m))
    columns = int(np.ceil(2.0 * side_m / cell_m))
    lowest = np.full((rows, columns), _EMPTY, np.float32)
    highest = np.full((rows, columns), -_EMPTY, np.float32)
    count = np.zeros((rows, columns), np.int32)
    used = 0
    for p in range(points.shape[0]):
        x, y, z = points[p, 0], points[p, 1], points[p, 2]
        if not (-back_m <= x < params.reach_front_m and -side_m <= y < side_m):
            continue
        if not params.below_m <= z <= params.above_m:
            continue
        if -body_back_m <= x <= body_front_m and -body_side_m <= y <= body_side_m:
            continue
        i = min(int((x + back_m) / cell_m), rows - 1)
        j = min(int((y + side_m) / cell_m), columns - 1)
        used += 1
        count[i, j] += 1
        lowest[i, j] = min(lowest[i, j], z)
        highest[i, j] = max(highest[i, j], z)
    cells, heights = _obstacles(lowest, highest, count, min(rows * columns, used), params)
    return cells, heights, used


@njit(cache=True)
def _obstacles(
    lowest: np.ndarray, highest: np.ndarray, count: np.ndarray, cells_max: int, params: HeightMap
) -> tuple[Array, Array]:
    """((k, 2) centres, (k,) height differences) of the occupied cells."""
    rows, columns = lowest.shape
    ground = _ground(lowest)
    cells = np.empty((cells_max, 2))
    heights = np.empty(cells_max)
    found = 0
    for i in range(rows):
        for j in range(columns):
            if count[i, j] < params.points_min:
                continue
            height = highest[i, j] - lowest[i, j]
            if height <= params.threshold_m:
                # Returns of one ring only: compare with the ground around the cell.
                height = highest[i, j] - ground[i // _BLOCK, j // _BLOCK]
                if height <= params.rise_m:
                    continue
            cells[found, 0] = (i + 0.5) * params.cell_m - params.reach_back_m
            cells[found, 1] = (j + 0.5) * params.cell_m - params.reach_side_m
            heights[found] = height
            found += 1
    return cells[:found].copy(), heights[:found].copy()


@njit(cache=True)
def _ground(lowest: np.ndarray) -> np.ndarray:
    """(blocks, blocks) the lowest return in each block of cells and the eight blocks around it."""
    rows, columns = lowest.shape
    blocks = np.full((rows // _BLOCK + 1, columns // _BLOCK + 1), _EMPTY, np.float32)
    for i in range(rows):
        for j in range(columns):
            if lowest[i, j] < blocks[i // _BLOCK, j // _BLOCK]:
                blocks[i // _BLOCK, j // _BLOCK] = lowest[i, j]
    spread = np.empty_like(blocks)
    for i in range(blocks.shape[0]):
        for j in range(blocks.shape[1]):
            spread[i, j] = np.min(blocks[max(0, i - 1) : i + 2, max(0, j - 1) : j + 2])
    return spread
