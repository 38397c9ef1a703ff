"""Keyframes that lie side by side on the way, put together, and one such submap registered with another."""

from collections.abc import Sequence

import msgspec
import numpy as np

from contract.geometry import Array
from vehicle_agent.localization.odometry.motion import inverted, logarithm
from vehicle_agent.localization.odometry.registration import agreement, align
from vehicle_agent.localization.odometry.voxel_map import (
    Array32,
    VoxelMap,
    add_points,
    empty_map,
    first_of_voxels,
)


class SubmapParams(msgspec.Struct, frozen=True):
    """keyframes: on either side of the middle one; voxel_m: of the surfaces; source_m: of the aligned points.

    reach_m, kernel_m     of a registration, at first and at last
    inlier_m              farther from the other's surface a point contradicts
    inlier_ratio_min      least share of inliers among points that the other submap has seen the place of
    seen_ratio_min        least share of such points
    disagreement_m, disagreement_rad  of the registrations of either with the other
    std_m, std_rad        least deviations that are stated of a loop
    """

    keyframes: int = 7
    voxel_m: float = 1.0
    source_m: float = 1.2
    reach_m: tuple[float, ...] = (3.0, 1.0)
    kernel_m: tuple[float, ...] = (0.6, 0.15)
    steps_max: int = 40
    inlier_m: float = 0.15
    inlier_ratio_min: float = 0.75
    seen_ratio_min: float = 0.5
    disagreement_m: float = 0.12
    disagreement_rad: float = 0.008
    std_m: float = 0.03
    std_rad: float = 0.002


_CHUNK = 2_000


class Submap(msgspec.Struct, frozen=True):
    """voxels: of all points; source (m, 3): thinned, both in the middle keyframe's frame."""

    voxels: VoxelMap
    source: Array


class Registration(msgspec.Struct, frozen=True):
    """pose (4, 4) T_target_source; information (6, 6) of a twist in the source's frame; shares of points."""

    pose: Array
    information: Array
    inlier_ratio: float
    seen_ratio: float


def joined(clouds: Sequence[Array32], poses: Array, middle: int, keyframes: int) -> Array:
    """(m, 3) points of keyframes about the middle one, in its frame; poses (k, 4, 4)."""
    first, last = max(0, middle - keyframes), min(len(clouds), middle + keyframes + 1)
    here = inverted(poses[middle])
    parts = []
    for number in range(first, last):
        T = here @ poses[number]
        parts.append(clouds[number].astype(np.float64) @ T[:3, :3].T + T[:3, 3])
    return np.concatenate(parts)


def submap(clouds: Sequence[Array32], poses: Array, middle: int, params: SubmapParams) -> Submap:
    points = joined(clouds, poses, middle, params.keyframes)
    voxels = empty_map(params.voxel_m, 1 << 14)
    # The table grows with the points that are added at once, and a submap has many points in few voxels.
    for first in range(0, len(points), _CHUNK):
        add_points(voxels, points[first : first + _CHUNK])
    return Submap(voxels, points[first_of_voxels(points, params.source_m)])


def registered(target: Submap, source: Submap, guess: Array, params: SubmapParams) -> Registration | None:
    """The source's pose in the target's frame, if either registered with the other says the same."""
    there = _one_way(target, source.source, guess, params)
    if there is None:
        return None
    back = _one_way(source, target.source, inverted(there.pose), params)
    if back is None:
        return None
    apart = np.abs(logarithm(there.pose @ back.pose))
    if (
        np.linalg.norm(apart[:3]) > params.disagreement_m
        or np.linalg.norm(apart[3:]) > params.disagreement_rad
    ):
        return None
    return there


def _one_way(target: Submap, points: Array, guess: Array, params: SubmapParams) -> Registration | None:
    pose = guess
    for reach_m, kernel_m in zip(params.reach_m, params.kernel_m, strict=True):
        pose, _, partners = align(points, target.voxels, pose, reach_m, kernel_m, params.steps_max, 5e-4)
        if partners < 0.3 * len(points):
            return None
    found = agreement(points, target.voxels, pose, 1.0, params.inlier_m)
    if (
        found.seen < params.seen_ratio_min * len(points)
        or found.inliers < params.inlier_ratio_min * found.seen
    ):
        return None
    # Points on one surface err together; so the deviations are never stated as small as their number says.
    covariance = found.residual_m**2 * 10.0 * np.linalg.inv(
        found.information + 1e-6 * np.trace(found.information) * np.eye(6)
    ) + np.diag([params.std_m**2] * 3 + [params.std_rad**2] * 3)
    turn = np.zeros((6, 6))
    turn[:3, :3] = turn[3:, 3:] = pose[:3, :3].T
    information = np.linalg.inv(turn @ covariance @ turn.T).astype(np.float64)
    return Registration(
        pose, 0.5 * (information + information.T), found.inliers / found.seen, found.seen / len(points)
    )
