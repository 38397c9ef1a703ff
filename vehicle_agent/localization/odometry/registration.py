"""Points of a scan onto the map: the pose at which they lie on its surfaces and points."""

import math
from dataclasses import dataclass

import numpy as np
from numba import njit

from contract.geometry import Array, IntArray
from vehicle_agent.localization.odometry.motion import exponential
from vehicle_agent.localization.odometry.voxel_map import Array32, Counts, VoxelMap, packed, slot_of

_EMPTY = -1
# Fewer partners fix no motion.
_PARTNERS_MIN = 10
# How much a deviation along a surface counts beside one across it, and one from a point that is on no
# surface.
_ALONG, _POINT = 0.002, 0.02


def align(
    points: Array,
    voxels: VoxelMap,
    guess: Array,
    reach_m: float,
    kernel_m: float,
    steps_max: int,
    step_min: float,
) -> tuple[Array, int, int]:
    """(the pose (4, 4) of the sensor in the map, steps, points that have a partner) by Gauss and Newton.

    points (n, 3), sensor frame; guess (4, 4); reach_m: to a point's partner; kernel_m: of the Geman-McClure
    kernel, at which a deviation counts a quarter. Ends when a step is below step_min (m, rad).
    """
    pose: Array = guess.copy()
    found = 0
    for number in range(1, steps_max + 1):
        information, gradient, found = _equations(
            points, pose, voxels.voxel_m, voxels.keys, voxels.counts, voxels.points, voxels.surfaces,
            reach_m, kernel_m,
        )  # fmt: skip
        if found < _PARTNERS_MIN:
            return pose, number, found
        # Directions that nothing fixes stay as predicted.
        information[np.arange(6), np.arange(6)] += 1e-6 * np.trace(information)
        step = np.linalg.solve(information, -gradient).astype(np.float64)
        pose = turned_about_itself(pose, step)
        if np.abs(step).max() < step_min:
            return pose, number, found
    return pose, steps_max, found


def turned_about_itself(pose: Array, twist: Array) -> Array:
    """The pose (4, 4) after a small twist (6,) along the map's axes about the pose's own place."""
    motion = exponential(twist)
    moved: Array = pose.copy()
    moved[:3, :3] = motion[:3, :3] @ pose[:3, :3]
    moved[:3, 3] += motion[:3, 3]
    return moved


@njit(cache=True)
def _equations(
    points: Array, pose: Array, voxel_m: float, keys: IntArray, counts: Counts, stored: Array32,
    surfaces: Array32, reach_m: float, kernel_m: float,
) -> tuple[Array, Array, int]:  # fmt: skip
    """(information (6, 6), gradient (6,), partners) of a small twist along the map's axes about the sensor.

    About the map's origin, turns would move a sensor that is far from it by more than all else counts.
    A partner is the nearest stored point of the 27 voxels around. On a surface the deviation across it is
    that from the surface, whose noise is averaged, and the one along it counts little.
    """
    information, gradient = np.zeros((6, 6)), np.zeros(6)
    reach2, kernel2 = reach_m * reach_m, kernel_m * kernel_m
    partners = 0
    jacobian = np.zeros((3, 6))
    for i in range(points.shape[0]):
        px, py, pz = points[i, 0], points[i, 1], points[i, 2]
        x = pose[0, 0] * px + pose[0, 1] * py + pose[0, 2] * pz + pose[0, 3]
        y = pose[1, 0] * px + pose[1, 1] * py + pose[1, 2] * pz + pose[1, 3]
        z = pose[2, 0] * px + pose[2, 1] * py + pose[2, 2] * pz + pose[2, 3]
        at, k = nearest(x, y, z, voxel_m, keys, counts, stored, reach2)
        if at < 0:
            continue
        partners += 1
        ex, ey, ez = x - stored[at, k, 0], y - stored[at, k, 1], z - stored[at, k, 2]
        nx, ny, nz = surfaces[at, 3], surfaces[at, 4], surfaces[at, 5]
        along, across = _POINT, 0.0
        if surfaces[at, 6] > 0.0:
            along, across = _ALONG, 1.0 - _ALONG
            to_point = nx * ex + ny * ey + nz * ez
            to_surface = nx * (x - surfaces[at, 0]) + ny * (y - surfaces[at, 1]) + nz * (z - surfaces[at, 2])
            shift = to_surface - to_point
            ex, ey, ez = ex + shift * nx, ey + shift * ny, ez + shift * nz
        # The weight of the deviation that counts: across a surface, or whole.
        off = nx * ex + ny * ey + nz * ez
        squared = along * (ex * ex + ey * ey + ez * ez) + across * off * off
        weight = kernel2 / (kernel2 + squared)
        weight *= weight
        _add_point(
            x - pose[0, 3], y - pose[1, 3], z - pose[2, 3], ex, ey, ez, nx, ny, nz,
            weight * along, weight * across, jacobian, information, gradient,
        )  # fmt: skip
    for a in range(6):
        for b in range(a):
            information[a, b] = information[b, a]
    return information, gradient, partners


@njit(cache=True)
def _add_point(
    x: float, y: float, z: float, ex: float, ey: float, ez: float, nx: float, ny: float, nz: float,
    along: float, across: float, row: Array, information: Array, gradient: Array,
) -> None:  # fmt: skip
    """Adds along * e'e + across * (n'e)^2; a twist (v, w) moves p, from the sensor, by v + w x p."""
    if across > 0.0:
        off = nx * ex + ny * ey + nz * ez
        row[0, 0], row[0, 1], row[0, 2] = nx, ny, nz
        row[0, 3], row[0, 4], row[0, 5] = y * nz - z * ny, z * nx - x * nz, x * ny - y * nx
        for a in range(6):
            scaled = across * row[0, a]
            gradient[a] += scaled * off
            for b in range(a, 6):
                information[a, b] += scaled * row[0, b]
    # e'e: the identity over v, -[p]x between v and w, and [p]x'[p]x over w.
    for a in range(3):
        information[a, a] += along
    information[0, 4] += along * z
    information[0, 5] -= along * y
    information[1, 3] -= along * z
    information[1, 5] += along * x
    information[2, 3] += along * y
    information[2, 4] -= along * x
    information[3, 3] += along * (y * y + z * z)
    information[4, 4] += along * (x * x + z * z)
    information[5, 5] += along * (x * x + y * y)
    information[3, 4] -= along * x * y
    information[3, 5] -= along * x * z
    information[4, 5] -= along * y * z
    gradient[0] += along * ex
    gradient[1] += along * ey
    gradient[2] += along * ez
    gradient[3] += along * (y * ez - z * ey)
    gradient[4] += along * (z * ex - x * ez)
    gradient[5] += along * (x * ey - y * ex)


@njit(cache=True)
def nearest(
    x: float,
    y: float,
    z: float,
    voxel_m: float,
    keys: IntArray,
    counts: Counts,
    stored: Array32,
    reach2: float,
) -> tuple[int, int]:
    """(slot, place in it) of the nearest stored point in the 27 voxels around; slot -1: none."""
    vx, vy, vz = math.floor(x / voxel_m), math.floor(y / voxel_m), math.floor(z / voxel_m)
    fx, fy, fz = x - vx * voxel_m, y - vy * voxel_m, z - vz * voxel_m
    best_slot, best_place, best2 = -1, -1, reach2
    for order in range(27):
        # The voxel itself first: what it has rules most others out.
        n = (order + 13) % 27
        dx, dy, dz = n // 9 - 1, (n // 3) % 3 - 1, n % 3 - 1
        gap2 = 0.0
        if dx != 0:
            gap = fx if dx < 0 else voxel_m - fx
            gap2 += gap * gap
        if dy != 0:
            gap = fy if dy < 0 else voxel_m - fy
            gap2 += gap * gap
        if dz != 0:
            gap = fz if dz < 0 else voxel_m - fz
            gap2 += gap * gap
        if gap2 >= best2:
            continue
        slot = slot_of(keys, packed(vx + dx, vy + dy, vz + dz))
        if keys[slot] == _EMPTY:
            continue
        for k in range(counts[slot]):
            ox, oy, oz = stored[slot, k, 0] - x, stored[slot, k, 1] - y, stored[slot, k, 2] - z
            apart2 = ox * ox + oy * oy + oz * oz
            if apart2 < best2:
                best_slot, best_place, best2 = slot, k, apart2
    return best_slot, best_place


@dataclass(frozen=True, slots=True, eq=False)
class Agreement:
    """How well points lie on a map.

    seen         points with something of the map near them
    inliers      of these, points that lie on a surface of it, or at a stored point
    residual_m   root mean square distance of the inliers from their surfaces
    information  (6, 6) of a twist along the map's axes about the sensor; an inlier on a surface counts one
    """

    seen: int
    inliers: int
    residual_m: float
    information: Array


def agreement(points: Array, voxels: VoxelMap, pose: Array, reach_m: float, inlier_m: float) -> Agreement:
    """Of points (n, 3), sensor frame, at a pose (4, 4); reach_m: to a point's partner."""
    seen, inliers, squares, count, information = _agreement(
        points,
        pose,
        voxels.voxel_m,
        voxels.keys,
        voxels.counts,
        voxels.points,
        voxels.surfaces,
        reach_m,
        inlier_m,
    )
    return Agreement(seen, inliers, math.sqrt(squares / max(1, count)), information)


@njit(cache=True)
def _agreement(
    points: Array, pose: Array, voxel_m: float, keys: IntArray, counts: Counts, stored: Array32,
    surfaces: Array32, reach_m: float, inlier_m: float,
) -> tuple[int, int, float, int, Array]:  # fmt: skip
    """(seen, inliers, sum of squared distances, points on surfaces, information)."""
    information, gradient, row = np.zeros((6, 6)), np.zeros(6), np.zeros((3, 6))
    seen, inliers, on_surfaces, squares = 0, 0, 0, 0.0
    for i in range(points.shape[0]):
        px, py, pz = points[i, 0], points[i, 1], points[i, 2]
        x = pose[0, 0] * px + pose[0, 1] * py + pose[0, 2] * pz + pose[0, 3]
        y = pose[1, 0] * px + pose[1, 1] * py + pose[1, 2] * pz + pose[1, 3]
        z = pose[2, 0] * px + pose[2, 1] * py + pose[2, 2] * pz + pose[2, 3]
        at, k = nearest(x, y, z, voxel_m, keys, counts, stored, reach_m * reach_m)
        if at < 0:
            continue
        seen += 1
        if surfaces[at, 6] > 0.0:
            nx, ny, nz = surfaces[at, 3], surfaces[at, 4], surfaces[at, 5]
            off = nx * (x - surfaces[at, 0]) + ny * (y - surfaces[at, 1]) + nz * (z - surfaces[at, 2])
            if abs(off) < inlier_m:
                inliers += 1
                on_surfaces += 1
                squares += off * off
                _add_point(
                    x - pose[0, 3], y - pose[1, 3], z - pose[2, 3], 0.0, 0.0, 0.0, nx, ny, nz, 0.0, 1.0,
                    row, information, gradient,
                )  # fmt: skip
        else:
            ex, ey, ez = x - stored[at, k, 0], y - stored[at, k, 1], z - stored[at, k, 2]
            if ex * ex + ey * ey + ez * ez < 4.0 * inlier_m * inlier_m:
                inliers += 1
    for a in range(6):
        for b in range(a):
            information[a, b] = information[b, a]
    return seen, inliers, squares, on_surfaces, information
