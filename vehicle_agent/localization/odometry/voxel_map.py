"""A map of the surroundings: points by the voxel they are in, and the surface through each voxel.

A hash table of open addressing in numpy arrays, so that compiled kernels walk it. It is changed in place.
"""

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from contract.geometry import Array, IntArray

Array32 = NDArray[np.float32]
Counts = NDArray[np.int32]

# Points of one voxel. Of all points that fell into it the moments are kept, up to so many: what comes later
# adds drift and no detail.
POINTS_MAX = 20
MOMENTS_MAX = 80
_EMPTY = -1
_HALF = 1 << 20
# A surface: its points deviate so little across it, and spread so much along it, as shares of the voxel.
_ACROSS_MAX = 0.1
_ALONG_MIN = 0.1
_SURFACE_POINTS_MIN = 6
# Where a voxel shows none, a surface through it and those around it: the rings of a sensor on the ground are
# lines that move with it, and as lines they would hold it back.
_WIDE_MIN = 0.3


@dataclass(slots=True, eq=False)
class VoxelMap:
    """Places of the table, c of them.

    keys      (c,) the voxel in one number, -1 where the place is empty
    counts    (c,) and points (c, POINTS_MAX, 3): stored points
    moments   (c, 10) of all points up to MOMENTS_MAX: number, mean, products of differences from it
    surfaces  (c, 7) mean, normal, flatness: 0 no surface, 1 flat
    used      places that are taken
    """

    voxel_m: float
    keys: IntArray
    counts: Counts
    points: Array32
    moments: Array
    surfaces: Array32
    used: int = 0


def empty_map(voxel_m: float, capacity: int = 1 << 15) -> VoxelMap:
    """A map without points; capacity is a power of two, and grows."""
    return VoxelMap(
        voxel_m,
        np.full(capacity, _EMPTY, dtype=np.int64),
        np.zeros(capacity, dtype=np.int32),
        np.zeros((capacity, POINTS_MAX, 3), dtype=np.float32),
        np.zeros((capacity, 10)),
        np.zeros((capacity, 7), dtype=np.float32),
    )


def add_points(voxels: VoxelMap, points: Array) -> None:
    """Adds points (n, 3), map frame."""
    if voxels.used + len(points) > len(voxels.keys) // 2:
        _rebuild(voxels, np.zeros(3), np.inf, len(points))
    voxels.used += _add(
        points, voxels.voxel_m, voxels.keys, voxels.counts, voxels.points, voxels.moments, voxels.surfaces
    )


def remove_far(voxels: VoxelMap, centre: Array, reach_m: float) -> None:
    """Removes the voxels that are farther than this from a place (3,)."""
    _rebuild(voxels, centre, reach_m, 0)


def _rebuild(voxels: VoxelMap, centre: Array, reach_m: float, more: int) -> None:
    kept = np.flatnonzero(voxels.keys != _EMPTY)
    if np.isfinite(reach_m):
        apart = np.linalg.norm(voxels.surfaces[kept, :3].astype(np.float64) - centre, axis=1)
        kept = kept[apart <= reach_m]
    capacity = len(voxels.keys)
    while capacity < 2 * (len(kept) + more) + 16:
        capacity *= 2
    fresh = empty_map(voxels.voxel_m, capacity)
    slots = _slots(voxels.keys[kept], fresh.keys)
    fresh.counts[slots] = voxels.counts[kept]
    fresh.points[slots] = voxels.points[kept]
    fresh.moments[slots] = voxels.moments[kept]
    fresh.surfaces[slots] = voxels.surfaces[kept]
    voxels.keys, voxels.counts, voxels.points = fresh.keys, fresh.counts, fresh.points
    voxels.moments, voxels.surfaces, voxels.used = fresh.moments, fresh.surfaces, len(kept)


@njit(cache=True)
def packed(x: int, y: int, z: int) -> int:
    """One number for a voxel; a million voxels to each side."""
    key: int = ((x + _HALF) << 42) | ((y + _HALF) << 21) | (z + _HALF)
    return key


@njit(cache=True)
def slot_of(keys: IntArray, key: int) -> int:
    """Where the key is, or the empty place where it would be."""
    mask = keys.shape[0] - 1
    mixed = key * -7046029254386353131
    at: int = (mixed ^ (mixed >> 31)) & mask
    while keys[at] != key and keys[at] != _EMPTY:
        at = (at + 1) & mask
    return at


@njit(cache=True)
def _slots(wanted: IntArray, keys: IntArray) -> IntArray:
    """Takes a place for each of these keys."""
    slots = np.empty(wanted.shape[0], dtype=np.int64)
    for i in range(wanted.shape[0]):
        slots[i] = slot_of(keys, wanted[i])
        keys[slots[i]] = wanted[i]
    return slots


@njit(cache=True)
def first_of_voxels(points: Array, voxel_m: float) -> IntArray:
    """The indices of the first point (n, 3) in each voxel, in order."""
    capacity = 16
    while capacity < 2 * points.shape[0]:
        capacity *= 2
    keys = np.full(capacity, _EMPTY, dtype=np.int64)
    chosen = np.empty(points.shape[0], dtype=np.int64)
    count = 0
    for i in range(points.shape[0]):
        key = packed(
            math.floor(points[i, 0] / voxel_m),
            math.floor(points[i, 1] / voxel_m),
            math.floor(points[i, 2] / voxel_m),
        )
        at = slot_of(keys, key)
        if keys[at] == _EMPTY:
            keys[at] = key
            chosen[count] = i
            count += 1
    return chosen[:count].copy()


@njit(cache=True)
def _add(
    points: Array,
    voxel_m: float,
    keys: IntArray,
    counts: Counts,
    stored: Array32,
    moments: Array,
    surfaces: Array32,
) -> int:
    """Returns how many voxels are new."""
    apart2_min = voxel_m * voxel_m / POINTS_MAX
    fresh = 0
    touched = np.empty(points.shape[0], dtype=np.int64)
    for i in range(points.shape[0]):
        x, y, z = points[i]
        key = packed(math.floor(x / voxel_m), math.floor(y / voxel_m), math.floor(z / voxel_m))
        at = slot_of(keys, key)
        touched[i] = at
        if keys[at] == _EMPTY:
            keys[at] = key
            fresh += 1
        count = counts[at]
        if count < POINTS_MAX:
            near = False
            for k in range(count):
                dx, dy, dz = stored[at, k, 0] - x, stored[at, k, 1] - y, stored[at, k, 2] - z
                if dx * dx + dy * dy + dz * dz < apart2_min:
                    near = True
                    break
            if not near:
                stored[at, count, 0], stored[at, count, 1], stored[at, count, 2] = x, y, z
                counts[at] = count + 1
        if moments[at, 0] < MOMENTS_MAX:
            _add_moments(moments[at], x, y, z)
            _set_surface(moments[at], _ALONG_MIN * voxel_m, _ACROSS_MAX * voxel_m, surfaces[at])
    around = np.empty(10)
    for i in range(points.shape[0]):
        at = touched[i]
        if surfaces[at, 6] == 0.0:
            _gather(keys, keys[at], moments, around)
            _set_surface(around, _WIDE_MIN * voxel_m, _ACROSS_MAX * voxel_m, surfaces[at])
    return fresh


@njit(cache=True)
def _gather(keys: IntArray, key: int, moments: Array, total: Array) -> None:
    """The moments (10,) of a voxel and the 26 around it together."""
    total[:] = 0.0
    for n in range(27):
        step = ((n // 9 - 1) << 42) + (((n // 3) % 3 - 1) << 21) + (n % 3 - 1)
        at = slot_of(keys, key + step)
        count = moments[at, 0]
        if keys[at] == _EMPTY or count == 0.0:
            continue
        whole = total[0] + count
        share = total[0] * count / whole
        dx, dy, dz = moments[at, 1] - total[1], moments[at, 2] - total[2], moments[at, 3] - total[3]
        total[1] += dx * count / whole
        total[2] += dy * count / whole
        total[3] += dz * count / whole
        total[4] += moments[at, 4] + share * dx * dx
        total[5] += moments[at, 5] + share * dx * dy
        total[6] += moments[at, 6] + share * dx * dz
        total[7] += moments[at, 7] + share * dy * dy
        total[8] += moments[at, 8] + share * dy * dz
        total[9] += moments[at, 9] + share * dz * dz
        total[0] = whole


@njit(cache=True)
def _add_moments(moments: Array, x: float, y: float, z: float) -> None:
    """moments (10,): n, mean, sums of products of differences from the mean; Welford 1962.

    Far from the origin plain sums of products would lose their digits.
    """
    count = moments[0] + 1.0
    dx, dy, dz = x - moments[1], y - moments[2], z - moments[3]
    moments[0] = count
    moments[1] += dx / count
    moments[2] += dy / count
    moments[3] += dz / count
    ex, ey, ez = x - moments[1], y - moments[2], z - moments[3]
    moments[4] += dx * ex
    moments[5] += dx * ey
    moments[6] += dx * ez
    moments[7] += dy * ey
    moments[8] += dy * ez
    moments[9] += dz * ez


@njit(cache=True)
def _set_surface(moments: Array, along_m: float, across_m: float, surface: Array32) -> None:
    """The mean, and the normal where the points spread along a surface and not across it."""
    count = moments[0]
    surface[0], surface[1], surface[2] = moments[1], moments[2], moments[3]
    surface[6] = 0.0
    if count < _SURFACE_POINTS_MIN:
        return
    xx, xy, xz = moments[4] / count, moments[5] / count, moments[6] / count
    yy, yz, zz = moments[7] / count, moments[8] / count, moments[9] / count
    # Eigenvalues of a symmetric matrix in closed form (Smith 1961).
    third = (xx + yy + zz) / 3.0
    off = xy * xy + xz * xz + yz * yz
    ax, ay, az = xx - third, yy - third, zz - third
    scale = math.sqrt((ax * ax + ay * ay + az * az + 2.0 * off) / 6.0)
    if scale < 1e-12:
        return
    half_det = 0.5 * (ax * (ay * az - yz * yz) - xy * (xy * az - yz * xz) + xz * (xy * yz - ay * xz))
    angle = math.acos(min(1.0, max(-1.0, half_det / (scale * scale * scale)))) / 3.0
    most = third + 2.0 * scale * math.cos(angle)
    least = third + 2.0 * scale * math.cos(angle + 2.0943951023931953)
    middle = 3.0 * third - most - least
    if math.sqrt(max(least, 0.0)) > across_m or math.sqrt(max(middle, 0.0)) < along_m:
        return
    # The normal is at right angles to the columns of the matrix less its least eigenvalue.
    ax, ay, az = xx - least, yy - least, zz - least
    best, nx, ny, nz = 0.0, 0.0, 0.0, 0.0
    for k in range(3):
        if k == 0:
            cx, cy, cz = xy * yz - xz * ay, xz * xy - ax * yz, ax * ay - xy * xy
        elif k == 1:
            cx, cy, cz = xy * az - xz * yz, xz * xz - ax * az, ax * yz - xy * xz
        else:
            cx, cy, cz = ay * az - yz * yz, yz * xz - xy * az, xy * yz - ay * xz
        length = cx * cx + cy * cy + cz * cz
        if length > best:
            best, nx, ny, nz = length, cx, cy, cz
    if best <= 0.0:
        return
    length = math.sqrt(best)
    surface[3], surface[4], surface[5] = nx / length, ny / length, nz / length
    surface[6] = 1.0 - math.sqrt(max(least, 0.0) / middle)
