"""Lookups in a trajectory's rows: by time, by length, and the nearest place."""

import math

import numpy as np
from numba import njit

from contract.geometry import Array, wrap_angle

# Columns of `signals.Trajectory.rows`.
T, X, Y, YAW, CURVATURE, SPEED, ACCEL = range(7)
# Faults of rows, by number; 0 is none.
FAULTS = ("", "too few rows", "not finite", "times do not rise", "speed out of reason", "it jumps")
SPEED_MPS_MAX = 20.0
# A row may be this much farther from the previous one than its speed explains.
JUMP_M = 0.5


@njit(cache=True)
def fault_number(rows: Array) -> int:
    """Index in FAULTS of the first fault of rows (k, 8); 0 if they can be followed."""
    k = rows.shape[0]
    if k < 2 or rows.shape[1] < 8:
        return 1
    for i in range(k):
        for j in range(7):
            if not math.isfinite(rows[i, j]):
                return 2
        if not -0.01 <= rows[i, SPEED] <= SPEED_MPS_MAX or abs(rows[i, CURVATURE]) > 2.0:
            return 4
        if i > 0:
            dt = rows[i, T] - rows[i - 1, T]
            if not dt > 0.0:
                return 3
            gap = math.hypot(rows[i, X] - rows[i - 1, X], rows[i, Y] - rows[i - 1, Y])
            if gap > JUMP_M + 2.0 * max(rows[i, SPEED], rows[i - 1, SPEED]) * dt:
                return 5
    return 0


@njit(cache=True)
def lengths(rows: Array) -> Array:
    """(k,) length along the rows (k, 8) from the first, in m; of arcs, by the rows' curvature."""
    s = np.zeros(rows.shape[0])
    for i in range(1, rows.shape[0]):
        chord = math.hypot(rows[i, X] - rows[i - 1, X], rows[i, Y] - rows[i - 1, Y])
        bend = 0.5 * (rows[i, CURVATURE] + rows[i - 1, CURVATURE]) * chord
        s[i] = s[i - 1] + chord * (1.0 + bend * bend / 24.0)
    return s


@njit(cache=True)
def at_time(rows: Array, s: Array, t_s: float, decel_mps2: float) -> tuple[float, float]:
    """(s in m, speed in m/s) of the trajectory t_s after its stamp.

    Before its first row it has the first row's speed. After its last row it brakes by decel_mps2 to a stop:
    rows that end in motion must not be followed beyond their end.
    """
    k = rows.shape[0]
    if t_s <= rows[0, T]:
        speed = rows[0, SPEED]
        return s[0] - speed * (rows[0, T] - t_s), speed
    if t_s >= rows[k - 1, T]:
        speed = rows[k - 1, SPEED]
        late = min(t_s - rows[k - 1, T], speed / decel_mps2)
        return s[k - 1] + speed * late - 0.5 * decel_mps2 * late * late, speed - decel_mps2 * late
    i = np.searchsorted(rows[:, T], t_s, side="right") - 1
    dt = rows[i + 1, T] - rows[i, T]
    u = (t_s - rows[i, T]) / dt
    v0, v1, ds = rows[i, SPEED], rows[i + 1, SPEED], s[i + 1] - s[i]
    # Cubic with the rows' speeds at its ends.
    position = s[i] + u * (dt * v0 + u * (3.0 * ds - dt * (2.0 * v0 + v1) + u * (dt * (v0 + v1) - 2.0 * ds)))
    return position, v0 + u * (v1 - v0)


@njit(cache=True)
def at_length(rows: Array, s: Array, s_m: float) -> tuple[float, float]:
    """(yaw in rad, curvature in 1/m) at s_m along the rows; straight on beyond either end."""
    k = rows.shape[0]
    if s_m <= s[0]:
        return rows[0, YAW], 0.0 if s_m < s[0] else rows[0, CURVATURE]
    if s_m >= s[k - 1]:
        return rows[k - 1, YAW], 0.0 if s_m > s[k - 1] else rows[k - 1, CURVATURE]
    i = np.searchsorted(s, s_m, side="right") - 1
    ds = s[i + 1] - s[i]
    u = (s_m - s[i]) / ds
    kappa = rows[i, CURVATURE] + u * (rows[i + 1, CURVATURE] - rows[i, CURVATURE])
    # The integral of this curvature, corrected so that it meets the next row's yaw.
    mean = 0.5 * (rows[i, CURVATURE] + rows[i + 1, CURVATURE]) * ds
    missing = wrap_angle(rows[i + 1, YAW] - rows[i, YAW]) - mean
    yaw = rows[i, YAW] + 0.5 * (rows[i, CURVATURE] + kappa) * u * ds + u * missing
    return yaw, kappa


@njit(cache=True)
def nearest(
    rows: Array, s: Array, x_m: float, y_m: float, near_m: float, window_m: float
) -> tuple[float, float]:
    """(s in m, offset in m, left positive) of (x, y) relative to the rows within window_m of near_m.

    Between rows the path is an arc; the offset is measured from the arc. Before the first and behind the last
    row it is straight along that row's yaw: the rows of a stop end so close together that the chord between
    them may point anywhere, also backwards.
    """
    k = rows.shape[0]
    best, position, offset = np.inf, s[0], 0.0
    for i in range(k - 1):
        length = s[i + 1] - s[i]
        if length <= 1e-9:
            continue
        if s[i] > near_m + window_m or s[i + 1] < near_m - window_m:
            continue
        ax, ay = rows[i, X], rows[i, Y]
        bx, by = rows[i + 1, X] - ax, rows[i + 1, Y] - ay
        chord = math.hypot(bx, by)
        px, py = x_m - ax, y_m - ay
        t = min(max((px * bx + py * by) / (chord * chord), 0.0), 1.0)
        ex, ey = px - t * bx, py - t * by
        distance = ex * ex + ey * ey
        if distance < best:
            best = distance
            side = (bx * py - by * px) / chord
            kappa = rows[i, CURVATURE] + t * (rows[i + 1, CURVATURE] - rows[i, CURVATURE])
            offset = side + 0.5 * kappa * chord * chord * t * (1.0 - t)
            position = s[i] + t * length
    for i, way in ((0, -1.0), (k - 1, 1.0)):
        if not near_m - window_m <= s[i] <= near_m + window_m:
            continue
        cos, sin = math.cos(rows[i, YAW]), math.sin(rows[i, YAW])
        px, py = x_m - rows[i, X], y_m - rows[i, Y]
        along, side = cos * px + sin * py, cos * py - sin * px
        if way * along > 0.0 and side * side < best:
            best, position, offset = side * side, s[i] + along, side
    return position, offset


@njit(cache=True)
def stop_rows(x_m: float, y_m: float, yaw_rad: float, speed_mps: float, decel_mps2: float) -> Array:
    """(k, 8) rows of a straight stop from a pose; of standing there at speed 0."""
    duration = max(speed_mps / decel_mps2, 0.1)
    n = 12
    rows = np.zeros((n, 8))
    for i in range(n):
        t = duration * i / (n - 1)
        s = speed_mps * t - 0.5 * decel_mps2 * t * t if speed_mps > 0.0 else 0.0
        rows[i, T], rows[i, SPEED] = t, max(0.0, speed_mps - decel_mps2 * t)
        rows[i, X], rows[i, Y] = x_m + s * math.cos(yaw_rad), y_m + s * math.sin(yaw_rad)
        rows[i, YAW], rows[i, 7] = yaw_rad, s
    if speed_mps <= 0.0:
        # A direction needs two different points.
        rows[n - 1, X] += 1e-3 * math.cos(yaw_rad)
        rows[n - 1, Y] += 1e-3 * math.sin(yaw_rad)
    return rows


@njit(cache=True)
def reference_at_times(
    rows: Array, s: Array, t_s: float, dt_s: float, steps: int, decel_mps2: float
) -> tuple[Array, Array]:
    """((steps + 1,) s in m, (steps + 1,) speeds) of the rows from t_s on, dt_s apart."""
    positions, speeds = np.empty(steps + 1), np.empty(steps + 1)
    for k in range(steps + 1):
        positions[k], speeds[k] = at_time(rows, s, t_s + k * dt_s, decel_mps2)
    return positions, speeds


@njit(cache=True)
def next_stop_m(rows: Array, s: Array, t_s: float) -> float:
    """s in m of the next stop in the rows, from t_s on; inf without one."""
    for i in range(rows.shape[0]):
        if rows[i, T] >= t_s and rows[i, SPEED] <= 0.01:
            return float(s[i])
    last = rows.shape[0] - 1
    return float(s[last]) if rows[last, SPEED] <= 0.01 else np.inf


@njit(cache=True)
def curvatures_ahead(rows: Array, s: Array, s_m: float, speeds: Array, dt_s: float) -> Array:
    """(n,) curvatures on the way from s_m on at speeds (n,), dt_s apart."""
    curvatures = np.empty(speeds.shape[0])
    for k in range(speeds.shape[0]):
        curvatures[k] = at_length(rows, s, s_m)[1]
        if k + 1 < speeds.shape[0]:
            s_m += 0.5 * (speeds[k] + speeds[k + 1]) * dt_s
    return curvatures
