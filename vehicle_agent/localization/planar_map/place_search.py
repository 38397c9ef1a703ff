"""Where in a part of the map a scan may have been taken: all poses of a lattice, by branch and bound.

Hess et al. 2016, "Real-time loop closure in 2D LIDAR SLAM", section V-B: a square of poses is bounded by the
scan on a grid whose cells hold the best value of the square, and only squares that may hold a better pose are
divided. The result is the lattice's best poses, as if each had been scored, if the count of nodes suffices.
"""

import math

import msgspec
import numpy as np
from numba import njit
from numpy.typing import NDArray

from contract.geometry import Array, wrap_angle
from contract.occupancy.occupancy_map import FREE, OCCUPIED, Cells

Bytes = NDArray[np.uint8]
# What an end of a beam counts in a cell with a wall, and beside one.
_WALL, _BESIDE = 4, 2


class PlaceSearchParams(msgspec.Struct, frozen=True):
    """The lattice, and how much of it is kept.

    pooled        edge of the lattice's squares, in cells of the map
    levels        squares of 1, 2, 4... steps: so many sizes
    range_m       farther ends are left out: they would need finer headings
    score_min     a pose whose share of the best thinkable score is less is none
    margin        a pose that is worse than the best by this share is none
    kept          poses, each apart from the better ones by apart_m or apart_rad
    nodes_max     of the search in one part of the map
    """

    pooled: int = 3
    levels: int = 6
    range_m: float = 25.0
    score_min: float = 0.4
    margin: float = 0.2
    kept: int = 8
    apart_m: float = 1.5
    apart_rad: float = 0.25
    nodes_max: int = 3_000_000


class SearchGrid(msgspec.Struct, frozen=True):
    """A part of the map for the search.

    values (levels, rows, columns)  the best value within 2^level cells from each cell on
    free (levels, rows, columns)    1 where there is a free cell in the same square
    """

    values: Bytes
    free: Bytes
    cell_m: float
    origin_x_m: float
    origin_y_m: float


class FoundPlace(msgspec.Struct, frozen=True):
    """pose (3,) of the laser in the map frame; score: share of the best thinkable one"""

    pose: Array
    score: float


def search_grid(
    cells: Cells, cell_m: float, origin_x_m: float, origin_y_m: float, params: PlaceSearchParams
) -> SearchGrid:
    """The grid of a part of the map whose cells (rows, columns) begin at the origin."""
    pooled = params.pooled
    rows, columns = (size // pooled for size in cells.shape)
    blocks = cells[: rows * pooled, : columns * pooled].reshape(rows, pooled, columns, pooled)
    wall = (blocks == OCCUPIED).any(axis=(1, 3))
    free = (blocks == FREE).any(axis=(1, 3)).astype(np.uint8)
    values = np.where(wall, _WALL, 0).astype(np.uint8)
    for dy in (-1, 0, 1):
        for dx in (-1, 0, 1):
            beside = np.zeros_like(values)
            beside[max(0, dy) : rows + min(0, dy), max(0, dx) : columns + min(0, dx)] = values[
                max(0, -dy) : rows + min(0, -dy), max(0, -dx) : columns + min(0, -dx)
            ]
            np.maximum(values, np.where(beside == _WALL, _BESIDE, 0).astype(np.uint8), out=values)
    return SearchGrid(
        _pyramid(values, params.levels),
        _pyramid(free, params.levels),
        cell_m * pooled,
        origin_x_m,
        origin_y_m,
    )


def _pyramid(base: Bytes, levels: int) -> Bytes:
    """(levels, rows, columns) the greatest value of base[r : r + 2^level, c : c + 2^level]."""
    found = np.zeros((levels, *base.shape), dtype=np.uint8)
    found[0] = base
    for level in range(1, levels):
        step, below, here = 1 << (level - 1), found[level - 1], found[level]
        here[:] = below
        np.maximum(here[:-step], below[step:], out=here[:-step])
        wide = here.copy()
        np.maximum(here[:, :-step], wide[:, step:], out=here[:, :-step])
    return found


def places_of(
    points: Array, weights: Array, grid: SearchGrid, square: tuple[float, float, float],
    yaws_rad: tuple[float, float], floor: float, params: PlaceSearchParams,
) -> list[FoundPlace]:  # fmt: skip
    """The best poses, best first, whose place lies in a square.

    points (m, 2) ends of beams, laser frame; weights (m,): what each counts
    square    x, y of the middle and half the edge, m; the grid reaches farther than this by range_m
    yaws_rad  middle and half of the headings that are tried; pi and more: all
    floor     share of the best thinkable score that is known from other parts; less is none
    """
    near = np.hypot(points[:, 0], points[:, 1]) <= params.range_m
    ends, counts = np.ascontiguousarray(points[near]), np.ascontiguousarray(weights[near])
    total = _WALL * float(counts.sum())
    if total <= 0.0:
        return []
    far_m = float(np.hypot(ends[:, 0], ends[:, 1]).max())
    step_rad = grid.cell_m / max(far_m, 5.0)
    half = min(math.pi, yaws_rad[1])
    turns = max(1, math.ceil(2.0 * half / step_rad))
    yaws = yaws_rad[0] - half + 2.0 * half / turns * (np.arange(turns, dtype=np.float64) + 0.5)
    first, last = np.empty(2, dtype=np.int64), np.empty(2, dtype=np.int64)
    for axis, (middle, origin) in enumerate(((square[0], grid.origin_x_m), (square[1], grid.origin_y_m))):
        size = grid.values.shape[2 - axis]
        first[axis] = max(0, math.floor((middle - square[2] - origin) / grid.cell_m))
        last[axis] = min(size, math.ceil((middle + square[2] - origin) / grid.cell_m))
    if (last <= first).any():
        return []
    rows = _best_poses(
        ends, counts, grid.values, grid.free, grid.cell_m, yaws.astype(np.float64), first, last,
        total * max(floor, params.score_min), params.margin * total, params.kept,
        params.apart_m / grid.cell_m, params.apart_rad, params.nodes_max,
    )  # fmt: skip
    found = []
    for score, column, row, yaw in rows:
        x_m = grid.origin_x_m + (column + 0.5) * grid.cell_m
        y_m = grid.origin_y_m + (row + 0.5) * grid.cell_m
        found.append(FoundPlace(np.array([x_m, y_m, math.remainder(yaw, math.tau)]), float(score) / total))
    return found


@njit(cache=True)
def _best_poses(
    points: Array, weights: Array, values: Bytes, free: Bytes, cell_m: float, yaws: Array,
    first: NDArray[np.int64], last: NDArray[np.int64], floor: float, margin: float, kept: int,
    apart_cells: float, apart_rad: float, nodes_max: int,
) -> Array:  # fmt: skip
    """(k, 4) score, column, row, heading; best first, k <= kept."""
    levels = values.shape[0]
    top = levels - 1
    edge = 1 << top
    roots_x = (last[0] - first[0] + edge - 1) // edge
    roots_y = (last[1] - first[1] + edge - 1) // edge
    count = roots_x * roots_y * yaws.shape[0]
    bounds, nodes = np.empty(count), 0
    shifts = np.empty((yaws.shape[0], points.shape[0], 2), dtype=np.int64)
    for k in range(yaws.shape[0]):
        cos, sin = math.cos(yaws[k]) / cell_m, math.sin(yaws[k]) / cell_m
        for i in range(points.shape[0]):
            # From the middle of the pose's cell.
            shifts[k, i, 0] = math.floor(0.5 + cos * points[i, 0] - sin * points[i, 1])
            shifts[k, i, 1] = math.floor(0.5 + sin * points[i, 0] + cos * points[i, 1])
    for root in range(count):
        k = root // (roots_x * roots_y)
        x = first[0] + edge * (root % roots_x)
        y = first[1] + edge * (root // roots_x % roots_y)
        bounds[root] = _bound(shifts[k], weights, values[top], free[top], x, y)
    order = np.argsort(-bounds)
    best = np.zeros((kept, 4))
    found = 0
    stack = np.empty((4 * levels + 4, 4), dtype=np.int64)
    stack_bounds = np.empty(4 * levels + 4)
    for root in order:
        needed = floor
        if found:
            needed = max(needed, best[0, 0] - margin)
        if bounds[root] < needed or nodes > nodes_max:
            break
        stack[0, 0] = top
        stack[0, 1] = first[0] + edge * (root % roots_x)
        stack[0, 2] = first[1] + edge * (root // roots_x % roots_y)
        stack[0, 3] = root // (roots_x * roots_y)
        stack_bounds[0] = bounds[root]
        size = 1
        while size and nodes <= nodes_max:
            size -= 1
            level, x, y, k, bound = (
                stack[size, 0], stack[size, 1], stack[size, 2], stack[size, 3], stack_bounds[size],
            )  # fmt: skip
            needed = floor
            if found:
                needed = max(needed, best[0, 0] - margin)
            if found == kept:
                needed = max(needed, best[kept - 1, 0])
            if bound < needed:
                continue
            if level == 0:
                found = _kept(best, found, bound, x, y, yaws[k], apart_cells, apart_rad)
                continue
            half = 1 << (level - 1)
            begin = size
            for part in range(4):
                px, py = x + half * (part % 2), y + half * (part // 2)
                if px >= last[0] or py >= last[1]:
                    continue
                nodes += 1
                value = _bound(shifts[k], weights, values[level - 1], free[level - 1], px, py)
                if value < needed or value <= 0.0:
                    continue
                # The best part is looked into first.
                at = size
                while at > begin and stack_bounds[at - 1] > value:
                    stack[at] = stack[at - 1]
                    stack_bounds[at] = stack_bounds[at - 1]
                    at -= 1
                stack[at, 0], stack[at, 1], stack[at, 2], stack[at, 3] = level - 1, px, py, k
                stack_bounds[at] = value
                size += 1
    return best[:found].copy()


@njit(cache=True)
def _bound(shifts: NDArray[np.int64], weights: Array, values: Bytes, free: Bytes, x: int, y: int) -> float:
    """No pose of the square from the cell (x, y) on scores more."""
    if not (0 <= y < free.shape[0] and 0 <= x < free.shape[1]) or free[y, x] == 0:
        return 0.0
    total = 0.0
    for i in range(shifts.shape[0]):
        column, row = x + shifts[i, 0], y + shifts[i, 1]
        if 0 <= row < values.shape[0] and 0 <= column < values.shape[1]:
            total += weights[i] * values[row, column]
    return total


@njit(cache=True)
def _kept(
    best: Array,
    found: int,
    score: float,
    x: float,
    y: float,
    yaw: float,
    apart_cells: float,
    apart_rad: float,
) -> int:
    """How many poses `best` holds after one more, which gives way to a better one near it."""
    i = 0
    while i < found:
        near = math.hypot(best[i, 1] - x, best[i, 2] - y) < apart_cells
        if near and abs(wrap_angle(best[i, 3] - yaw)) < apart_rad:
            if best[i, 0] >= score:
                return found
            for j in range(i, found - 1):
                best[j] = best[j + 1]
            found -= 1
        else:
            i += 1
    if found == best.shape[0]:
        if best[found - 1, 0] >= score:
            return found
        found -= 1
    at = found
    while at and best[at - 1, 0] < score:
        best[at] = best[at - 1]
        at -= 1
    best[at, 0], best[at, 1], best[at, 2], best[at, 3] = score, x, y, yaw
    return found + 1
