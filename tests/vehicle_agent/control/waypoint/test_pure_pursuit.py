"""Pure pursuit against circles, whose steering is known."""

import math

import numpy as np
import pytest

from contract.geometry import Pose2
from vehicle_agent.control.waypoint.follower import FollowerState
from vehicle_agent.control.waypoint.pure_pursuit import PurePursuit, look_ahead_point

PURSUIT = PurePursuit()


def turn_radps(pose: Pose2, points: np.ndarray, speed_mps: float = 2.0) -> float:
    turn, _, _ = PURSUIT.step(FollowerState(), pose, speed_mps, points)
    return turn


def circle(radius_m: float) -> np.ndarray:
    angles = np.linspace(0.0, 1.5, 2000)
    return np.column_stack((radius_m * np.sin(angles), radius_m * (1.0 - np.cos(angles))))


@pytest.mark.parametrize("radius_m", [3.0, 5.0, 20.0, -8.0])
def test_on_a_circle_it_turns_as_the_circle_does(radius_m: float) -> None:
    points = circle(abs(radius_m)) * np.array([1.0, math.copysign(1.0, radius_m)])
    assert turn_radps(Pose2(0.0, 0.0, 0.0), points) == pytest.approx(2.0 / radius_m, rel=1e-3)


def test_the_point_is_three_metres_away_wherever_the_waypoints_lie() -> None:
    points = np.column_stack((np.arange(0.3, 20.0), np.full(20, 0.5)))
    x, y = look_ahead_point(points, 0.0, 0.0, 3.0)
    assert math.hypot(x, y) == pytest.approx(3.0)
    assert y == 0.5


def test_it_steers_towards_the_line_from_either_side() -> None:
    line = np.column_stack((np.arange(0.0, 20.0), np.zeros(20)))
    assert turn_radps(Pose2(0.0, 0.5, 0.0), line) < 0.0 < turn_radps(Pose2(0.0, -0.5, 0.0), line)


def test_the_last_point_is_aimed_at_when_the_path_ends_before() -> None:
    assert look_ahead_point(np.array([[1.0, 0.0], [2.0, 0.0]]), 0.0, 0.0, 3.0) == (2.0, 0.0)


def test_without_a_path_it_goes_straight() -> None:
    assert turn_radps(Pose2(0.0, 0.0, 1.0), np.empty((0, 2))) == 0.0
