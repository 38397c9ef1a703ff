"""Reference points sorted into square cells, so that the nearest one is found among nine cells."""

import math

import msgspec
import numpy as np
from numba import njit

from contract.geometry import Array, IntArray

_CELLS_MAX = 4_000_000


class PointIndex(msgspec.Struct, frozen=True):
    """points, normals (n, 2) sorted by cell; starts (rows * columns + 1,) where each cell's points begin.

    origin_x_m, origin_y_m  the corner of cell 0; cell_m its side, the greatest distance that is searched
    """

    points: Array
    normals: Array
    starts: IntArray
    origin_x_m: float
    origin_y_m: float
    cell_m: float
    columns: int
    rows: int

    def __len__(self) -> int:
        return len(self.points)


def index_points(points: Array, normals: Array, cell_m: float) -> PointIndex:
    """The index of (n, 2) points with their normals; points without a normal are left out."""
    has_normal = (normals != 0.0).any(axis=1)
    points, normals = points[has_normal], normals[has_normal]
    if not len(points):
        return PointIndex(points, normals, np.zeros(2, dtype=np.int64), 0.0, 0.0, cell_m, 1, 1)
    low, high = points.min(axis=0), points.max(axis=0)
    columns, rows = (int(count) + 1 for count in np.floor((high - low) / cell_m))
    assert columns * rows <= _CELLS_MAX, "reference points lie too far apart for one index"
    order, starts = _sorted_by_cell(points, low[0], low[1], cell_m, columns, rows)
    return PointIndex(
        points[order], normals[order], starts, float(low[0]), float(low[1]), cell_m, columns, rows
    )


@njit(cache=True)
def _sorted_by_cell(
    points: Array, origin_x_m: float, origin_y_m: float, cell_m: float, columns: int, rows: int
) -> tuple[IntArray, IntArray]:
    n = points.shape[0]
    cells = np.empty(n, dtype=np.int64)
    starts = np.zeros(columns * rows + 1, dtype=np.int64)
    for i in range(n):
        column = int((points[i, 0] - origin_x_m) / cell_m)
        row = int((points[i, 1] - origin_y_m) / cell_m)
        cells[i] = row * columns + column
        starts[cells[i] + 1] += 1
    for cell in range(columns * rows):
        starts[cell + 1] += starts[cell]
    filled = starts[:-1].copy()
    order = np.empty(n, dtype=np.int64)
    for i in range(n):
        order[filled[cells[i]]] = i
        filled[cells[i]] += 1
    return order, starts


@njit(cache=True)
def nearest(
    points: Array,
    starts: IntArray,
    origin_x_m: float,
    origin_y_m: float,
    cell_m: float,
    columns: int,
    rows: int,
    x_m: float,
    y_m: float,
    distance_m_max: float,
) -> int:
    """The index of the nearest point within distance_m_max <= cell_m, or -1."""
    column = math.floor((x_m - origin_x_m) / cell_m)
    row = math.floor((y_m - origin_y_m) / cell_m)
    best, best2 = -1, distance_m_max * distance_m_max
    for near_row in range(max(0, row - 1), min(rows, row + 2)):
        for near_column in range(max(0, column - 1), min(columns, column + 2)):
            cell = near_row * columns + near_column
            for i in range(starts[cell], starts[cell + 1]):
                dx, dy = points[i, 0] - x_m, points[i, 1] - y_m
                distance2 = dx * dx + dy * dy
                if distance2 < best2:
                    best, best2 = i, distance2
    return best
