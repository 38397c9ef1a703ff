"""How far a command may go, at each limit and just beyond it."""

import math

import pytest

from vehicle_agent.guard.limits import Limits
from vehicle_agent.signals.poor_position import POOR_POSITION_MPS

LIMITS = Limits(steer_rad_max=0.5, steer_rate_radps_max=1.0, speed_mps_max=4.0)


@pytest.mark.parametrize("std_m", [0.31, 50.0, math.inf, math.nan])
def test_with_a_poor_position_or_a_deviation_that_is_no_number_the_vehicle_creeps(std_m: float) -> None:
    assert LIMITS.speed_mps(0.0, std_m, 0.02) == POOR_POSITION_MPS


@pytest.mark.parametrize("std_m", [0.0, 0.02, 0.3])
def test_with_a_good_position_the_vehicle_may_go_at_its_full_speed(std_m: float) -> None:
    assert LIMITS.speed_mps(0.0, std_m, 0.02) == 4.0


def test_a_limit_that_falls_is_come_down_to_gently() -> None:
    assert LIMITS.speed_mps(4.0, 1.0, 0.5) == pytest.approx(4.0 - 0.8 * 0.5)
    assert LIMITS.speed_mps(4.0, 1.0, -1.0) == 4.0, "a clock that goes back takes nothing away"
    assert LIMITS.speed_mps(0.6, 1.0, 1.0) == POOR_POSITION_MPS


def test_a_slow_vehicle_is_not_sped_up_by_a_poor_position() -> None:
    slow = Limits(0.5, 1.0, speed_mps_max=0.3)
    assert slow.speed_mps(0.0, math.inf, 0.02) == 0.3


def test_overspeed_begins_above_what_a_sound_speed_controller_overshoots() -> None:
    assert not LIMITS.is_over(1.15 * 4.0 + 0.29, 4.0)
    assert LIMITS.is_over(1.15 * 4.0 + 0.31, 4.0)
    assert not LIMITS.is_over(0.29, 0.0)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_steering_turns_to_its_stop_and_no_faster_than_its_rate(side: float) -> None:
    assert LIMITS.steer_rad(0.0, side * 0.3, 0.02) == pytest.approx(side * 0.02)
    assert LIMITS.steer_rad(side * 0.29, side * 0.3, 0.02) == pytest.approx(side * 0.3)
    assert LIMITS.steer_rad(side * 0.49, side * 2.0, 1.0) == pytest.approx(side * 0.5)
