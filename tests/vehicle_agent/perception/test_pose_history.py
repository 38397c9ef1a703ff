"""Where the vehicle was when a scan was taken."""

import math

import pytest

from contract.geometry import Pose2
from vehicle_agent.signals.pose_history import pose_at

HISTORY = (
    (100, Pose2(0.0, 0.0, 3.0)),
    (200, Pose2(10.0, -4.0, -3.0)),
    (300, Pose2(10.0, 6.0, -3.0)),
)


@pytest.mark.parametrize(
    ("stamp_ns", "x_m", "y_m"),
    [
        (50, 0.0, 0.0),
        (100, 0.0, 0.0),
        (125, 2.5, -1.0),
        (200, 10.0, -4.0),
        (250, 10.0, 1.0),
        (999, 10.0, 6.0),
    ],
)
def test_between_two_poses_it_was_between_them_and_outside_the_nearest_one_counts(
    stamp_ns: int, x_m: float, y_m: float
) -> None:
    pose = pose_at(HISTORY, stamp_ns)
    assert (pose.x_m, pose.y_m) == pytest.approx((x_m, y_m))


def test_a_heading_turns_the_short_way_round() -> None:
    quarter = pose_at(HISTORY, 125).yaw_rad
    assert quarter == pytest.approx(3.0 + 0.25 * (math.tau - 6.0))
    assert abs(pose_at(HISTORY, 175).yaw_rad) > 3.0
