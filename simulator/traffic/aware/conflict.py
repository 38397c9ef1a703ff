"""When a person's way and a vehicle's predicted motion come too near to each other."""

import math

import numpy as np
from numba import njit

from contract.geometry import Array
from simulator.traffic.crowd import RADIUS_M, V_FRONT, V_HALF, V_REAR, V_SPEED, V_X, V_Y, V_YAW

# Predictions reach this far, in steps of PREDICTION_STEP_S.
PREDICTIONS = 34
PREDICTION_STEP_S = 0.15
# A vehicle farther away is not predicted against a person.
NEAR_M = 30.0
# A slower vehicle is predicted straight on.
_TURNING_MPS = 0.3
# columns of a vehicle's motion
M_YAW_RATE, M_ACCEL = range(2)


@njit(cache=True)
def predicted_poses(vehicles: Array, motions: Array) -> Array:
    """(m, PREDICTIONS, 3) x, y, yaw of each vehicle that goes on as it moves: it turns, it brakes.

    vehicles (m, 7) as in `traffic.crowd`; motions (m, 2): M_YAW_RATE, M_ACCEL. People see a vehicle brake and
    rely on it; they do not reckon with one that speeds up.
    """
    out = np.empty((vehicles.shape[0], PREDICTIONS, 3))
    for j in range(vehicles.shape[0]):
        x, y, yaw, speed = vehicles[j, V_X], vehicles[j, V_Y], vehicles[j, V_YAW], vehicles[j, V_SPEED]
        curvature = motions[j, M_YAW_RATE] / speed if abs(speed) > _TURNING_MPS else 0.0
        accel = min(0.0, motions[j, M_ACCEL])
        for k in range(PREDICTIONS):
            out[j, k, 0], out[j, k, 1], out[j, k, 2] = x, y, yaw
            way = speed * PREDICTION_STEP_S
            x += math.cos(yaw) * way
            y += math.sin(yaw) * way
            yaw += curvature * way
            if speed > 0.0:
                speed = max(0.0, speed + accel * PREDICTION_STEP_S)
    return out


@njit(cache=True)
def clearance_m(x: float, y: float, pose: Array, vehicle: Array) -> float:
    """From a person's disc to the outline of a vehicle at a pose (3,); negative for an overlap."""
    u, v = in_frame(x, y, pose)
    du = max(u - vehicle[V_FRONT], -vehicle[V_REAR] - u)
    dv = abs(v) - vehicle[V_HALF]
    apart_m = math.hypot(du, dv) if du > 0.0 and dv > 0.0 else max(du, dv)
    return apart_m - RADIUS_M


@njit(cache=True)
def in_frame(x: float, y: float, pose: Array) -> tuple[float, float]:
    """A place ahead of and left of a pose (3,)."""
    dx, dy = x - pose[0], y - pose[1]
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    return cos * dx + sin * dy, cos * dy - sin * dx


@njit(cache=True)
def first_conflict(places: Array, vehicle: Array, poses: Array, margin_m: float) -> tuple[int, float]:
    """(k, clearance at k) of the first predicted clearance below the margin; (PREDICTIONS, inf) for none.

    places (PREDICTIONS, 2) of the person. One who is nearer already is in conflict only by coming nearer.
    """
    now_m = clearance_m(places[0, 0], places[0, 1], poses[0], vehicle)
    least_m = min(margin_m, now_m - 0.05)
    reach_m = abs(vehicle[V_SPEED]) * PREDICTION_STEP_S * PREDICTIONS
    if now_m > NEAR_M + reach_m:
        return PREDICTIONS, math.inf
    for k in range(PREDICTIONS):
        there_m = clearance_m(places[k, 0], places[k, 1], poses[k], vehicle)
        if there_m < least_m:
            return k, there_m
    return PREDICTIONS, math.inf
