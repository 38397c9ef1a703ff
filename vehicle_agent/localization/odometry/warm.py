"""Compiles the kernels of the odometry."""

import numpy as np

from vehicle_agent.localization.odometry.lidar_odometry import LidarOdometry
from vehicle_agent.localization.odometry.voxel_map import remove_far
from vehicle_agent.signals.point_cloud import point_cloud


def warm_odometry() -> None:
    """Calls every kernel once: three scans of a small room, with times."""
    rng = np.random.default_rng(1)
    walls = rng.uniform(-4.0, 4.0, (4_000, 3))
    walls[np.arange(4_000), rng.integers(0, 3, 4_000)] = 4.0
    odometry = LidarOdometry()
    for number in range(3):
        offsets_ns = np.linspace(0, 90_000_000, len(walls))
        odometry.step(
            point_cloud(
                100_000_000 * number, walls + np.array([0.1 * number, 0.0, 0.0]), offsets_ns=offsets_ns
            )
        )
    remove_far(odometry.state.voxels, np.zeros(3), 3.0)
