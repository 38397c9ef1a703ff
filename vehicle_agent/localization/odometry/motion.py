"""Rigid motions as 4 x 4 matrices and as twists (6,): translation, then rotation vector (Eade 2013)."""

import math

import numpy as np
from numba import njit

from contract.geometry import Array


@njit(cache=True)
def exponential(twist: Array) -> Array:
    """The motion (4, 4) of a constant twist after one unit of time."""
    x, y, z = twist[3], twist[4], twist[5]
    angle = math.sqrt(x * x + y * y + z * z)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    square = cross @ cross
    if angle < 1e-9:
        a, b, c = 1.0, 0.5, 1.0 / 6.0
    else:
        a = math.sin(angle) / angle
        b = (1.0 - math.cos(angle)) / (angle * angle)
        c = (angle - math.sin(angle)) / (angle * angle * angle)
    motion = np.eye(4)
    motion[:3, :3] += a * cross + b * square
    motion[:3, 3] = (np.eye(3) + b * cross + c * square) @ twist[:3].copy()
    return motion


@njit(cache=True)
def logarithm(motion: Array) -> Array:
    """The twist (6,) whose `exponential` is this motion; turns below 180 degrees."""
    cosine = min(1.0, max(-1.0, 0.5 * (motion[0, 0] + motion[1, 1] + motion[2, 2] - 1.0)))
    angle = math.acos(cosine)
    scale = 0.5 if angle < 1e-6 else 0.5 * angle / math.sin(angle)
    twist = np.zeros(6)
    twist[3] = scale * (motion[2, 1] - motion[1, 2])
    twist[4] = scale * (motion[0, 2] - motion[2, 0])
    twist[5] = scale * (motion[1, 0] - motion[0, 1])
    x, y, z = twist[3], twist[4], twist[5]
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    if angle < 1e-6:
        d = 1.0 / 12.0
    else:
        half = 0.5 * angle
        d = (1.0 - half * math.cos(half) / math.sin(half)) / (angle * angle)
    back = np.eye(3) - 0.5 * cross + d * (cross @ cross)
    twist[:3] = back @ motion[:3, 3].copy()
    return twist


def inverted(motion: Array) -> Array:
    """The motion back."""
    back = np.eye(4)
    back[:3, :3] = motion[:3, :3].T
    back[:3, 3] = -motion[:3, :3].T @ motion[:3, 3]
    return back


@njit(cache=True)
def deskewed(points: Array, times_s: Array, twist_per_s: Array) -> Array:
    """Points (n, 3) as they would have been measured at time 0, from a sensor that moves with this twist.

    times_s (n,): of each point, before (negative) or after time 0. The motion of a scan is a degree or two,
    so the rotation's first two orders are enough.
    """
    moved = np.empty_like(points)
    vx, vy, vz, wx, wy, wz = twist_per_s
    for i in range(points.shape[0]):
        t = times_s[i]
        rx, ry, rz = wx * t, wy * t, wz * t
        px, py, pz = points[i, 0], points[i, 1], points[i, 2]
        cx, cy, cz = ry * pz - rz * py, rz * px - rx * pz, rx * py - ry * px
        # v t + w t x (v t) / 2, the second order of the exponential.
        tx, ty, tz = vx * t, vy * t, vz * t
        moved[i, 0] = px + cx + 0.5 * (ry * cz - rz * cy) + tx + 0.5 * (ry * tz - rz * ty)
        moved[i, 1] = py + cy + 0.5 * (rz * cx - rx * cz) + ty + 0.5 * (rz * tx - rx * tz)
        moved[i, 2] = pz + cz + 0.5 * (rx * cy - ry * cx) + tz + 0.5 * (rx * ty - ry * tx)
    return moved
