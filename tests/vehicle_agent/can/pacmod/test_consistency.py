"""Reports that contradict each other: speed and wheels, gear and command."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.vehicle_agent.can.pacmod.test_subsystem_faults import driving
from vehicle_agent.can.pacmod.consistency import DISAGREEING_REPORTS, Consistency, check_consistency
from vehicle_agent.can.pacmod.reports import Reports

RADIUS_M = 0.28


def judged(speed_mps: float, wheels_mps: tuple[float, float, float, float], reports: int) -> set[str]:
    state = Consistency()
    for k in range(reports):
        front_left, front_right, rear_left, rear_right = (mps / RADIUS_M for mps in wheels_mps)
        now = Reports(
            speed_mps=speed_mps,
            speed_ns=k + 1,
            wheel_ns=k + 1,
            front_left_radps=front_left,
            front_right_radps=front_right,
            rear_left_radps=rear_left,
            rear_right_radps=rear_right,
        )
        state = check_consistency(state, now, "drive", "drive", RADIUS_M, k)
    return {code for code, _ in state.faults(reports)}


@given(st.floats(-2.0, 6.0), st.floats(-0.45, 0.45))
def test_a_vehicle_on_any_bend_is_consistent(speed_mps: float, curvature: float) -> None:
    """Least radius 2.2 m at a track of 1.2 m: tighter than any profile turns."""
    left, right = speed_mps * (1.0 - 0.6 * curvature), speed_mps * (1.0 + 0.6 * curvature)
    front = (left * (1.0 + 0.5 * curvature * curvature), right * (1.0 + 0.5 * curvature * curvature))
    assert judged(speed_mps, (*front, left, right), 40) == set()


@pytest.mark.parametrize(
    ("speed_mps", "wheels_mps", "code"),
    [
        (0.0, (2.5, 2.5, 2.5, 2.5), "bywire_speed_mismatch"),
        (2.5, (0.0, 0.0, 0.0, 0.0), "bywire_speed_mismatch"),
        (2.5, (-2.5, -2.5, -2.5, -2.5), "bywire_speed_mismatch"),
        (2.5, (0.0, 2.5, 2.5, 2.5), "bywire_wheel_mismatch"),
        (2.5, (2.5, 2.5, 2.5, 6.0), "bywire_wheel_mismatch"),
    ],
)
def test_what_disagrees_for_half_a_second_is_named_and_a_wheel_that_locks_for_a_moment_is_not(
    speed_mps: float, wheels_mps: tuple[float, float, float, float], code: str
) -> None:
    assert judged(speed_mps, wheels_mps, DISAGREEING_REPORTS) == {code}
    assert judged(speed_mps, wheels_mps, DISAGREEING_REPORTS - 1) == set()


def test_a_speed_that_is_stuck_at_zero_stops_the_vehicle_that_the_wheels_say_rolls() -> None:
    vehicle = driving()
    vehicle.module.inject("speed_report", "speed")
    vehicle.drive(1.2)
    assert ("bywire_speed_mismatch", False) in vehicle.raised()
    vehicle.drive(3.0)
    assert vehicle.speed_mps < 0.05
    vehicle.module.clear_injected("speed_report", "speed")
    vehicle.drive(2.0)
    vehicle.resume()
    vehicle.drive(2.0)
    assert vehicle.status.mode == "autonomous"


def test_one_broken_wheel_sensor_is_a_warning() -> None:
    vehicle = driving()
    vehicle.module.inject("wheel_report", "front_left")
    vehicle.drive(2.0)
    assert ("bywire_wheel_mismatch", False) in vehicle.raised()
    assert vehicle.status.mode == "autonomous"


def test_a_gear_that_nobody_asked_for_stops_the_vehicle_after_a_shift_s_time() -> None:
    vehicle = driving()
    vehicle.module.inject("shift_report", "output")
    vehicle.drive(1.5)
    assert "bywire_gear_mismatch" not in vehicle.codes
    vehicle.drive(3.0)
    assert ("bywire_gear_mismatch", False) in vehicle.raised()
    assert vehicle.speed_mps < 0.05
