"""Reading a trajectory at a time, and turning it into a stop."""

import math

import numpy as np
from numba import njit

from contract.geometry import Array
from vehicle_agent.signals import Trajectory

T, X, Y, YAW, CURVATURE, SPEED, ACCEL, S = range(8)
COLUMNS = 8


def row_at(trajectory: Trajectory, now_ns: int) -> Array:
    """(8,) the trajectory's row of a moment; its first or last one outside its time."""
    row: Array = interpolated(trajectory.rows, (now_ns - trajectory.stamp_ns) * 1e-9)
    return row


@njit(cache=True)
def interpolated(rows: Array, t_s: float) -> Array:
    """(8,) between the (k, 8) rows; headings are continuous along them."""
    k = rows.shape[0]
    if t_s <= rows[0, T]:
        row: Array = rows[0].copy()
    elif t_s >= rows[k - 1, T]:
        row = rows[k - 1].copy()
    else:
        i = int(np.searchsorted(rows[:, T], t_s, side="right"))
        share = (t_s - rows[i - 1, T]) / (rows[i, T] - rows[i - 1, T])
        row = rows[i - 1] + share * (rows[i] - rows[i - 1])
    return row


def stopping(trajectory: Trajectory, now_ns: int, decel_mps2: float) -> Trajectory:
    """A stop from now on along the same path, at constant deceleration; straight beyond the path's end.

    The fallback when no planner answers; it exists for every trajectory.
    """
    return Trajectory(now_ns, _stopped(trajectory.rows, (now_ns - trajectory.stamp_ns) * 1e-9, decel_mps2))


@njit(cache=True)
def _stopped(rows: Array, t_s: float, decel: float) -> Array:
    here: Array = interpolated(rows, t_s)
    travelled = np.zeros(rows.shape[0])
    for i in range(1, rows.shape[0]):
        travelled[i] = travelled[i - 1] + math.hypot(rows[i, X] - rows[i - 1, X], rows[i, Y] - rows[i - 1, Y])
    # How far along the path we are now: the time's share of the piece that it falls into.
    i = min(max(int(np.searchsorted(rows[:, T], t_s, side="right")), 1), rows.shape[0] - 1)
    span = max(rows[i, T] - rows[i - 1, T], 1e-9)
    share = min(max((t_s - rows[i - 1, T]) / span, 0.0), 1.0)
    begun = travelled[i - 1] + share * (travelled[i] - travelled[i - 1])
    speed = max(0.0, here[SPEED])
    count = math.ceil(speed / decel / 0.1) + 2
    out = np.empty((count, COLUMNS))
    for k in range(count):
        t = 0.1 * k
        rest = min(t, speed / decel)
        gone = speed * rest - 0.5 * decel * rest * rest
        out[k] = _on_path(rows, travelled, begun + gone)
        out[k, T] = t
        out[k, SPEED] = max(0.0, speed - decel * t)
        out[k, ACCEL] = -decel if t < speed / decel else 0.0
        out[k, S] = here[S] + gone
    return out


@njit(cache=True)
def _on_path(rows: Array, travelled: Array, along: float) -> Array:
    last = rows.shape[0] - 1
    row: Array = rows[last].copy()
    if along >= travelled[last]:
        over = along - travelled[last]
        row[X] += over * math.cos(row[YAW])
        row[Y] += over * math.sin(row[YAW])
        row[CURVATURE] = 0.0
        return row
    i = max(1, int(np.searchsorted(travelled, along, side="right")))
    span = travelled[i] - travelled[i - 1]
    share = 0.0 if span <= 0.0 else (along - travelled[i - 1]) / span
    row = rows[i - 1] + share * (rows[i] - rows[i - 1])
    return row
