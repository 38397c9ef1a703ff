"""A trajectory as control reads it: where it is along its own length, and what it asks for at a time."""

import math

import numpy as np
from numba import njit

from contract.geometry import Array, wrap_angle

# Columns of `signals.Trajectory.rows`.
T, X, Y, YAW, CURVATURE, SPEED, ACCEL = range(7)
# What is wrong with rows, by number; 0 is nothing.
FAULTS = ("", "too few rows", "not finite", "times do not rise", "speed out of reason", "it jumps")
SPEED_MPS_MAX = 20.0
# A row may be this much farther from the one before than its speed explains.
JUMP_M = 0.5


@njit(cache=True)
def fault_number(rows: Array) -> int:
    """Which of FAULTS rows (k, 8) have; a trajectory with none can be followed, wherever the vehicle is."""
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
    """(k,) metres along the rows (k, 8) from the first; arcs, not chords, by the rows' curvature."""
    s = np.zeros(rows.shape[0])
    for i in range(1, rows.shape[0]):
        chord = math.hypot(rows[i, X] - rows[i - 1, X], rows[i, Y] - rows[i - 1, Y])
        bend = 0.5 * (rows[i, CURVATURE] + rows[i - 1, CURVATURE]) * chord
        s[i] = s[i - 1] + chord * (1.0 + bend * bend / 24.0)
    return s


@njit(cache=True)
def at_time(rows: Array, s: Array, t_s: float, decel_mps2: float) -> tuple[float, float]:
    """(s in m, speed in m/s) that the trajectory asks for t_s after its stamp.

    Before its first row it goes on as it begins. After its last it brakes by decel_mps2 to a stop: rows
    that end in motion have run out, and nobody may drive on by them.
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
    place = s[i] + u * (dt * v0 + u * (3.0 * ds - dt * (2.0 * v0 + v1) + u * (dt * (v0 + v1) - 2.0 * ds)))
    return place, v0 + u * (v1 - v0)


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
    # The yaw that this curvature integrates to, less what it misses at the row's end.
    mean = 0.5 * (rows[i, CURVATURE] + rows[i + 1, CURVATURE]) * ds
    missing = wrap_angle(rows[i + 1, YAW] - rows[i, YAW]) - mean
    yaw = rows[i, YAW] + 0.5 * (rows[i, CURVATURE] + kappa) * u * ds + u * missing
    return yaw, kappa


@njit(cache=True)
def nearest(
    rows: Array, s: Array, x_m: float, y_m: float, near_m: float, window_m: float
) -> tuple[float, float]:
    """(s in m, offset in m, left positive) of (x, y) beside the rows within window_m of near_m along them.

    Between rows the path is their arc: the offset is taken from it, not from the chord. Before the first row
    and behind the last it goes straight on.
    """
    k = rows.shape[0]
    best, place, offset = np.inf, s[0], 0.0
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
        u = (px * bx + py * by) / (chord * chord)
        first, last = i == 0, i == k - 2 or s[k - 1] - s[i + 1] <= 1e-9
        t = u if (first and u < 0.0) or (last and u > 1.0) else min(max(u, 0.0), 1.0)
        ex, ey = px - t * bx, py - t * by
        distance = ex * ex + ey * ey
        if distance < best:
            best = distance
            side = (bx * py - by * px) / chord
            inside = min(max(t, 0.0), 1.0)
            kappa = rows[i, CURVATURE] + inside * (rows[i + 1, CURVATURE] - rows[i, CURVATURE])
            offset = side + 0.5 * kappa * chord * chord * inside * (1.0 - inside)
            place = s[i] + t * length
    return place, offset


@njit(cache=True)
def braking(x_m: float, y_m: float, yaw_rad: float, speed_mps: float, decel_mps2: float) -> Array:
    """(k, 8) rows straight on from a pose that brake to a stop, or ask for standing where it stands."""
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
        # A direction needs two different places.
        rows[n - 1, X] += 1e-3 * math.cos(yaw_rad)
        rows[n - 1, Y] += 1e-3 * math.sin(yaw_rad)
    return rows


@njit(cache=True)
def asked(
    rows: Array, s: Array, t_s: float, dt_s: float, steps: int, decel_mps2: float
) -> tuple[Array, Array]:
    """((steps + 1,) places in m, (steps + 1,) speeds) that the rows ask for from t_s on, dt_s apart."""
    places, speeds = np.empty(steps + 1), np.empty(steps + 1)
    for k in range(steps + 1):
        places[k], speeds[k] = at_time(rows, s, t_s + k * dt_s, decel_mps2)
    return places, speeds


@njit(cache=True)
def next_stop_m(rows: Array, s: Array, t_s: float) -> float:
    """Where along the rows they next ask for standing, from t_s on; inf when they do not."""
    for i in range(rows.shape[0]):
        if rows[i, T] >= t_s and rows[i, SPEED] <= 0.01:
            return float(s[i])
    last = rows.shape[0] - 1
    return float(s[last]) if rows[last, SPEED] <= 0.01 else np.inf


@njit(cache=True)
def bends(rows: Array, s: Array, s_m: float, speeds: Array, dt_s: float) -> Array:
    """(n,) curvatures met when driving on from s_m at speeds (n,), dt_s apart."""
    found = np.empty(speeds.shape[0])
    for k in range(speeds.shape[0]):
        found[k] = at_length(rows, s, s_m)[1]
        if k + 1 < speeds.shape[0]:
            s_m += 0.5 * (speeds[k] + speeds[k + 1]) * dt_s
    return found
