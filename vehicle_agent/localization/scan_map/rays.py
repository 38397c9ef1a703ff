"""Beams that would have gone through the map's walls: at a wrong pose many, in a changed world few.

A new thing hides the map, so its beams end before a wall. From a wrong pose the map's walls stand in the way
of beams. Thrun, Burgard and Fox, "Probabilistic Robotics", section 6.3, sort beams alike.
"""

import math

import numpy as np
from numba import njit

from contract.geometry import Array, IntArray
from contract.runlog.matched_scans import AGREES, NEW, THROUGH
from vehicle_agent.localization.odometry.voxel_map import Array32, packed, slot_of
from vehicle_agent.localization.scan_map.surfel_index import nearest_element

_EMPTY = -1
# More level elements are road and roofs; a beam that grazes a surface says nothing of it.
_LEVEL = 0.7
_GRAZING = 0.2
# The vehicle itself; and from a wall to a beam's end behind it.
_NEAREST_M = 2.0
_APART_M = 0.7


@njit(cache=True)
def beams_through(
    points: Array, pose: Array, voxel_m: float, keys: IntArray, elements: Array32, reach_m: float,
    inlier_m: float,
) -> int:  # fmt: skip
    """How many beams end behind a wall of the map, and not on something of it.

    points (n, 3), sensor frame, of things above the road; pose (4, 4) T_map_sensor
    """
    count = 0
    origin, ray = np.empty(3), np.empty(3)
    for axis in range(3):
        origin[axis] = pose[axis, 3]
    for i in range(points.shape[0]):
        for axis in range(3):
            ray[axis] = (
                pose[axis, 0] * points[i, 0] + pose[axis, 1] * points[i, 1] + pose[axis, 2] * points[i, 2]
            )
        x, y, z = origin[0] + ray[0], origin[1] + ray[1], origin[2] + ray[2]
        at = nearest_element(x, y, z, voxel_m, keys, elements, reach_m * reach_m)
        if at >= 0 and _is_on(x, y, z, elements[at], inlier_m):
            continue
        length_m = math.sqrt(ray[0] * ray[0] + ray[1] * ray[1] + ray[2] * ray[2])
        for axis in range(3):
            ray[axis] /= length_m
        count += _has_wall(origin, ray, length_m - _APART_M, voxel_m, keys, elements)
    return count


@njit(cache=True)
def point_kinds(
    points: Array, pose: Array, voxel_m: float, keys: IntArray, elements: Array32, reach_m: float,
    inlier_m: float,
) -> IntArray:  # fmt: skip
    """(n,) of each point (n, 3), sensor frame: on the map, on something new, or behind a wall of the map.

    pose (4, 4) T_map_sensor. The numbers are those of `contract.runlog.matched_scans`.
    """
    kinds = np.empty(points.shape[0], np.int64)
    origin, ray = np.empty(3), np.empty(3)
    for axis in range(3):
        origin[axis] = pose[axis, 3]
    for i in range(points.shape[0]):
        for axis in range(3):
            ray[axis] = (
                pose[axis, 0] * points[i, 0] + pose[axis, 1] * points[i, 1] + pose[axis, 2] * points[i, 2]
            )
        x, y, z = origin[0] + ray[0], origin[1] + ray[1], origin[2] + ray[2]
        at = nearest_element(x, y, z, voxel_m, keys, elements, reach_m * reach_m)
        if at >= 0 and _is_on(x, y, z, elements[at], inlier_m):
            kinds[i] = AGREES
            continue
        length_m = math.sqrt(ray[0] * ray[0] + ray[1] * ray[1] + ray[2] * ray[2])
        for axis in range(3):
            ray[axis] /= length_m
        is_through = _has_wall(origin, ray, length_m - _APART_M, voxel_m, keys, elements)
        kinds[i] = THROUGH if is_through else NEW
    return kinds


@njit(cache=True)
def _is_on(x: float, y: float, z: float, element: Array32, inlier_m: float) -> bool:
    ex, ey, ez = x - element[0], y - element[1], z - element[2]
    if element[3] != 0.0 or element[4] != 0.0 or element[5] != 0.0:
        return bool(abs(element[3] * ex + element[4] * ey + element[5] * ez) < inlier_m)
    return bool(ex * ex + ey * ey + ez * ez < (inlier_m + 1.5 * max(0.05, element[6])) ** 2)


@njit(cache=True)
def _has_wall(
    origin: Array, ray: Array, until_m: float, voxel_m: float, keys: IntArray, elements: Array32
) -> bool:
    """Whether a ray (3,) of length 1 crosses a wall before until_m."""
    step_m, at_m = 0.8 * voxel_m, _NEAREST_M
    while at_m < until_m:
        x, y, z = origin[0] + at_m * ray[0], origin[1] + at_m * ray[1], origin[2] + at_m * ray[2]
        at_m += step_m
        key = packed(math.floor(x / voxel_m), math.floor(y / voxel_m), math.floor(z / voxel_m))
        at = slot_of(keys, key)
        if keys[at] == _EMPTY or abs(elements[at, 5]) > _LEVEL:
            continue
        across = elements[at, 3] * ray[0] + elements[at, 4] * ray[1] + elements[at, 5] * ray[2]
        if abs(across) < _GRAZING:
            continue
        hit_m = 0.0
        for axis in range(3):
            hit_m += elements[at, 3 + axis] * (elements[at, axis] - origin[axis]) / across
        off2 = 0.0
        for axis in range(3):
            off2 += (origin[axis] + hit_m * ray[axis] - elements[at, axis]) ** 2
        if hit_m < until_m and off2 < 0.5 * voxel_m * voxel_m:
            return True
    return False
