"""The rolling cost map: free, occupied and unknown space around the vehicle, a byte a cell.

After NUS, section IV-B.

50 x 50 m in cells of 0.2 m, with the axes of the map frame and the vehicle in the middle. 255 is unknown, 254
an obstacle. 0..253 is the cost near obstacles, which falls off exponentially with the distance to the
nearest.
"""

import math

import msgspec
import numpy as np
from numba import njit
from numpy.typing import NDArray

from contract.geometry import Array

Cells = NDArray[np.uint8]

SIDE_M = 50.0
CELL_M = 0.2
SIDE = round(SIDE_M / CELL_M)
UNKNOWN, OBSTACLE, DEAREST = 255, 254, 253


class CostMap(msgspec.Struct, frozen=True):
    """cells (SIDE, SIDE) uint8, row along y, column along x; the first one begins at (column, row) CELL_M."""

    cells: np.ndarray
    column: int = 0
    row: int = 0
    known: bool = False


class CostRules(msgspec.Struct, frozen=True):
    """How costs spread and how far one sees.

    decay_m, radius_m  cost = 253 exp(-d / decay) within radius of an obstacle cell's centre
    range_m            cells beyond are not cleared; under half of the map's side
    rays               bearings that are looked along; neighbours lie closer than a cell at `range_m`
    """

    decay_m: float = 0.5
    radius_m: float = 1.5
    range_m: float = 24.0
    rays: int = 900

    def empty(self) -> CostMap:
        return CostMap(np.full((SIDE, SIDE), UNKNOWN, np.uint8))

    def updated(self, before: CostMap, x_m: float, y_m: float, eye: Array, points_map: Array) -> CostMap:
        """The map about the vehicle at (x, y) after a scan.

        eye         (2,) the sensor's position, map frame
        points_map  (n, 2) detected obstacles; space before them, and up to the range without one, is free
        """
        column, row = math.floor(x_m / CELL_M) - SIDE // 2, math.floor(y_m / CELL_M) - SIDE // 2
        cells = rolled(before.cells, column - before.column, row - before.row)
        forget_costs(cells)
        clear_rays(cells, column, row, eye[0], eye[1], points_map, self.rays, self.range_m)
        mark(cells, column, row, points_map)
        spread(cells, self.decay_m, self.radius_m)
        return CostMap(cells, column, row, True)


@njit(cache=True)
def rolled(cells: Cells, columns: int, rows: int) -> Cells:
    """A copy whose first cell lies this many columns and rows farther; new cells are unknown."""
    side = cells.shape[0]
    out = np.full((side, side), np.uint8(255), np.uint8)
    for i in range(max(0, -rows), min(side, side - rows)):
        for j in range(max(0, -columns), min(side, side - columns)):
            out[i, j] = cells[i + rows, j + columns]
    return out


@njit(cache=True)
def forget_costs(cells: Cells) -> None:
    """Sets every cost to free; obstacle and unknown cells stay."""
    for i in range(cells.shape[0]):
        for j in range(cells.shape[1]):
            if cells[i, j] < 254:
                cells[i, j] = np.uint8(0)


@njit(cache=True)
def clear_rays(
    cells: Cells, column: int, row: int, x_m: float, y_m: float, points: Array, rays: int, range_m: float
) -> None:
    """Free every cell between the eye and the nearest obstacle of each bearing, or the range."""
    side = cells.shape[0]
    bearing_rad = 2.0 * math.pi / rays
    reach = np.full(rays, range_m)
    for p in range(points.shape[0]):
        dx, dy = points[p, 0] - x_m, points[p, 1] - y_m
        distance = math.hypot(dx, dy)
        if distance < CELL_M:
            continue
        middle = math.atan2(dy, dx) / bearing_rad
        half = math.atan(CELL_M / distance) / bearing_rad
        for k in range(math.floor(middle - half), math.ceil(middle + half) + 1):
            reach[k % rays] = min(reach[k % rays], distance - CELL_M)
    for k in range(rays):
        cos, sin = math.cos(k * bearing_rad), math.sin(k * bearing_rad)
        for step in range(math.floor(reach[k] / (0.5 * CELL_M)) + 1):
            q = 0.5 * CELL_M * step
            i = math.floor((y_m + q * sin) / CELL_M) - row
            j = math.floor((x_m + q * cos) / CELL_M) - column
            if i < 0 or j < 0 or i >= side or j >= side:
                break
            cells[i, j] = np.uint8(0)


@njit(cache=True)
def mark(cells: Cells, column: int, row: int, points: Array) -> None:
    """Obstacles into their cells."""
    side = cells.shape[0]
    for p in range(points.shape[0]):
        i, j = math.floor(points[p, 1] / CELL_M) - row, math.floor(points[p, 0] / CELL_M) - column
        if 0 <= i < side and 0 <= j < side:
            cells[i, j] = np.uint8(254)


@njit(cache=True)
def spread(cells: Cells, decay_m: float, radius_m: float) -> None:
    """Costs around each obstacle into free cells, the dearest where several reach; unknown stays unknown."""
    side = cells.shape[0]
    reach = math.floor(radius_m / CELL_M)
    stamp = np.zeros((2 * reach + 1, 2 * reach + 1), np.uint8)
    for a in range(-reach, reach + 1):
        for b in range(-reach, reach + 1):
            d = CELL_M * math.hypot(a, b)
            if d <= radius_m:
                stamp[a + reach, b + reach] = np.uint8(253.0 * math.exp(-d / decay_m))
    for i in range(side):
        for j in range(side):
            if cells[i, j] != 254:
                continue
            for a in range(max(0, i - reach), min(side, i + reach + 1)):
                for b in range(max(0, j - reach), min(side, j + reach + 1)):
                    cost = stamp[a - i + reach, b - j + reach]
                    if cells[a, b] < cost:
                        cells[a, b] = cost


@njit(cache=True)
def ahead_of(
    cells: Cells, column: int, row: int, poses: Array, front_m: float, half_width_m: float, unknown: float
) -> float:
    """Mean cost, 0..1, of the ground that the body's front edge sweeps along (k, 3) poses.

    An obstacle counts 1, and an unknown cell, or one outside the map, `unknown`.
    """
    side = cells.shape[0]
    across = max(1, math.ceil(2.0 * half_width_m / CELL_M))
    total, count = 0.0, 0
    for k in range(poses.shape[0]):
        cos, sin = math.cos(poses[k, 2]), math.sin(poses[k, 2])
        for c in range(across + 1):
            y = half_width_m * (2.0 * c / across - 1.0)
            i = math.floor((poses[k, 1] + front_m * sin + y * cos) / CELL_M) - row
            j = math.floor((poses[k, 0] + front_m * cos - y * sin) / CELL_M) - column
            count += 1
            if i < 0 or j < 0 or i >= side or j >= side or cells[i, j] == 255:
                total += unknown
            else:
                total += cells[i, j] / 254.0
    return total / max(count, 1)


@njit(cache=True)
def obstacle_cells(cells: Cells, column: int, row: int, x_m: float, y_m: float, reach_m: float) -> Array:
    """(n, 2) middles of the obstacle cells within a square of this reach about a place, map frame."""
    side = cells.shape[0]
    reach = math.ceil(reach_m / CELL_M)
    found = np.empty(((2 * reach + 1) ** 2, 2))
    n = 0
    i0, j0 = math.floor(y_m / CELL_M) - row, math.floor(x_m / CELL_M) - column
    for i in range(max(0, i0 - reach), min(side, i0 + reach + 1)):
        for j in range(max(0, j0 - reach), min(side, j0 + reach + 1)):
            if cells[i, j] == 254:
                found[n, 0], found[n, 1] = (j + column + 0.5) * CELL_M, (i + row + 0.5) * CELL_M
                n += 1
    return found[:n].copy()


@njit(cache=True)
def seen_in(cells: Cells, column: int, row: int, outline: Array) -> tuple[float, int]:
    """(share of the polygon's (n, 2) ground that is known, number of obstacle cells on it)."""
    side = cells.shape[0]
    count, known, taken = 0, 0, 0
    i0, i1 = math.floor(outline[:, 1].min() / CELL_M), math.ceil(outline[:, 1].max() / CELL_M)
    j0, j1 = math.floor(outline[:, 0].min() / CELL_M), math.ceil(outline[:, 0].max() / CELL_M)
    n = outline.shape[0]
    for i in range(i0, i1 + 1):
        for j in range(j0, j1 + 1):
            x, y = (j + 0.5) * CELL_M, (i + 0.5) * CELL_M
            odd = False
            for k in range(n):
                ax, ay, bx, by = outline[k - 1, 0], outline[k - 1, 1], outline[k, 0], outline[k, 1]
                if (ay > y) != (by > y) and x < ax + (y - ay) / (by - ay) * (bx - ax):
                    odd = not odd
            if not odd:
                continue
            count += 1
            a, b = i - row, j - column
            if 0 <= a < side and 0 <= b < side and cells[a, b] != 255:
                known += 1
                taken += cells[a, b] == 254
    return known / max(count, 1), taken
