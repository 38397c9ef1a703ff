"""The gate's footprint test: what is in the way on the steered arc, and still is on arrival."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from contract.geometry import Array

_STRAIGHT_1PM = 1e-4
_STEP_S = 0.05
# Deep enough that a road user does not pass it between two steps.
_ZONE_M = 0.6


@njit(cache=True)
def distance_on_arc(points_base: Array, curvature_1pm: float, front_m: float, half_width_m: float) -> float:
    """Travel until the body touches the nearest of the (n, 2) points on the arc; inf for none.

    Points alongside or behind the bumper do not count.
    """
    nearest = np.inf
    for p in range(points_base.shape[0]):
        x, y = points_base[p, 0], points_base[p, 1]
        if x < front_m:
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
        # The point of the body that is touched is as far from the turning centre as the point: on the bumper,
        # or on the inner flank if that is nearer than the inner corner.
        to_point = math.atan2(x, radius - left)
        inner = radius - half_width_m
        if rho >= math.hypot(inner, front_m):
            to_body = math.asin(min(1.0, front_m / rho))
        else:
            to_body = math.acos(min(1.0, inner / rho))
        travel = (to_point - to_body) * radius
        if travel >= 0.0:
            nearest = min(nearest, travel)
    return nearest


@njit(cache=True)
def is_met_on_arc(
    points_base: Array,
    velocities_mps: Array,
    curvature_1pm: float,
    speed_mps: float,
    delay_s: float,
    brake_mps2: float,
    margin_m: float,
    front_m: float,
    half_width_m: float,
) -> bool:
    """True if a point (n, 2) is in the way now, and at the bumper when the vehicle arrives.

    velocities_mps (n, 2) are over ground. The vehicle brakes by brake_mps2 from delay_s on.
    """
    end_s = delay_s + speed_mps / brake_mps2
    look_m = speed_mps * delay_s + speed_mps**2 / (2.0 * brake_mps2) + margin_m
    for p in range(points_base.shape[0]):
        if distance_on_arc(points_base[p : p + 1], curvature_1pm, front_m, half_width_m) > look_m:
            continue
        for k in range(1, math.ceil(end_s / _STEP_S) + 1):
            t = min(k * _STEP_S, end_s)
            late = max(0.0, t - delay_s)
            way = speed_mps * t - 0.5 * brake_mps2 * late * late
            x = points_base[p, 0] + t * velocities_mps[p, 0]
            y = points_base[p, 1] + t * velocities_mps[p, 1]
            yaw = curvature_1pm * way
            if abs(curvature_1pm) < _STRAIGHT_1PM:
                dx, dy = x - way, y
            else:
                dx, dy = x - math.sin(yaw) / curvature_1pm, y - (1.0 - math.cos(yaw)) / curvature_1pm
            cos, sin = math.cos(yaw), math.sin(yaw)
            ahead, aside = cos * dx + sin * dy, cos * dy - sin * dx
            if front_m - _ZONE_M <= ahead <= front_m + margin_m and abs(aside) <= half_width_m:
                return True
    return False


@njit(cache=True)
def are_apart(points: Array, places: Array, within_m: float) -> NDArray[np.bool_]:
    """(n,) for each point (n, 2) whether none of the places (m, 2) is that near to it."""
    apart = np.ones(points.shape[0], dtype=np.bool_)
    for p in range(points.shape[0]):
        for k in range(places.shape[0]):
            dx, dy = points[p, 0] - places[k, 0], points[p, 1] - places[k, 1]
            if dx * dx + dy * dy <= within_m * within_m:
                apart[p] = False
                break
    return apart


def warm_footprint() -> None:
    """Loads or compiles the kernels: the driving gate has no time for that."""
    are_apart(np.array([[5.0, 0.0]]), np.zeros((1, 2)), 0.7)
    is_met_on_arc(np.array([[5.0, 0.0]]), np.zeros((1, 2)), 0.1, 4.0, 0.3, 5.0, 0.1, 3.5, 0.8)
