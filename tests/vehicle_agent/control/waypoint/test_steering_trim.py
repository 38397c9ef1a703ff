"""What the wheels stand beside their report is learned from the turn rate, and steered away."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from contract.geometry import Pose2
from vehicle_agent.config import Profile
from vehicle_agent.control.waypoint.steering_trim import SteeringTrim
from vehicle_agent.signals import Ego, Path, VehicleMotion
from vehicle_agent.stacks.rooms import waypoint_control

TRIM = SteeringTrim()


def moving(speed_mps: float, yaw_rate_radps: float, steer_rad: float) -> tuple[Ego, VehicleMotion]:
    ego = Ego(1, Pose2(0.0, 0.0, 0.0), speed_mps, 0.0, yaw_rate_radps, steer_rad, 0.02, 1, True)
    return ego, VehicleMotion(1, speed_mps, steer_rad, 0.0, 0.0, True, False, True, 1.0)


def turn_radps(speed_mps: float, wheels_rad: float) -> float:
    return speed_mps * math.tan(wheels_rad) / TRIM.wheelbase_m


@settings(max_examples=60, deadline=None)
@given(st.floats(-0.4, 0.4), st.floats(-0.02, 0.02), st.floats(1.0, 5.0))
def test_in_curves_as_on_straights_the_trim_is_what_the_wheels_stand_beside(
    steer_rad: float, off_rad: float, speed_mps: float
) -> None:
    ego, motion = moving(speed_mps, turn_radps(speed_mps, steer_rad + off_rad), steer_rad)
    trim_rad = 0.0
    for _ in range(1000):
        trim_rad = TRIM.step(trim_rad, ego, motion)
    assert trim_rad == pytest.approx(off_rad, abs=1e-4)


@pytest.mark.parametrize("yaw_rate_radps", [math.nan, math.inf, 5.0])
def test_what_no_bent_linkage_explains_is_not_steered_away(yaw_rate_radps: float) -> None:
    ego, motion = moving(3.0, yaw_rate_radps, 0.0)
    trim_rad = 0.0
    for _ in range(1000):
        trim_rad = TRIM.step(trim_rad, ego, motion)
    assert abs(trim_rad) <= TRIM.trim_rad_max


def test_a_vehicle_that_hardly_moves_learns_nothing() -> None:
    assert TRIM.step(0.01, *moving(0.3, 0.2, 0.0)) == 0.01


def test_the_command_goes_against_the_trim() -> None:
    hands = waypoint_control(Profile())
    points = np.column_stack((np.arange(1.0, 40.0), np.zeros(39)))
    path = Path(1, points, np.full(39, 3.0), 3.0, "cap", None, 40.0, False, 0.0)
    state = hands.initial()
    for _ in range(500):
        command, state = hands.step(state, *moved(path, 0.01))
    assert command.steer_rad == pytest.approx(-0.01, abs=5e-4)


def moved(path: Path, off_rad: float) -> tuple[Ego, Path, VehicleMotion]:
    """Straight on along the path, with the wheels commanded off_rad to the right of it to do so."""
    ego, motion = moving(3.0, 0.0, -off_rad)
    return ego, path, motion
