"""Compiles the kernels of scan-to-map localization."""

import numpy as np

from contract.geometry import Pose2
from contract.point_map.tiles import Surfels
from vehicle_agent.localization.scan_map.matcher import SurfaceMatcher
from vehicle_agent.signals import LocalizationJob
from vehicle_agent.signals.point_cloud import point_cloud

_TILE_M, _VOXEL_M = 32.0, 0.5


def warm_scan_map() -> None:
    """Calls every kernel once: a scan of a room is found, and searched."""
    rng = np.random.default_rng(1)
    means = rng.uniform(0.5, 15.5, (6_000, 3))
    axis = rng.integers(0, 3, len(means))
    means[np.arange(len(means)), axis] = np.where(axis == 2, 0.0, 15.5)
    normals = np.zeros((len(means), 3))
    normals[np.arange(len(means)), axis] = 1.0
    surfels = Surfels(means, normals, np.full(len(means), 0.01), np.full(len(means), 9.0))
    matcher = SurfaceMatcher(
        lambda ix, iy: surfels if (ix, iy) == (0, 0) else None, _TILE_M, _VOXEL_M, (1.0, 1.0, 0.5)
    )
    pose, covariance = Pose2(8.0, 8.0, 0.0), np.diag([0.01, 0.01, 0.001])
    cloud = point_cloud(0, means - np.array([pose.x_m, pose.y_m, 0.0]))
    for is_lost in (False, True):
        matcher.step(cloud, LocalizationJob(0, pose, pose, covariance, 0.0, 0.0, is_lost))
