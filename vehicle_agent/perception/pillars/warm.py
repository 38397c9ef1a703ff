"""Compiles the kernels of the detector."""

import numpy as np

from vehicle_agent.perception.pillars.decoding import DecodingParams, decoded
from vehicle_agent.perception.pillars.grid import PillarGrid, pillars_of
from vehicle_agent.perception.pillars.shifts import shifts_of
from vehicle_agent.perception.pillars.standing_points import standing_points


def warm_detector() -> None:
    """Calls every kernel once: a few returns, and an answer with two objects that overlap."""
    points = np.array([[5.0, 0.0, 0.0], [5.0, 0.0, 0.9], [5.0, 0.1, 1.2]], dtype=np.float32)
    rows, heights = standing_points(points, (-1.0, 3.6, 0.9))
    grid = PillarGrid(nx=64, ny=64, points_max=1)
    standing = np.column_stack((points[rows, :2], heights, heights)).astype(np.float32)
    pillars_of(standing, np.array([False, True]), grid)
    heat = np.full((3, 32, 32), -9.0, dtype=np.float32)
    heat[2, 10, 10], heat[2, 10, 12] = 2.0, 1.0
    boxes = np.zeros((10, 32, 32), dtype=np.float32)
    found = decoded(heat, boxes, grid, DecodingParams())
    shifts_of(found.kinds, found.boxes, standing, np.array([False, True]))
