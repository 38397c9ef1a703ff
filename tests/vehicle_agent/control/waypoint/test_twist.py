"""The linear loop of the twist controller."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vehicle_agent.brake_map import BrakeMap
from vehicle_agent.control.waypoint.twist import TwistController, TwistState

TWIST = TwistController(brakes=BrakeMap(0.2473, 0.5695, 0.1))
NUMBER = st.floats(-5.0, 5.0, allow_nan=False)


@given(st.lists(st.tuples(st.floats(0.0, 3.0), NUMBER, st.floats(0.0, 4.0), NUMBER), max_size=60))
def test_never_throttle_and_brake_and_always_within_limits(
    ticks: list[tuple[float, float, float, float]],
) -> None:
    state = TwistState()
    for wanted, slope, speed, accel in ticks:
        state = TWIST.step(state, wanted, slope, speed, accel)
        assert 0.0 <= state.throttle_ratio <= TWIST.throttle_ratio_max
        assert 0.0 <= state.brake_ratio <= 1.0
        assert state.throttle_ratio == 0.0 or state.brake_ratio == 0.0
        assert -TWIST.decel_mps2_max <= state.accel_command_mps2 <= TWIST.accel_mps2_max


def test_the_acceleration_command_is_limited_in_size_and_jerk() -> None:
    state, commands = TwistState(), []
    for _ in range(100):
        state = TWIST.step(state, 3.0, 0.0, 0.0, 0.0)
        commands.append(state.accel_command_mps2)
    assert max(commands) == TWIST.accel_mps2_max
    steps = [b - a for a, b in zip([0.0, *commands], commands, strict=False)]
    assert max(steps) <= TWIST.jerk_mps3_max * TWIST.dt_s + 1e-12


def test_the_imu_is_filtered_with_two_seconds() -> None:
    state = TwistState()
    for _ in range(100):
        state = TWIST.step(state, 1.0, 0.0, 1.0, 0.5)
    assert state.accel_filtered_mps2 == pytest.approx(0.5 * (1.0 - 2.718281828 ** (-1.0)), rel=0.02)


def test_a_slower_speed_brakes_by_the_map_alone() -> None:
    state = TwistState()
    for _ in range(100):
        state = TWIST.step(state, 1.0, 0.0, 2.0, 0.0)
    assert state.throttle_ratio == 0.0
    assert state.brake_ratio == pytest.approx(TWIST.brakes.brake_ratio(1.0 - TWIST.coast_mps2))


def test_at_rest_the_brake_holds() -> None:
    state = TwistState()
    for _ in range(50):
        state = TWIST.step(state, 0.0, 0.0, 0.0, 0.0)
    assert state.brake_ratio == TWIST.hold_ratio


def test_a_full_stop_is_the_whole_pedal_at_once() -> None:
    assert TWIST.full_stop().brake_ratio == 1.0
