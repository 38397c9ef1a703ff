"""Obstacle cells of one scan: the height map of GEM, section V."""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from contract.geometry import Array, BoolArray
from vehicle_agent.signals import ObstaclePercept

_EMPTY = np.float32(3.4e38)
_BLOCK = 8


class HeightMap(NamedTuple):
    """Parameters of the map; the vehicle's outline is in the base frame. A tuple, so that kernels take it.

    cell_m, threshold_m  GEM: a cell whose returns differ by more than threshold_m in height is occupied
    above_m, below_m     returns outside these heights above the ground are ignored
    reach_*              extent of the map
    rise_m               a cell with returns of one ring is occupied this far above the ground around it; a
                         person at 20 m may be met by one ring only
    points_min           returns that an occupied cell needs, against dust and dropouts
    body_margin_m        returns this near to the outline are the vehicle's own
    grade_ratio          the steepest road: ground may be so much higher or lower by its distance
    level_m              within it the slope of the ground makes no difference to rise_m
    kerb_m               a step up to this height with nothing above it is a kerb, beside which one may drive
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
    grade_ratio: float = 0.15
    level_m: float = 1.1
    kerb_m: float = 0.18


def percept_from_scan(points_base: np.ndarray, stamp_ns: int, params: HeightMap) -> ObstaclePercept:
    """Occupied cells of one scan.

    points_base  (n, 3) float32, base frame at stamp_ns, z from the ground under the rear axle
    Raises ValueError for another shape.
    """
    if points_base.ndim != 2 or points_base.shape[1] != 3:
        raise ValueError(f"a scan is an (n, 3) array, not {points_base.shape}")
    points = np.ascontiguousarray(points_base, dtype=np.float32)
    cells, heights_m, is_low, used = occupied_cells(points, params)
    return ObstaclePercept(stamp_ns, cells, heights_m, int(used), is_low)


@njit(cache=True)
def occupied_cells(points: np.ndarray, params: HeightMap) -> tuple[Array, Array, BoolArray, int]:
    """((k, 2) centres, (k,) height differences, (k,) kerbs, number of returns that entered the map)."""
    cell_m, back_m, side_m = params.cell_m, params.reach_back_m, params.reach_side_m
    body_front_m = params.body_front_m + params.body_margin_m
    body_back_m = params.body_back_m + params.body_margin_m
    body_side_m = params.body_half_width_m + params.body_margin_m
    rows = int(np.ceil((params.reach_front_m + back_m) / cell_m))
    columns = int(np.ceil(2.0 * side_m / cell_m))
    lowest = np.full((rows, columns), _EMPTY, np.float32)
    # The cell of each return that can count, -1 for the others.
    at = np.full(points.shape[0], -1, np.int64)
    for p in range(points.shape[0]):
        x, y, z = points[p, 0], points[p, 1], points[p, 2]
        if not (-back_m <= x < params.reach_front_m and -side_m <= y < side_m):
            continue
        if -body_back_m <= x <= body_front_m and -body_side_m <= y <= body_side_m:
            continue
        lowest_m = min(params.below_m, -params.grade_ratio * math.sqrt(x * x + y * y))
        if not z >= lowest_m:
            continue
        i = min(int((x + back_m) / cell_m), rows - 1)
        j = min(int((y + side_m) / cell_m), columns - 1)
        at[p] = i * columns + j
        lowest[i, j] = min(lowest[i, j], z)
    lows, ground = _ground(lowest)
    highest = np.full((rows, columns), -_EMPTY, np.float32)
    count = np.zeros((rows, columns), np.int32)
    lowest[:] = _EMPTY
    used = 0
    for p in range(points.shape[0]):
        if at[p] < 0:
            continue
        i, j = at[p] // columns, at[p] % columns
        x, y, z = points[p, 0], points[p, 1], points[p, 2]
        # What is seen of a tree over a wall is no ground: no road leads up so steeply.
        level_m = ground[i // _BLOCK, j // _BLOCK]
        if level_m > params.grade_ratio * math.sqrt(x * x + y * y):
            level_m = np.float32(0.0)
        if z - level_m > params.above_m:
            continue
        used += 1
        count[i, j] += 1
        lowest[i, j] = min(lowest[i, j], z)
        highest[i, j] = max(highest[i, j], z)
    cells, heights, kerbs = _obstacles(lowest, highest, count, lows, min(rows * columns, used), params)
    return cells, heights, kerbs, used


@njit(cache=True)
def _obstacles(
    lowest: np.ndarray,
    highest: np.ndarray,
    count: np.ndarray,
    lows: np.ndarray,
    cells_max: int,
    params: HeightMap,
) -> tuple[Array, Array, BoolArray]:
    """((k, 2) centres, (k,) height differences, (k,) kerbs) of the occupied cells."""
    rows, columns = lowest.shape
    cells = np.empty((cells_max, 2))
    heights = np.empty(cells_max)
    kerbs = np.zeros(cells_max, np.bool_)
    found = 0
    for i in range(rows):
        for j in range(columns):
            if count[i, j] < params.points_min:
                continue
            height = highest[i, j] - lowest[i, j]
            if height <= params.threshold_m:
                # Returns of one ring only: compare with the ground around the cell.
                height = _rise(highest[i, j], i, j, lows, params)
                if height <= 0.0:
                    continue
            elif height <= params.kerb_m:
                kerbs[found] = _is_flat(highest, i, j, lowest[i, j] + params.kerb_m)
            cells[found, 0] = (i + 0.5) * params.cell_m - params.reach_back_m
            cells[found, 1] = (j + 0.5) * params.cell_m - params.reach_side_m
            heights[found] = height
            found += 1
    return cells[:found].copy(), heights[:found].copy(), kerbs[:found].copy()


@njit(cache=True)
def _rise(top: float, i: int, j: int, lows: np.ndarray, params: HeightMap) -> float:
    """How far `top` is above the lowest returns of the blocks around a cell; 0.0 where a slope can be all."""
    found = 0.0
    for a in range(max(0, i // _BLOCK - 1), min(lows.shape[0], i // _BLOCK + 2)):
        for b in range(max(0, j // _BLOCK - 1), min(lows.shape[1], j // _BLOCK + 2)):
            if lows[a, b, 0] == _EMPTY:
                continue
            apart_m = params.cell_m * math.sqrt((i - lows[a, b, 1]) ** 2 + (j - lows[a, b, 2]) ** 2)
            sloping_m = params.grade_ratio * max(0.0, apart_m - params.level_m)
            rise_m = top - lows[a, b, 0]
            if rise_m > params.rise_m + sloping_m:
                found = max(found, rise_m)
    return found


@njit(cache=True)
def _is_flat(highest: np.ndarray, i: int, j: int, top_m: float) -> bool:
    """Whether nothing in a cell and the eight around it is higher: a kerb's pavement is level."""
    return bool(np.max(highest[max(0, i - 1) : i + 2, max(0, j - 1) : j + 2]) <= top_m)


@njit(cache=True)
def _ground(lowest: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """((blocks, blocks, 3) lowest return of each block of cells and its cell, (blocks, blocks) the lowest in
    a block and the eight around it)."""
    rows, columns = lowest.shape
    shape = (rows // _BLOCK + 1, columns // _BLOCK + 1)
    lows = np.full((shape[0], shape[1], 3), _EMPTY, np.float32)
    for i in range(rows):
        for j in range(columns):
            if lowest[i, j] < lows[i // _BLOCK, j // _BLOCK, 0]:
                lows[i // _BLOCK, j // _BLOCK, 0] = lowest[i, j]
                lows[i // _BLOCK, j // _BLOCK, 1] = i
                lows[i // _BLOCK, j // _BLOCK, 2] = j
    spread = np.empty(shape, np.float32)
    for i in range(shape[0]):
        for j in range(shape[1]):
            spread[i, j] = np.min(lows[max(0, i - 1) : i + 2, max(0, j - 1) : j + 2, 0])
    return lows, spread
