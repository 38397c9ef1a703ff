import math

import pytest

from contract.geometry import Pose2
from vehicle_agent.control.waypoint.rear_slip import RearSlip, RearSlipState
from vehicle_agent.signals import Ego

NOMINAL = RearSlip(nominal_per_mps2=0.01)


def circle(share: float, seconds: float, slip: RearSlip = NOMINAL, speed_mps: float = 3.0) -> RearSlipState:
    """The state after a circle of 18 m on which the rear axle slips by share x lateral acceleration."""
    state, turn_radps = slip.initial(), speed_mps / 18.0
    for tick in range(round(seconds * 50)):
        course_rad = turn_radps * tick * 0.02
        yaw_rad = course_rad + share * speed_mps * turn_radps
        x_m, y_m = 18.0 * math.sin(course_rad), -18.0 * math.cos(course_rad)
        pose = Pose2(x_m, y_m, math.remainder(yaw_rad, 2.0 * math.pi))
        state = slip.step(state, Ego(tick, pose, speed_mps, 0.0, turn_radps, 0.0, 0.02, tick, True))
    return state


@pytest.mark.parametrize("share", [0.0, 0.006, 0.015])
def test_the_slip_of_a_curve_is_learned(share: float) -> None:
    assert NOMINAL.per_mps2(circle(share, 120.0)) == pytest.approx(share, abs=0.002)


def test_before_a_curve_the_slip_is_that_of_the_profile() -> None:
    assert NOMINAL.per_mps2(NOMINAL.initial()) == 0.01


def test_a_straight_road_teaches_nothing() -> None:
    state = NOMINAL.initial()
    for tick in range(1000):
        pose = Pose2(0.06 * tick, 0.0, 0.01)
        state = NOMINAL.step(state, Ego(tick, pose, 3.0, 0.0, 0.0, 0.0, 0.02, tick, True))
    assert NOMINAL.per_mps2(state) == pytest.approx(0.01)


def test_the_slip_stays_within_its_bound() -> None:
    assert NOMINAL.per_mps2(circle(0.045, 120.0)) == NOMINAL.per_mps2_max
    assert NOMINAL.per_mps2(circle(-0.04, 120.0)) == 0.0


def test_a_pose_that_is_not_finite_or_not_valid_ends_the_window_and_keeps_what_was_learned() -> None:
    state = circle(0.006, 60.0)
    for x_m, valid in ((math.nan, True), (0.0, False)):
        ego = Ego(1, Pose2(x_m, 0.0, 0.0), 3.0, 0.0, 0.1, 0.0, 0.02, 1, valid)
        after = NOMINAL.step(state, ego)
        assert len(after.poses) == 0
        assert NOMINAL.per_mps2(after) == NOMINAL.per_mps2(state)


def test_slowly_the_vehicle_moves_where_it_points() -> None:
    assert NOMINAL.course_rad(NOMINAL.initial(), 1.0, 0.8, 0.3) == 1.0
