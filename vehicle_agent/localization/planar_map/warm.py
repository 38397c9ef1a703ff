"""Compiles the kernels of localization in an occupancy map."""

import math

import numpy as np

from contract.geometry import Pose2
from contract.occupancy.occupancy_map import FREE, OCCUPIED, Cells
from vehicle_agent.localization.planar_map.field_window import OccupancyTiles
from vehicle_agent.localization.planar_map.matcher import PlanarMatcher
from vehicle_agent.signals import LocalizationJob
from vehicle_agent.signals.point_cloud import point_cloud

_TILE_M, _CELL_M = 32.0, 0.25


def warm_planar_map() -> None:
    """Calls every kernel once: scans of a room are found, and searched."""
    side = round(_TILE_M / _CELL_M)
    room: Cells = np.full((side, side), FREE, dtype=np.uint8)
    room[[0, -1], :] = room[:, [0, -1]] = OCCUPIED
    tiles = OccupancyTiles(lambda ix, iy: room if (ix, iy) == (0, 0) else None, _TILE_M, _CELL_M)
    # As many as the scanner has: ends without neighbours are left out.
    angles = np.linspace(-math.pi, math.pi, 720, endpoint=False)
    reach = 0.5 * _TILE_M / np.maximum(np.abs(np.cos(angles)), np.abs(np.sin(angles)))
    points = np.column_stack((reach * np.cos(angles), reach * np.sin(angles), np.zeros(len(angles))))
    for std_m in (0.1, 2.0):
        matcher = PlanarMatcher(tiles, Pose2(0.0, 0.0, 0.0), math.radians(0.5), 1)
        for number in range(3):
            pose = Pose2(0.5 * _TILE_M + 0.3 * number, 0.5 * _TILE_M, 0.0)
            cloud = point_cloud(number, points - np.array([0.3 * number, 0.0, 0.0]))
            covariance = np.diag([std_m**2, std_m**2, 0.01])
            matcher.step(cloud, LocalizationJob(number, pose, pose, covariance, 0.0, 0.0))
