"""Returns that stand above the ground around them, with their heights: what the detector looks at."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array32 = NDArray[np.float32]

_UNSET = np.float32(3.4e38)
_BLOCK_M = 2.0
# The ground cannot be higher than this at the vehicle, nor rise faster away from it.
_STEP_M, _GRADE_RATIO = 0.4, 0.06
_SPREAD = 2


def standing_points(
    points_base: Array32,
    own_m: tuple[float, float, float],
    reach_m: float = 48.0,
    rise_m: float = 0.15,
    top_m: float = 2.7,
) -> tuple[NDArray[np.int64], Array32]:
    """(rows (k,), heights_m (k,)) of the returns between rise_m and top_m above the ground near them.

    points_base  (n, 3) float32, z from the ground under the rear axle; farther than reach_m is left out
    own_m        rear and front (x) and half the width of the own body, whose returns are left out
    Raises ValueError for another shape.

    The ground is the lowest return within 4 m to 6 m. Where there is none it is at z = 0. What is not finite
    is left out. Branches above top_m are no obstacle to a shuttle.
    """
    if points_base.ndim != 2 or points_base.shape[1] != 3:
        raise ValueError(f"points are an (n, 3) array, not {points_base.shape}")
    points = np.ascontiguousarray(points_base, dtype=np.float32)
    own = (np.float32(own_m[0]), np.float32(own_m[1]), np.float32(own_m[2]))
    return _standing(points, own, np.float32(reach_m), np.float32(rise_m), np.float32(top_m))


@njit(cache=True)
def _standing(
    points: Array32,
    own_m: tuple[np.float32, np.float32, np.float32],
    reach_m: np.float32,
    rise_m: np.float32,
    top_m: np.float32,
) -> tuple[NDArray[np.int64], Array32]:
    blocks = int(np.ceil(2.0 * reach_m / _BLOCK_M))
    lowest = np.full((blocks, blocks), _UNSET, np.float32)
    n = points.shape[0]
    for k in range(n):
        x, y, z = points[k, 0], points[k, 1], points[k, 2]
        # A comparison with what is not a number is false.
        if not (abs(x) < reach_m and abs(y) < reach_m and abs(z) < 20.0):
            continue
        if z > _STEP_M + _GRADE_RATIO * max(abs(x), abs(y)):
            continue
        i, j = int((x + reach_m) / _BLOCK_M), int((y + reach_m) / _BLOCK_M)
        lowest[i, j] = min(lowest[i, j], z)
    ground = np.zeros((blocks, blocks), np.float32)
    for i in range(blocks):
        for j in range(blocks):
            for spread in range(1, _SPREAD + 1):
                least = _UNSET
                for a in range(max(0, i - spread), min(blocks, i + spread + 1)):
                    for b in range(max(0, j - spread), min(blocks, j + spread + 1)):
                        least = min(least, lowest[a, b])
                if least < _UNSET:
                    ground[i, j] = least
                    break
    rows = np.empty(n, np.int64)
    heights = np.empty(n, np.float32)
    count = 0
    for k in range(n):
        x, y, z = points[k, 0], points[k, 1], points[k, 2]
        if not (abs(x) < reach_m and abs(y) < reach_m and abs(z) < 20.0):
            continue
        if own_m[0] < x < own_m[1] and abs(y) < own_m[2]:
            continue
        height = z - ground[int((x + reach_m) / _BLOCK_M), int((y + reach_m) / _BLOCK_M)]
        if rise_m <= height <= top_m:
            rows[count], heights[count] = k, height
            count += 1
    return rows[:count].copy(), heights[:count].copy()
