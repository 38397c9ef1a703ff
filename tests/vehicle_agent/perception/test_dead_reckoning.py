import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from contract.geometry import Pose2
from vehicle_agent.perception.dead_reckoning import ReckonedWay
from vehicle_agent.signals.objects import EgoMotion

TICK_NS = 20_000_000


def way_of(speed_mps: float, yaw_rate_radps: float, ticks: int, begin_ns: int = 0) -> ReckonedWay:
    way = ReckonedWay()
    for tick in range(ticks + 1):
        way = way.with_motion(EgoMotion(begin_ns + tick * TICK_NS, speed_mps, yaw_rate_radps))
    return way


def turned(pose: Pose2) -> tuple[float, float, float]:
    return pose.x_m, pose.y_m, pose.yaw_rad


@given(speed_mps=st.floats(-3.0, 6.0), yaw_rate_radps=st.floats(-0.6, 0.6).filter(lambda w: abs(w) > 1e-3))
def test_a_steady_turn_ends_on_its_circle(speed_mps: float, yaw_rate_radps: float) -> None:
    here = way_of(speed_mps, yaw_rate_radps, 40).pose_odom(40 * TICK_NS)
    turn_rad, radius_m = 0.8 * yaw_rate_radps, speed_mps / yaw_rate_radps
    on_circle = (radius_m * math.sin(turn_rad), radius_m * (1.0 - math.cos(turn_rad)), turn_rad)
    assert turned(here) == pytest.approx(on_circle, abs=1e-3)


def test_a_scan_between_two_ticks_is_placed_between_them() -> None:
    way = way_of(2.0, 0.0, 10)
    assert way.pose_odom(5 * TICK_NS + TICK_NS // 2).x_m == pytest.approx(0.22)


def test_a_scan_just_ahead_of_the_tick_continues_its_motion() -> None:
    assert way_of(2.0, 0.0, 10).pose_odom(15 * TICK_NS).x_m == pytest.approx(0.6)


def test_a_tick_that_is_silent_for_long_does_not_let_the_vehicle_run_away() -> None:
    assert way_of(2.0, 0.0, 10).pose_odom(10 * TICK_NS + 5_000_000_000).x_m == pytest.approx(0.8)


def test_a_restarted_tick_goes_on_where_the_way_was() -> None:
    way = way_of(2.0, 0.0, 10).with_motion(EgoMotion(3_000_000_000, 0.0, 0.0))
    assert way.pose_odom(3_000_000_000).x_m == pytest.approx(0.4)


def test_a_motion_that_is_not_newer_changes_nothing() -> None:
    way = way_of(2.0, 0.0, 10)
    assert way.with_motion(EgoMotion(TICK_NS, 9.0, 1.0)) is way


def test_before_the_first_tick_the_vehicle_stands_at_the_origin() -> None:
    assert ReckonedWay().pose_odom(7) == Pose2(0.0, 0.0, 0.0)
