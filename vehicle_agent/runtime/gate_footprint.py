"""The gate's look ahead: how far is it to what the bumper will meet on the arc that is being steered?"""

import math

import numpy as np
from numba import njit

from contract.geometry import Array

_STRAIGHT_1PM = 1e-4


@njit(cache=True)
def distance_on_arc(
    points_base: Array, curvature_1pm: float, front_m: float, half_width_m: float, look_m: float
) -> float:
    """Travel to the nearest of the (n, 2) points before the bumper that the arc leads the body to; inf for
    none.

    Points beside or behind the bumper are not ahead of it and do not count.
    """
    nearest = np.inf
    for p in range(points_base.shape[0]):
        x, y = points_base[p, 0], points_base[p, 1]
        if x <= front_m - 0.1:
            continue
        if abs(curvature_1pm) < _STRAIGHT_1PM:
            if abs(y) <= half_width_m:
                nearest = min(nearest, x - front_m)
            continue
        radius = 1.0 / abs(curvature_1pm)
        left = y if curvature_1pm > 0.0 else -y
        rho = math.hypot(x, radius - left)
        outer = math.hypot(radius + half_width_m, front_m)
        if not (radius - half_width_m <= rho <= outer):
            continue
        # The place on the body that the point meets is as far from the turning centre as the point: on the
        # bumper, or nearer than its inner corner on the inner flank.
        to_point = math.atan2(x, radius - left)
        inner = radius - half_width_m
        if rho >= math.hypot(inner, front_m):
            to_body = math.asin(min(1.0, front_m / rho))
        else:
            to_body = math.acos(min(1.0, inner / rho))
        travel = (to_point - to_body) * radius
        if travel >= -0.1:
            nearest = min(nearest, max(0.0, travel))
    return nearest if nearest <= look_m else np.inf


def warm_footprint() -> None:
    """Loads the kernel, or compiles it: once it brakes or drives the gate has no time for that."""
    distance_on_arc(np.array([[5.0, 0.0]]), 0.1, 3.5, 0.8, 10.0)
