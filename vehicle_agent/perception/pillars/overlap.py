"""How much rectangles on the ground overlap, and which of overlapping ones stay."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from contract.geometry import Array

# A rectangle that is cut by four lines has at most eight corners.
_CORNERS = 8


@njit(cache=True)
def iou(first: Array, second: Array) -> float:
    """Area of both over area of either, 0 to 1, of two rectangles (5,): x, y, yaw, length, width."""
    reach = 0.5 * (math.hypot(first[3], first[4]) + math.hypot(second[3], second[4]))
    if math.hypot(first[0] - second[0], first[1] - second[1]) >= reach:
        return 0.0
    # The second's corners in the first's frame, cut by its four sides (Sutherland and Hodgman 1974).
    cos, sin = math.cos(first[2]), math.sin(first[2])
    c, s = math.cos(second[2] - first[2]), math.sin(second[2] - first[2])
    dx, dy = second[0] - first[0], second[1] - first[1]
    mx, my = cos * dx + sin * dy, -sin * dx + cos * dy
    corners = np.empty((2 * _CORNERS, 2))
    cut = np.empty((2 * _CORNERS, 2))
    for k in range(4):
        a = 0.5 * second[3] * (1.0 if k in (0, 3) else -1.0)
        b = 0.5 * second[4] * (1.0 if k < 2 else -1.0)
        corners[k, 0], corners[k, 1] = mx + c * a - s * b, my + s * a + c * b
    count = 4
    for side in range(4):
        axis, sign = side // 2, 1.0 if side % 2 == 0 else -1.0
        limit = 0.5 * (first[3] if axis == 0 else first[4])
        left = 0
        for k in range(count):
            here, there = corners[k], corners[(k + 1) % count]
            in_here, in_there = limit - sign * here[axis], limit - sign * there[axis]
            if in_here >= 0.0:
                cut[left] = here
                left += 1
            if (in_here > 0.0 and in_there < 0.0) or (in_here < 0.0 and in_there > 0.0):
                share = in_here / (in_here - in_there)
                cut[left] = here + share * (there - here)
                left += 1
        count = left
        corners, cut = cut, corners
        if count < 3:
            return 0.0
    doubled = 0.0
    for k in range(count):
        j = (k + 1) % count
        doubled += corners[k, 0] * corners[j, 1] - corners[j, 0] * corners[k, 1]
    both = 0.5 * abs(doubled)
    either = first[3] * first[4] + second[3] * second[4] - both
    return both / either if either > 0.0 else 0.0


@njit(cache=True)
def kept_of(boxes: Array, iou_max: float, kept_max: int) -> NDArray[np.int64]:
    """Rows (k,) of boxes (n, 5+), best first, that overlap no better one by more than iou_max."""
    kept = np.empty(min(kept_max, boxes.shape[0]), np.int64)
    count = 0
    for row in range(boxes.shape[0]):
        if count == kept.shape[0]:
            break
        is_free = True
        for k in range(count):
            if iou(boxes[row, :5], boxes[kept[k], :5]) > iou_max:
                is_free = False
                break
        if is_free:
            kept[count] = row
            count += 1
    return kept[:count].copy()
