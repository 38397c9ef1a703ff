"""A trajectory from waypoints and speeds, for a planner that gives no times."""

import math

import numpy as np
from numba import njit

from contract.geometry import Array, arc_lengths, resample

SPACING_M = 0.25
SMOOTH_M = 1.0
ROWS_MAX = 200


@njit(cache=True)
def timed_rows(
    points: Array, speeds: Array, x_m: float, y_m: float, yaw_rad: float, speed_mps: float,
    now_mps: float, accel_mps2: float, decel_mps2: float,
) -> Array:  # fmt: skip
    """(k, 8) rows from the vehicle through waypoints (n, 2) ahead with speeds (n,).

    x_m, y_m, yaw_rad, now_mps  of the vehicle at time 0; speed_mps: speed limit
    The rows begin at the vehicle's speed and change it by accel_mps2 and decel_mps2 at most. They end at the
    first rest of the waypoints, otherwise at the last waypoint. (0, 8) without two different waypoints ahead.
    """
    line = _line(points, x_m, y_m, yaw_rad)
    if line.shape[0] < 3:
        return np.zeros((0, 8))
    marks = arc_lengths(line)
    dense = resample(line, SPACING_M)[:ROWS_MAX]
    s = arc_lengths(dense)
    n = s.shape[0]
    yaw, kappa = _smooth(dense, s)
    at = np.empty(line.shape[0])
    skipped = line.shape[0] - speeds.shape[0]
    for i in range(line.shape[0]):
        at[i] = min(speed_mps, max(0.0, speeds[max(0, i - skipped)]))
    v = _reachable_speeds(np.interp(s, marks, at), s, now_mps, accel_mps2, decel_mps2)
    rows = np.zeros((n, 8))
    for i in range(n):
        if i > 0:
            mean = max(0.5 * (v[i] + v[i - 1]), 1e-3)
            rows[i, 0] = rows[i - 1, 0] + (s[i] - s[i - 1]) / mean
            rows[i, 6] = (v[i] - v[i - 1]) / (rows[i, 0] - rows[i - 1, 0])
            if v[i] <= 0.0 and v[i - 1] <= 0.0:
                return rows[:i].copy() if i > 1 else rows[:0].copy()
        rows[i, 1], rows[i, 2], rows[i, 3] = dense[i, 0], dense[i, 1], yaw[i]
        rows[i, 4], rows[i, 5], rows[i, 7] = kappa[i], v[i], s[i]
    return rows


@njit(cache=True)
def _reachable_speeds(limit: Array, s: Array, now_mps: float, accel_mps2: float, decel_mps2: float) -> Array:
    """(n,) speeds at s (n,) from now_mps on, below the limits (n,) where the accelerations allow it."""
    n = s.shape[0]
    v = np.empty(n)
    for i in range(n - 2, -1, -1):
        limit[i] = min(limit[i], math.sqrt(limit[i + 1] ** 2 + 2.0 * decel_mps2 * (s[i + 1] - s[i])))
    v[0] = now_mps
    for i in range(1, n):
        ds = s[i] - s[i - 1]
        slowest = math.sqrt(max(0.0, v[i - 1] ** 2 - 2.0 * decel_mps2 * ds))
        v[i] = max(slowest, min(limit[i], math.sqrt(v[i - 1] ** 2 + 2.0 * accel_mps2 * ds)))
    return v


@njit(cache=True)
def _line(points: Array, x_m: float, y_m: float, yaw_rad: float) -> Array:
    """(m, 2) the waypoints ahead, extended back along their first direction to the vehicle."""
    n = points.shape[0]
    first = 0
    while first < n and (
        (points[first, 0] - x_m) * math.cos(yaw_rad) + (points[first, 1] - y_m) * math.sin(yaw_rad) < 0.3
    ):
        first += 1
    if n - first < 2:
        return points[:0]
    a, b = points[first], points[first + 1]
    gap = math.hypot(b[0] - a[0], b[1] - a[1])
    if gap < 1e-6:
        return points[:0]
    ux, uy = (b[0] - a[0]) / gap, (b[1] - a[1]) / gap
    back = max(0.3, (a[0] - x_m) * ux + (a[1] - y_m) * uy)
    line = np.empty((n - first + 1, 2))
    line[0, 0], line[0, 1] = a[0] - back * ux, a[1] - back * uy
    line[1:] = points[first:]
    return line


@njit(cache=True)
def _smooth(points: Array, s: Array) -> tuple[Array, Array]:
    """(yaw (n,) continuous, curvature (n,)) of points (n, 2), averaged over SMOOTH_M on both sides, since
    waypoints have corners."""
    n = points.shape[0]
    raw = np.empty(n)
    for i in range(n):
        a, b = max(0, i - 1), min(n - 1, i + 1)
        raw[i] = math.atan2(points[b, 1] - points[a, 1], points[b, 0] - points[a, 0])
        if i > 0:
            turn = raw[i] - raw[i - 1]
            raw[i] -= 2.0 * math.pi * round(turn / (2.0 * math.pi))
    reach = max(1, round(SMOOTH_M / SPACING_M))
    yaw, kappa = np.empty(n), np.zeros(n)
    for i in range(n):
        wide = min(reach, i, n - 1 - i)
        yaw[i] = raw[i - wide : i + wide + 1].mean()
    for i in range(1, n - 1):
        kappa[i] = (yaw[i + 1] - yaw[i - 1]) / max(1e-6, s[i + 1] - s[i - 1])
    if n > 2:
        kappa[0], kappa[n - 1] = kappa[1], kappa[n - 2]
    return yaw, kappa
