"""Cells that belong to a track: the track describes them better than a remembered cell."""

import math

import numpy as np
from numba import njit

from contract.geometry import Array, BoolArray


@njit(cache=True)
def outside_tracks(points: Array, poses: Array, sizes: Array, margin_m: float) -> BoolArray:
    """(n,) True for points (n, 2) outside every outline: poses (k, 3) of the centres, sizes (k, 2)."""
    outside = np.ones(points.shape[0], np.bool_)
    for k in range(poses.shape[0]):
        cos, sin = math.cos(poses[k, 2]), math.sin(poses[k, 2])
        length, width = 0.5 * sizes[k, 0] + margin_m, 0.5 * sizes[k, 1] + margin_m
        for i in range(points.shape[0]):
            dx, dy = points[i, 0] - poses[k, 0], points[i, 1] - poses[k, 1]
            if abs(cos * dx + sin * dy) <= length and abs(-sin * dx + cos * dy) <= width:
                outside[i] = False
    return outside
