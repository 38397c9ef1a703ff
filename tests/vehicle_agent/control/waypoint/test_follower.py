"""The waypoint follower and the bicycle steering."""

import math

import numpy as np
import pytest

from contract.geometry import Pose2
from vehicle_agent.control.waypoint.follower import (
    FollowerState,
    WaypointFollower,
    distance_beside,
    predicted_pose,
    target_waypoint,
)
from vehicle_agent.control.waypoint.steering import BicycleSteering

LINE = np.column_stack((np.arange(1.0, 20.0), np.zeros(19)))


def test_the_target_is_the_first_waypoint_farther_than_two_metres() -> None:
    assert target_waypoint(LINE, 0.0, 0.0, 2.0) == 2
    assert target_waypoint(LINE, 0.95, 0.0, 2.0) == 2


def test_the_last_waypoint_stays_the_target_when_all_are_near() -> None:
    assert target_waypoint(LINE[:2], 1.0, 0.0, 2.0) == 1


@pytest.mark.parametrize("aside_m", [-2.2, -1.0, 1.0, 2.2])
def test_a_vehicle_beside_its_way_aims_at_a_slant(aside_m: float) -> None:
    beside = Pose2(0.5, aside_m, 0.0)
    assert distance_beside(LINE, beside.x_m, beside.y_m) == pytest.approx(abs(aside_m))
    _, error_rad, _ = WaypointFollower().step(FollowerState(), beside, 1.0, LINE)
    assert math.copysign(1.0, error_rad) == -math.copysign(1.0, aside_m)
    assert abs(error_rad) < math.radians(25.0)


def test_on_its_way_a_vehicle_aims_two_metres_ahead_as_in_the_paper() -> None:
    as_in_the_paper = WaypointFollower(aside_share=0.0)
    near = Pose2(0.5, 0.6, 0.1)
    assert WaypointFollower().step(FollowerState(), near, 3.0, LINE) == as_in_the_paper.step(
        FollowerState(), near, 3.0, LINE
    )


def test_a_single_waypoint_has_no_side() -> None:
    assert distance_beside(LINE[:1], 3.0, 4.0) == 0.0
    assert distance_beside(np.vstack((LINE[:1], LINE[:1])), 3.0, 4.0) == 0.0


def test_the_turn_rate_is_the_gain_times_the_heading_error() -> None:
    follower = WaypointFollower(heading_gain_1ps=2.0, gain_speed_mps=0.0)
    turn, error, _ = follower.step(FollowerState(), Pose2(0.0, 0.0, 0.1), 3.0, LINE)
    assert error == pytest.approx(-0.1)
    assert turn == pytest.approx(-0.2)


def test_on_a_circle_the_gain_holds_the_circle_at_any_speed() -> None:
    radius = 10.0
    angles = np.arange(1.0, 12.0) / radius
    circle = np.column_stack((radius * np.sin(angles), radius * (1.0 - np.cos(angles))))
    follower = WaypointFollower(heading_gain_1ps=2.0 * 3.0 / 3.0, switch_m=2.5)
    for speed in (0.5, 1.5, 3.0):
        turn, _, _ = follower.step(FollowerState(), Pose2(0.0, 0.0, 0.0), speed, circle)
        assert turn == pytest.approx(speed / radius, rel=0.02)


def test_the_integral_works_against_a_constant_error_and_is_bounded() -> None:
    follower = WaypointFollower(heading_integral_1ps2=0.5)
    state = FollowerState()
    for _ in range(10_000):
        _, _, state = follower.step(state, Pose2(0.0, 0.0, -0.2), 2.0, LINE)
    assert state.integral_rads == follower.integral_rads_max


def test_without_waypoints_there_is_no_turn() -> None:
    assert WaypointFollower().step(FollowerState(0.1), Pose2(0, 0, 0), 1.0, np.empty((0, 2))) == (
        0.0,
        0.0,
        FollowerState(),
    )


def test_the_led_pose_is_where_pending_commands_bring_the_vehicle() -> None:
    steer = math.atan(2.6 / 10.0)
    pose = predicted_pose(Pose2(0.0, 0.0, 0.0), 2.0, np.full(50, steer), 2.6, 0.02)
    assert pose.yaw_rad == pytest.approx(0.2)
    assert pose.x_m == pytest.approx(10.0 * math.sin(0.2), abs=1e-3)
    assert pose.y_m == pytest.approx(10.0 * (1.0 - math.cos(0.2)), abs=1e-3)


def test_steering_is_the_bicycle_models_angle_within_its_limits() -> None:
    steering = BicycleSteering(steer_rate_radps_max=100.0)
    assert steering.steer_rad(0.3, 3.0, 0.0) == pytest.approx(math.atan(2.6 * 0.1))
    assert steering.steer_rad(9.0, 1.0, 0.0) == steering.steer_rad_max
    assert BicycleSteering().steer_rad(9.0, 1.0, 0.0) == pytest.approx(0.6 * 0.02)


def test_at_rest_a_small_turn_rate_does_not_ask_for_full_lock() -> None:
    steering = BicycleSteering(steer_rate_radps_max=100.0)
    assert abs(steering.steer_rad(0.02, 0.0, 0.0)) < 0.15
