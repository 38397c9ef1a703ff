import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vehicle_agent.can.steering_column import front_from_wheel, wheel_from_front
from vehicle_agent.config import SteeringColumn

ANGLES = st.floats(-0.5, 0.5)


@given(ANGLES)
def test_wheel_and_front_angles_are_each_other_s_inverse(steer_rad: float) -> None:
    column = SteeringColumn()
    assert front_from_wheel(column, wheel_from_front(column, steer_rad)) == pytest.approx(steer_rad, abs=1e-9)


@given(ANGLES, ANGLES)
def test_more_wheel_is_more_front_angle(a_rad: float, b_rad: float) -> None:
    column = SteeringColumn()
    if a_rad + 1e-6 < b_rad:
        assert wheel_from_front(column, a_rad) < wheel_from_front(column, b_rad)


def test_the_gem_column_turns_its_wheel_206_9_degrees_for_10_degrees() -> None:
    wheel_deg = math.degrees(wheel_from_front(SteeringColumn(), math.radians(10.0)))
    assert wheel_deg == pytest.approx(21.775 * 10 - 0.1084 * 100)


def test_a_column_without_the_quadratic_part_is_a_plain_ratio() -> None:
    assert front_from_wheel(SteeringColumn(linear=20.0, quadratic=0.0), 2.0) == pytest.approx(0.1)


def test_a_wheel_turned_past_the_peak_gives_the_peak_angle() -> None:
    column = SteeringColumn()
    assert front_from_wheel(column, 100.0) > front_from_wheel(column, 18.0)
    assert math.isfinite(front_from_wheel(column, 1000.0))
