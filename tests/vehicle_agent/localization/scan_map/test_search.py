"""The search's lattice holds the right place among its best."""

import math

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from contract.geometry import Pose2
from tests.vehicle_agent.localization.scan_map.places import MOUNT, SQUARE, VOXEL_M, a_map, a_scan
from vehicle_agent.localization.scan_map.localizer import joined
from vehicle_agent.localization.scan_map.search import likely_poses
from vehicle_agent.localization.scan_map.surfel_index import index_surfels

INDEX = index_surfels(joined(list(a_map(SQUARE).values())), VOXEL_M)
WINDOW = (10.0, 0.4, 0.05)


@settings(deadline=None, max_examples=15)
@given(st.floats(-6.0, 6.0), st.floats(-6.0, 6.0), st.floats(-0.35, 0.35), st.integers(0, 99))
def test_the_right_place_is_among_the_best(dx: float, dy: float, turn: float, seed: int) -> None:
    true = Pose2(0.0, 1.0, 0.2)
    points = a_scan(SQUARE, true, seed).points_sensor.astype(np.float64) + MOUNT[:3, 3]
    up = points[points[:, 2] > 0.5][::6]
    found = likely_poses(up, INDEX, Pose2(dx, 1.0 + dy, 0.2 + turn), 0.0, WINDOW, 3)
    assert any(
        math.hypot(pose.x_m - true.x_m, pose.y_m - true.y_m) < 0.75 and abs(pose.yaw_rad - 0.2) < 0.06
        for pose in found
    )
    for i, pose in enumerate(found):
        for other in found[:i]:
            far = math.hypot(pose.x_m - other.x_m, pose.y_m - other.y_m) > 1.0
            assert far or abs(pose.yaw_rad - other.yaw_rad) > 0.1


def test_points_above_and_beside_the_map_are_no_error() -> None:
    points = np.array([[3.0, 0.0, 60.0], [3.0, 0.0, -40.0], [90.0, 0.0, 1.0]])
    assert len(likely_poses(points, INDEX, Pose2(0.0, 0.0, 0.0), 0.0, WINDOW, 2)) == 2
