"""Which readings of a scan are supported by their neighbours: a surface is seen by more than one beam."""

import numpy as np
from numba import njit

from contract.geometry import Array, IntArray

_NEIGHBOURS = 2


@njit(cache=True)
def supported(
    ranges_m: Array, angles_rad: Array, range_m_max: float, tolerance_m: float, slope: float
) -> IntArray:
    """(k,) indices of the readings that are a return and agree with one of the next two on either side.

    ranges_m, angles_rad  (m,) the scan; what is no return is not finite or not positive
    slope                 a surface may recede by this much of the way between two beams' ends
    """
    count = ranges_m.shape[0]
    out = np.empty(count, dtype=np.int64)
    found = 0
    for i in range(count):
        if not 0.0 < ranges_m[i] <= range_m_max:
            continue
        for j in range(max(0, i - _NEIGHBOURS), min(count, i + _NEIGHBOURS + 1)):
            if j == i or not 0.0 < ranges_m[j] <= range_m_max:
                continue
            between_m = ranges_m[i] * abs(angles_rad[j] - angles_rad[i])
            if abs(ranges_m[j] - ranges_m[i]) <= tolerance_m + slope * between_m:
                out[found] = i
                found += 1
                break
    return out[:found].copy()
