"""A scan onto the map: the pose at which its points lie on the surfaces, and how sure that is.

Point to plane by Gauss and Newton with a prior, as iterated filters do (Xu and Zhang 2021, "FAST-LIO",
section III-C): a direction that no surface fixes stays at the prior, and what is stated of it is the prior's.
"""

from dataclasses import dataclass

import msgspec
import numpy as np
from numba import njit

from contract.geometry import Array, IntArray
from vehicle_agent.localization.odometry.registration import turned_about_itself
from vehicle_agent.localization.odometry.voxel_map import Array32
from vehicle_agent.localization.scan_map.surfel_index import SurfelIndex, nearest_element

# Rows of what the kernel counts.
SEEN, INLIERS, SEEN_UP, INLIERS_UP = range(4)


class MatchParams(msgspec.Struct, frozen=True):
    """How a scan is aligned.

    reach_m      from a point to the element's mean
    kernel_m     of the Geman-McClure kernel, of the steps in turn; the last one stays
    inlier_m     a point nearer than this to its surface agrees with the map
    point_ratio  weight of an element that is no surface
    noise_m      of a point: range, and what the element's surface is off
    together     so many points err together: those of one surface
    steps_max, step_min  end of the alignment, m and rad
    """

    reach_m: float = 0.8
    kernel_m: tuple[float, ...] = (0.5, 0.3, 0.15)
    inlier_m: float = 0.15
    point_ratio: float = 0.3
    noise_m: float = 0.04
    together: float = 20.0
    steps_max: int = 15
    step_min: float = 1e-3


@dataclass(frozen=True, slots=True, eq=False)
class Match:
    """pose (4, 4) T_map_sensor; information (6, 6) of a twist along the map's axes about the sensor, without
    the prior's.

    seen, inliers        points with an element near them; those that agree
    seen_up, inliers_up  the same of points above the road: a wrong place has a road as well
    points_up            points above the road, near the map or not
    """

    pose: Array
    information: Array
    seen: int
    inliers: int
    seen_up: int
    inliers_up: int
    points_up: int
    steps: int

    @property
    def agreement(self) -> float:
        """Share of the points above the road that agree with the map; 0.0 without any."""
        return self.inliers_up / self.points_up if self.points_up else 0.0


def match_scan(
    points: Array, above: Array, index: SurfelIndex, guess: Array, prior: Array, params: MatchParams
) -> Match:
    """The pose near a guess (4, 4).

    points (n, 3), sensor frame; above (n,): 1.0 for a point above the road, 0.0 on it
    prior  (6, 6) information of the guess: a twist along the map's axes about the sensor
    """
    pose = guess.copy()
    steps = 0
    for kernel_m in params.kernel_m:
        for _ in range(params.steps_max):
            steps += 1
            information, gradient, _ = _equations(
                points, above, pose, index.voxel_m, index.keys, index.elements, params.reach_m, kernel_m,
                params.inlier_m, params.point_ratio,
            )  # fmt: skip
            scale = 1.0 / (params.noise_m**2 * params.together)
            away = _twist(guess, pose)
            step = np.linalg.solve(scale * information + prior, -(scale * gradient + prior @ away))
            pose = turned_about_itself(pose, step.astype(np.float64))
            if np.abs(step).max() < params.step_min:
                break
    information, _, counts = _equations(
        points, above, pose, index.voxel_m, index.keys, index.elements, params.reach_m, params.kernel_m[-1],
        params.inlier_m, params.point_ratio,
    )  # fmt: skip
    information = information / (params.noise_m**2 * params.together)
    return Match(
        pose, information, int(counts[SEEN]), int(counts[INLIERS]), int(counts[SEEN_UP]),
        int(counts[INLIERS_UP]), int(above.sum()), steps,
    )  # fmt: skip


def in_plane(information: Array, floor: float = 1e-6) -> Array:
    """(3, 3) information of x, y and yaw, whatever height, roll and pitch are (Schur complement)."""
    kept, other = np.array([0, 1, 5]), np.array([2, 3, 4])
    block = information[np.ix_(other, other)] + floor * np.eye(3)
    across = information[np.ix_(kept, other)]
    reduced: Array = information[np.ix_(kept, kept)] - across @ np.linalg.solve(block, across.T)
    return 0.5 * (reduced + reduced.T)


def _twist(from_: Array, to: Array) -> Array:
    """(6,) small difference of two poses along the map's axes about the sensor."""
    turn = to[:3, :3] @ from_[:3, :3].T
    found: Array = np.empty(6)
    found[:3] = to[:3, 3] - from_[:3, 3]
    found[3:] = 0.5 * np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    return found


@njit(cache=True)
def _equations(
    points: Array, above: Array, pose: Array, voxel_m: float, keys: IntArray, elements: Array32,
    reach_m: float, kernel_m: float, inlier_m: float, point_ratio: float,
) -> tuple[Array, Array, Array]:  # fmt: skip
    """(information (6, 6), gradient (6,), counts (4,)), each point on a surface counting one at most."""
    information, gradient, counts = np.zeros((6, 6)), np.zeros(6), np.zeros(4)
    kernel2, row = kernel_m * kernel_m, np.zeros(6)
    for i in range(points.shape[0]):
        px, py, pz = points[i, 0], points[i, 1], points[i, 2]
        rx = pose[0, 0] * px + pose[0, 1] * py + pose[0, 2] * pz
        ry = pose[1, 0] * px + pose[1, 1] * py + pose[1, 2] * pz
        rz = pose[2, 0] * px + pose[2, 1] * py + pose[2, 2] * pz
        x, y, z = rx + pose[0, 3], ry + pose[1, 3], rz + pose[2, 3]
        at = nearest_element(x, y, z, voxel_m, keys, elements, reach_m * reach_m)
        if at < 0:
            continue
        counts[SEEN] += 1.0
        counts[SEEN_UP] += above[i]
        ex, ey, ez = x - elements[at, 0], y - elements[at, 1], z - elements[at, 2]
        nx, ny, nz = elements[at, 3], elements[at, 4], elements[at, 5]
        if nx != 0.0 or ny != 0.0 or nz != 0.0:
            off = nx * ex + ny * ey + nz * ez
            is_inlier = abs(off) < inlier_m
            weight = kernel2 / (kernel2 + off * off)
            weight *= weight
            row[0], row[1], row[2] = nx, ny, nz
            row[3], row[4], row[5] = ry * nz - rz * ny, rz * nx - rx * nz, rx * ny - ry * nx
            for a in range(6):
                gradient[a] += weight * row[a] * off
                for b in range(6):
                    information[a, b] += weight * row[a] * row[b]
        else:
            std = max(0.05, elements[at, 6])
            squared = ex * ex + ey * ey + ez * ez
            is_inlier = squared < (inlier_m + 1.5 * std) ** 2
            weight = kernel2 / (kernel2 + squared)
            weight *= weight * point_ratio * min(1.0, (0.05 / std) ** 2)
            for axis in range(3):
                row[:] = 0.0
                row[axis] = 1.0
                if axis == 0:
                    row[4], row[5], off = rz, -ry, ex
                elif axis == 1:
                    row[3], row[5], off = -rz, rx, ey
                else:
                    row[3], row[4], off = ry, -rx, ez
                for a in range(6):
                    gradient[a] += weight * row[a] * off
                    for b in range(6):
                        information[a, b] += weight * row[a] * row[b]
        if is_inlier:
            counts[INLIERS] += 1.0
            counts[INLIERS_UP] += above[i]
    return information, gradient, counts
