"""Oriented boxes around objects, of whose sides a lidar sees one or two."""

import math

import numpy as np
from numba import njit

from contract.geometry import Array
from vehicle_agent.perception.points.fine_cells import COUNT, LOW, TALL, TOP, UPPER, X, Y

# Columns of a box.
BX, BY, YAW, LENGTH, WIDTH, B_TOP, B_LOW, B_TALL, RETURNS, ABOVE_CHEST, GAP, CELLS = range(12)
BOX_COLUMNS = 12
# Directions that are tried; and the least distance to a side that counts (Zhang et al. 2017, d0).
_ANGLES = 30
_NEAREST_M = 0.03
# Objects with more cells are walls and hedges: they get a box along the axes.
_CELLS_MAX = 400


@njit(cache=True)
def object_boxes(values: np.ndarray, labels: np.ndarray, count: int, cell_m: float) -> Array:
    """(objects, 12) the box of each object, and what its returns look like.

    values (k, 7), labels (k,): as `fine_cells` and `connected` give them; cell_m: side of a small cell

    x, y, yaw of the middle; length >= width; highest and lowest return; highest up to 2.7 m; returns;
    returns above the chest; mean distance of the cells from the nearest side, m; cells. Yaw is along the
    length, in [-pi/2, pi/2]. Of all directions that one is taken whose box has the cells nearest to its
    sides: Zhang, Xu, Dong, Dolan, "Efficient L-shape fitting for vehicle detection using laser scanners"
    (2017), algorithm 4.
    """
    begin, order = _by_object(labels, count)
    boxes = np.zeros((count, BOX_COLUMNS))
    for n in range(count):
        cells = order[begin[n] : begin[n + 1]]
        boxes[n, B_LOW] = 99.0
        for a in cells:
            boxes[n, B_TOP] = max(boxes[n, B_TOP], values[a, TOP])
            boxes[n, B_LOW] = min(boxes[n, B_LOW], values[a, LOW])
            boxes[n, B_TALL] = max(boxes[n, B_TALL], values[a, TALL])
            boxes[n, RETURNS] += values[a, COUNT]
            boxes[n, ABOVE_CHEST] += values[a, UPPER]
        boxes[n, CELLS] = len(cells)
        angles = _ANGLES if len(cells) <= _CELLS_MAX else 1
        best = -1.0
        for turn in range(angles):
            theta = 0.5 * math.pi * turn / _ANGLES
            closeness = _closeness(values, cells, math.cos(theta), math.sin(theta))
            if closeness > best:
                best = closeness
                boxes[n, YAW] = theta
        _set_box(boxes[n], values, cells, cell_m)
    return boxes


@njit(cache=True)
def _by_object(labels: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """((count + 1,) begin of each object's cells, (k,) cells in the order of their objects)."""
    begin = np.zeros(count + 1, np.int64)
    for a in range(labels.shape[0]):
        begin[labels[a] + 1] += 1
    for n in range(count):
        begin[n + 1] += begin[n]
    at = begin[:count].copy()
    order = np.empty(labels.shape[0], np.int64)
    for a in range(labels.shape[0]):
        order[at[labels[a]]] = a
        at[labels[a]] += 1
    return begin, order


@njit(cache=True)
def _sides(
    values: np.ndarray, cells: np.ndarray, cos: float, sin: float
) -> tuple[float, float, float, float]:
    low1, high1, low2, high2 = 1e9, -1e9, 1e9, -1e9
    for a in cells:
        c1 = cos * values[a, X] + sin * values[a, Y]
        c2 = -sin * values[a, X] + cos * values[a, Y]
        low1, high1 = min(low1, c1), max(high1, c1)
        low2, high2 = min(low2, c2), max(high2, c2)
    return low1, high1, low2, high2


@njit(cache=True)
def _near_sides(
    values: np.ndarray, cells: np.ndarray, cos: float, sin: float
) -> tuple[float, float, float, float, bool, bool]:
    """The sides, and whether the cells are nearer to the upper one along each axis."""
    low1, high1, low2, high2 = _sides(values, cells, cos, sin)
    below1, above1, below2, above2 = 0.0, 0.0, 0.0, 0.0
    for a in cells:
        c1 = cos * values[a, X] + sin * values[a, Y]
        c2 = -sin * values[a, X] + cos * values[a, Y]
        below1 += (c1 - low1) ** 2
        above1 += (high1 - c1) ** 2
        below2 += (c2 - low2) ** 2
        above2 += (high2 - c2) ** 2
    return low1, high1, low2, high2, above1 < below1, above2 < below2


@njit(cache=True)
def _closeness(values: np.ndarray, cells: np.ndarray, cos: float, sin: float) -> float:
    low1, high1, low2, high2, upper1, upper2 = _near_sides(values, cells, cos, sin)
    total = 0.0
    for a in cells:
        c1 = cos * values[a, X] + sin * values[a, Y]
        c2 = -sin * values[a, X] + cos * values[a, Y]
        d1 = high1 - c1 if upper1 else c1 - low1
        d2 = high2 - c2 if upper2 else c2 - low2
        total += 1.0 / max(min(d1, d2), _NEAREST_M)
    return total


@njit(cache=True)
def _set_box(box: np.ndarray, values: np.ndarray, cells: np.ndarray, cell_m: float) -> None:
    """Middle, length, width, and the mean distance from the nearest side; box has the direction."""
    theta = box[YAW]
    cos, sin = math.cos(theta), math.sin(theta)
    low1, high1, low2, high2, upper1, upper2 = _near_sides(values, cells, cos, sin)
    for a in cells:
        c1 = cos * values[a, X] + sin * values[a, Y]
        c2 = -sin * values[a, X] + cos * values[a, Y]
        d1 = high1 - c1 if upper1 else c1 - low1
        d2 = high2 - c2 if upper2 else c2 - low2
        box[GAP] += min(d1, d2) / len(cells)
    middle1, middle2 = 0.5 * (low1 + high1), 0.5 * (low2 + high2)
    box[BX], box[BY] = cos * middle1 - sin * middle2, sin * middle1 + cos * middle2
    # Cells are known by their mean: the returns reach a little farther.
    along, across = high1 - low1 + 0.5 * cell_m, high2 - low2 + 0.5 * cell_m
    if across > along:
        theta, along, across = theta + 0.5 * math.pi, across, along
    box[YAW] = theta - math.pi if theta > 0.5 * math.pi else theta
    box[LENGTH], box[WIDTH] = along, across
