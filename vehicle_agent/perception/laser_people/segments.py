"""What a planar scan shows, as clusters: beams in a row that end on one thing, and legs of one person."""

import math

import msgspec
import numpy as np
from numba import njit

from contract.geometry import Array, BoolArray


class SegmentParams(msgspec.Struct, frozen=True):
    """How beams become clusters.

    range_m_max    farther returns are left out
    lambda_rad     flattest angle between a beam and a surface on which two beams in a row are still one thing
    noise_m        of a range, added to the gap that is allowed
    legs_m         clusters whose nearest ends are closer than this belong together, if both are small
    small_m        a cluster that is wider is a wall, a hedge or a vehicle, and joins nothing
    depth_m        half the depth of a person: the middle lies that much behind the surface
    apart_m        a cluster with nothing else so near its ends, and nothing before them, stands free
    """

    range_m_max: float = 40.0
    lambda_rad: float = 0.17
    noise_m: float = 0.05
    legs_m: float = 0.35
    small_m: float = 0.8
    depth_m: float = 0.12
    apart_m: float = 0.5


class Clusters(msgspec.Struct, frozen=True):
    """What one scan shows; rows belong together.

    centres_laser (k, 2)  middle of each thing, m
    widths_m (k,)         across
    beams (k,) int64      that end on it
    is_free (k,) bool     all of it is seen and nothing adjoins it: it is no end of a wall or part of a hedge
    """

    centres_laser: Array
    widths_m: Array
    beams: np.ndarray
    is_free: BoolArray

    def __len__(self) -> int:
        return len(self.widths_m)


def clusters_of(ranges_m: Array, angles_rad: Array, params: SegmentParams) -> Clusters:
    """The clusters of one scan; empty where it has no return.

    ranges_m    (n,) NaN, infinite, zero and negative ones are no return
    angles_rad  (n,) in the laser's frame, rising in even steps

    Beams are divided where the gap is wider than the adaptive threshold of Borges and Aldon (2004).
    """
    table = _clusters(
        np.asarray(ranges_m, dtype=np.float64), np.asarray(angles_rad, dtype=np.float64), params.range_m_max,
        params.lambda_rad, params.noise_m, params.legs_m, params.small_m, params.depth_m, params.apart_m,
    )  # fmt: skip
    return Clusters(table[:, :2].copy(), table[:, 2].copy(), table[:, 3].astype(np.int64), table[:, 4] > 0.0)


@njit(cache=True)
def _clusters(
    ranges_m: Array,
    angles_rad: Array,
    range_m_max: float,
    lambda_rad: float,
    noise_m: float,
    legs_m: float,
    small_m: float,
    depth_m: float,
    apart_m: float,
) -> Array:
    """(k, 5) x, y, width, beams, 1 for what stands free."""
    n = ranges_m.shape[0]
    # Rows: x and y of the first and the last end, sum of x and y, beams, x and y of the last but one, the
    # numbers of the first and the last beam.
    rows = np.empty((n, 11))
    count, before = 0, -1
    for i in range(n):
        r = ranges_m[i]
        if not 0.0 < r <= range_m_max:
            continue
        x, y = r * math.cos(angles_rad[i]), r * math.sin(angles_rad[i])
        is_same = False
        # One beam without a return, such as a dropout, does not divide a thing.
        step = angles_rad[i] - angles_rad[before] if before >= 0 else math.inf
        if i - before <= 2 and step < 0.5 * lambda_rad:
            near = min(r, ranges_m[before])
            allowed = near * math.sin(step) / math.sin(lambda_rad - step) + 3.0 * noise_m
            gap = math.hypot(x - rows[count - 1, 2], y - rows[count - 1, 3])
            is_same = gap <= min(allowed, 0.5) or (
                gap <= 3.0
                and rows[count - 1, 6] >= 2.0
                and _continues(rows[count - 1], r, angles_rad[i], noise_m)
            )
        if is_same:
            rows[count - 1, 7], rows[count - 1, 8] = rows[count - 1, 2], rows[count - 1, 3]
            rows[count - 1, 2], rows[count - 1, 3] = x, y
            rows[count - 1, 4] += x
            rows[count - 1, 5] += y
            rows[count - 1, 6] += 1.0
        else:
            rows[count, 0], rows[count, 1], rows[count, 2], rows[count, 3] = x, y, x, y
            rows[count, 4], rows[count, 5], rows[count, 6] = x, y, 1.0
            rows[count, 9] = i
            count += 1
        rows[count - 1, 10] = i
        before = i
    out = _joined(rows[:count], legs_m, small_m, depth_m)
    for k in range(out.shape[0]):
        first, last = int(out[k, 5]), int(out[k, 6])
        is_free = _ends_free(ranges_m, angles_rad, first, -1, range_m_max, noise_m, apart_m) and _ends_free(
            ranges_m, angles_rad, last, 1, range_m_max, noise_m, apart_m
        )
        out[k, 4] = 1.0 if is_free else 0.0
    return out


@njit(cache=True)
def _ends_free(
    ranges_m: Array,
    angles_rad: Array,
    end: int,
    step: int,
    range_m_max: float,
    noise_m: float,
    apart_m: float,
) -> bool:
    """Beyond beam `end`, in steps of 1 or -1, nothing is nearer to the laser or adjoins."""
    r, n = ranges_m[end], ranges_m.shape[0]
    i, is_first = end + step, True
    while 0 <= i < n:
        apart_rad = abs(angles_rad[i] - angles_rad[end])
        if r * apart_rad > apart_m:
            return True
        other = ranges_m[i]
        if 0.0 < other <= range_m_max:
            gap = math.sqrt(max(0.0, r * r + other * other - 2.0 * r * other * math.cos(apart_rad)))
            if gap < apart_m or (is_first and other < r - 3.0 * noise_m):
                return False
            is_first = False
        i += step
    # The scan ends here: more of the thing may be outside.
    return i - step != end


@njit(cache=True)
def _continues(row: Array, range_m: float, angle_rad: float, noise_m: float) -> bool:
    """The beam ends on the line of the last two, as on a wall along which it looks."""
    dx, dy = row[2] - row[7], row[3] - row[8]
    length = math.hypot(dx, dy)
    across = (dx * math.sin(angle_rad) - dy * math.cos(angle_rad)) / max(length, 1e-9)
    if abs(across) < 0.01:
        return False
    expected = (dx * row[3] - dy * row[2]) / max(length, 1e-9) / across
    fits: bool = abs(range_m - expected) <= 2.0 * noise_m + 0.15 * abs(expected - math.hypot(row[2], row[3]))
    return fits


@njit(cache=True)
def _joined(rows: Array, legs_m: float, small_m: float, depth_m: float) -> Array:
    """Small neighbours become one, such as two legs, or a leg and an arm."""
    k = rows.shape[0]
    out = np.empty((k, 7))
    count = 0
    i = 0
    while i < k:
        x0, y0, x1, y1 = rows[i, 0], rows[i, 1], rows[i, 2], rows[i, 3]
        sum_x, sum_y, beams = rows[i, 4], rows[i, 5], rows[i, 6]
        j = i + 1
        while j < k:
            gap = math.hypot(rows[j, 0] - x1, rows[j, 1] - y1)
            whole = math.hypot(rows[j, 2] - x0, rows[j, 3] - y0)
            if gap > legs_m or whole > small_m:
                break
            x1, y1 = rows[j, 2], rows[j, 3]
            sum_x, sum_y, beams = sum_x + rows[j, 4], sum_y + rows[j, 5], beams + rows[j, 6]
            j += 1
        x, y = sum_x / beams, sum_y / beams
        reach = max(1e-6, math.hypot(x, y))
        out[count, 0], out[count, 1] = x * (1.0 + depth_m / reach), y * (1.0 + depth_m / reach)
        out[count, 2], out[count, 3] = math.hypot(x1 - x0, y1 - y0), beams
        out[count, 5], out[count, 6] = rows[i, 9], rows[j - 1, 10]
        count += 1
        i = j
    return out[:count]
