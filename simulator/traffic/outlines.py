"""Overlap of a vehicle's rectangle with another one or a wall. Vehicle rows as in `traffic.crowd`."""

import math

import numpy as np
from numba import njit

from contract.geometry import Array
from simulator.traffic.crowd import V_FRONT, V_HALF, V_REAR, V_X, V_Y, V_YAW

_NEAR_M = 8.0


@njit(cache=True)
def _corners(vehicle: Array) -> Array:
    cos, sin = math.cos(vehicle[V_YAW]), math.sin(vehicle[V_YAW])
    corners = np.empty((4, 2))
    for k in range(4):
        bx = vehicle[V_FRONT] if k < 2 else -vehicle[V_REAR]
        by = vehicle[V_HALF] if k in (0, 3) else -vehicle[V_HALF]
        corners[k, 0] = vehicle[V_X] + cos * bx - sin * by
        corners[k, 1] = vehicle[V_Y] + sin * bx + cos * by
    return corners


@njit(cache=True)
def outlines_overlap(a: Array, b: Array) -> bool:
    """Two vehicles' rectangles share a point (separating axes)."""
    if math.hypot(a[V_X] - b[V_X], a[V_Y] - b[V_Y]) > 2.0 * _NEAR_M:
        return False
    ca, cb = _corners(a), _corners(b)
    for yaw in (a[V_YAW], b[V_YAW]):
        for ux, uy in ((math.cos(yaw), math.sin(yaw)), (-math.sin(yaw), math.cos(yaw))):
            pa, pb = ca[:, 0] * ux + ca[:, 1] * uy, cb[:, 0] * ux + cb[:, 1] * uy
            if pa.max() < pb.min() or pb.max() < pa.min():
                return False
    return True


@njit(cache=True)
def outline_meets_edges(vehicle: Array, edges: Array) -> bool:
    """A wall (n, 4: x0, y0, x1, y1) crosses or lies in the vehicle's rectangle."""
    cos, sin = math.cos(vehicle[V_YAW]), math.sin(vehicle[V_YAW])
    for k in range(edges.shape[0]):
        x0, y0 = edges[k, 0] - vehicle[V_X], edges[k, 1] - vehicle[V_Y]
        x1, y1 = edges[k, 2] - vehicle[V_X], edges[k, 3] - vehicle[V_Y]
        if min(x0, x1) > _NEAR_M or max(x0, x1) < -_NEAR_M or min(y0, y1) > _NEAR_M or max(y0, y1) < -_NEAR_M:
            continue
        a = (cos * x0 + sin * y0, -sin * x0 + cos * y0)
        b = (cos * x1 + sin * y1, -sin * x1 + cos * y1)
        if _segment_in_rectangle(a, b, vehicle):
            return True
    return False


@njit(cache=True)
def _segment_in_rectangle(a: tuple[float, float], b: tuple[float, float], vehicle: Array) -> bool:
    """Liang-Barsky clipping of segment a-b (base frame) by the outline."""
    near, far = 0.0, 1.0
    dx, dy = b[0] - a[0], b[1] - a[1]
    for o, d, low, high in (
        (a[0], dx, -vehicle[V_REAR], vehicle[V_FRONT]),
        (a[1], dy, -vehicle[V_HALF], vehicle[V_HALF]),
    ):
        if d == 0.0:
            if o < low or o > high:
                return False
            continue
        t0, t1 = (low - o) / d, (high - o) / d
        near, far = max(near, min(t0, t1)), min(far, max(t0, t1))
    return near <= far
