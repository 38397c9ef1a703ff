"""The points of lidars that turn while the vehicle drives, as if all were measured at the scan's stamp."""

import math

import numpy as np
from numba import njit


def straightened(
    points_base: np.ndarray, offsets_s: np.ndarray, speed_mps: float, yaw_rate_radps: float
) -> np.ndarray:
    """(n, 3) float32 the points in the base frame of the stamp.

    points_base    (n, 3) float32, each in the base frame of its own moment
    offsets_s      (n,) float32 of that moment from the stamp, before it negative
    speed_mps, yaw_rate_radps   of the vehicle meanwhile, as it measures them

    The vehicle drives an arc. Pitch and roll are left out. Raises ValueError if the lengths differ.
    """
    if len(points_base) != len(offsets_s):
        raise ValueError(f"{len(points_base)} points and {len(offsets_s)} times")
    points = np.ascontiguousarray(points_base, dtype=np.float32)
    return _straightened(points, offsets_s.astype(np.float32, copy=False), speed_mps, yaw_rate_radps)


@njit(cache=True)
def _straightened(
    points: np.ndarray, offsets_s: np.ndarray, speed_mps: float, yaw_rate_radps: float
) -> np.ndarray:
    moved = np.empty_like(points)
    for k in range(points.shape[0]):
        # The base that measured the point, in that of the stamp: the arc driven since.
        turned = yaw_rate_radps * offsets_s[k]
        half = 0.5 * turned
        # The chord is shorter than the arc: sin(h) / h, by its series.
        chord = speed_mps * offsets_s[k] * (1.0 - half * half / 6.0)
        cos, sin = math.cos(turned), math.sin(turned)
        x, y = points[k, 0], points[k, 1]
        moved[k, 0] = cos * x - sin * y + chord * math.cos(half)
        moved[k, 1] = sin * x + cos * y + chord * math.sin(half)
        moved[k, 2] = points[k, 2]
    return moved
