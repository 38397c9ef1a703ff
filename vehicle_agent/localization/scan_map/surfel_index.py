"""The map's surface elements around the vehicle, by voxels, so that compiled kernels find the nearest."""

import math
from dataclasses import dataclass

import numpy as np
from numba import njit

from contract.geometry import IntArray
from contract.point_map.tiles import Surfels
from vehicle_agent.localization.odometry.voxel_map import Array32, packed, slot_of

_EMPTY = -1


@dataclass(frozen=True, slots=True, eq=False)
class SurfelIndex:
    """keys (c,) voxels, -1 where a place is empty; elements (c, 7): mean, normal (0 0 0: none), deviation.

    voxel_m: edge of the map's voxels; count: elements
    """

    voxel_m: float
    keys: IntArray
    elements: Array32
    count: int

    def ground_m(self, x_m: float, y_m: float) -> float | None:
        """The lowest level element within 2 m of a place, or None where the map has none."""
        taken = self.elements[self.keys != _EMPTY]
        near = np.hypot(taken[:, 0] - x_m, taken[:, 1] - y_m) < 2.0
        level = near & (np.abs(taken[:, 5]) > 0.9)
        return float(np.percentile(taken[level, 2], 20.0)) if level.any() else None


def index_surfels(surfels: Surfels, voxel_m: float) -> SurfelIndex:
    """Of one or more tiles' elements together."""
    capacity = 1 << 10
    while capacity < 3 * len(surfels):
        capacity *= 2
    keys = np.full(capacity, _EMPTY, dtype=np.int64)
    rows = np.column_stack((surfels.means, surfels.normals, surfels.std_m)).astype(np.float32)
    elements = np.zeros((capacity, 7), dtype=np.float32)
    _fill(rows, voxel_m, keys, elements)
    return SurfelIndex(voxel_m, keys, elements, len(surfels))


@njit(cache=True)
def _fill(rows: Array32, voxel_m: float, keys: IntArray, elements: Array32) -> None:
    for i in range(rows.shape[0]):
        x, y, z = float(rows[i, 0]), float(rows[i, 1]), float(rows[i, 2])
        key = packed(math.floor(x / voxel_m), math.floor(y / voxel_m), math.floor(z / voxel_m))
        at = slot_of(keys, key)
        keys[at] = key
        elements[at] = rows[i]


@njit(cache=True)
def nearest_element(
    x: float, y: float, z: float, voxel_m: float, keys: IntArray, elements: Array32, reach2: float
) -> int:
    """The place of the element in the 27 voxels around whose mean is nearest; -1: none within the reach."""
    vx, vy, vz = math.floor(x / voxel_m), math.floor(y / voxel_m), math.floor(z / voxel_m)
    best, best2 = -1, reach2
    for n in range(27):
        at = slot_of(keys, packed(vx + n // 9 - 1, vy + (n // 3) % 3 - 1, vz + n % 3 - 1))
        if keys[at] == _EMPTY:
            continue
        dx, dy, dz = elements[at, 0] - x, elements[at, 1] - y, elements[at, 2] - z
        apart2 = dx * dx + dy * dy + dz * dz
        if apart2 < best2:
            best, best2 = at, apart2
    return best
