"""Poses as arrays (..., 3) of x_m, y_m, yaw_rad, for kernels and whole trajectories.

`contract.geometry` has the same for single `Pose2` values.
"""

import math

import numpy as np
from numba import njit

from contract.geometry import TWO_PI, Array


def wrapped(angles_rad: Array) -> Array:
    """The same directions in (-pi, pi]."""
    out: Array = math.pi - np.mod(math.pi - angles_rad, TWO_PI)
    return out


def composed(T_a_b: Array, T_b_c: Array) -> Array:
    """(..., 3) T_a_c of poses (..., 3), which broadcast."""
    cos, sin = np.cos(T_a_b[..., 2]), np.sin(T_a_b[..., 2])
    return np.stack(
        [
            T_a_b[..., 0] + cos * T_b_c[..., 0] - sin * T_b_c[..., 1],
            T_a_b[..., 1] + sin * T_b_c[..., 0] + cos * T_b_c[..., 1],
            wrapped(T_a_b[..., 2] + T_b_c[..., 2]),
        ],
        axis=-1,
    )


def between(T_a_b: Array, T_a_c: Array) -> Array:
    """(..., 3) T_b_c: c as b sees it."""
    dx_m, dy_m = T_a_c[..., 0] - T_a_b[..., 0], T_a_c[..., 1] - T_a_b[..., 1]
    cos, sin = np.cos(T_a_b[..., 2]), np.sin(T_a_b[..., 2])
    return np.stack(
        [cos * dx_m + sin * dy_m, cos * dy_m - sin * dx_m, wrapped(T_a_c[..., 2] - T_a_b[..., 2])], axis=-1
    )


@njit(cache=True)
def moved(points_b: Array, normals_b: Array, T_a_b: Array, points_a: Array, normals_a: Array) -> None:
    """Writes (n, 2) points and normals of frame b in frame a into the last two arguments."""
    cos, sin = math.cos(T_a_b[2]), math.sin(T_a_b[2])
    for i in range(points_b.shape[0]):
        x, y = points_b[i, 0], points_b[i, 1]
        points_a[i, 0] = T_a_b[0] + cos * x - sin * y
        points_a[i, 1] = T_a_b[1] + sin * x + cos * y
        x, y = normals_b[i, 0], normals_b[i, 1]
        normals_a[i, 0] = cos * x - sin * y
        normals_a[i, 1] = sin * x + cos * y
