"""Line of sight between a sensor and its targets, in the plane."""

import math

import numpy as np
from numba import njit

from contract.geometry import Array


@njit(cache=True)
def visible(
    sensor_x: float, sensor_y: float, poses: Array, sizes: Array, discs: Array, edges: Array, boxes: Array
) -> Array:
    """(n,) 1.0 for every target whose middle or an outer end is visible, 0.0 for the others.

    poses (n, 3) and sizes (n, 2) of the targets, discs (n,) 1.0 for people; edges (k, 4) walls;
    boxes (m, 7) as in `ray_hits`: occluding objects. A box does not occlude a target whose middle is inside.
    """
    seen = np.zeros(poses.shape[0])
    for i in range(poses.shape[0]):
        x, y = poses[i, 0], poses[i, 1]
        bearing = math.atan2(y - sensor_y, x - sensor_x)
        if discs[i] > 0.0:
            half = 0.5 * sizes[i, 0]
        else:
            turned = poses[i, 2] - bearing
            half = 0.5 * (abs(sizes[i, 0] * math.sin(turned)) + abs(sizes[i, 1] * math.cos(turned)))
        for side in (0.0, 0.9, -0.9):
            px = x - side * half * math.sin(bearing)
            py = y + side * half * math.cos(bearing)
            if _is_clear(sensor_x, sensor_y, px, py, x, y, edges, boxes):
                seen[i] = 1.0
                break
    return seen


@njit(cache=True)
def _is_clear(
    ax: float, ay: float, bx: float, by: float, x: float, y: float, edges: Array, boxes: Array
) -> bool:
    for k in range(edges.shape[0]):
        if _cross(ax, ay, bx, by, edges[k, 0], edges[k, 1], edges[k, 2], edges[k, 3]):
            return False
    for k in range(boxes.shape[0]):
        cos, sin = math.cos(boxes[k, 2]), math.sin(boxes[k, 2])
        dx, dy = x - boxes[k, 0], y - boxes[k, 1]
        u, v = cos * dx + sin * dy, -sin * dx + cos * dy
        if -boxes[k, 3] <= u <= boxes[k, 4] and abs(v) <= boxes[k, 5]:
            continue
        if _meets_box(ax, ay, bx, by, boxes[k]):
            return False
    return True


@njit(cache=True)
def _cross(ax: float, ay: float, bx: float, by: float, cx: float, cy: float, dx: float, dy: float) -> bool:
    """Segments a-b and c-d share an inner point."""
    d1 = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
    d2 = (bx - ax) * (dy - ay) - (by - ay) * (dx - ax)
    if d1 * d2 > 0.0:
        return False
    d3 = (dx - cx) * (ay - cy) - (dy - cy) * (ax - cx)
    d4 = (dx - cx) * (by - cy) - (dy - cy) * (bx - cx)
    return d3 * d4 < 0.0


@njit(cache=True)
def _meets_box(ax: float, ay: float, bx: float, by: float, box: Array) -> bool:
    """Liang-Barsky clipping of segment a-b by the box's outline."""
    cos, sin = math.cos(box[2]), math.sin(box[2])
    ux, uy = ax - box[0], ay - box[1]
    vx, vy = bx - box[0], by - box[1]
    px, py = cos * ux + sin * uy, -sin * ux + cos * uy
    qx, qy = cos * vx + sin * vy, -sin * vx + cos * vy
    near, far = 0.0, 1.0
    for o, d, low, high in (
        (px, qx - px, -box[3], box[4]),
        (py, qy - py, -box[5], box[5]),
    ):
        if d == 0.0:
            if o < low or o > high:
                return False
            continue
        t0, t1 = (low - o) / d, (high - o) / d
        near, far = max(near, min(t0, t1)), min(far, max(t0, t1))
    return near <= far
