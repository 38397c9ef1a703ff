"""Nobody walks through a vehicle: people who are predicted to come through its flank walk along it."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from contract.geometry import Pose2
from tests.vehicle_agent.planning.motion.scenes import a_request, people
from vehicle_agent.planning.motion.agents import MovingDiscs, moving_discs
from vehicle_agent.planning.motion.checker import violations
from vehicle_agent.planning.motion.flanks import held_at_flanks
from vehicle_agent.planning.motion.plan import plan_motion
from vehicle_agent.planning.motion.request import DrivingLimits, Motion, MotionParams, MotionRequest, Vehicle

PARAMS = MotionParams()
BOX = Vehicle().box
TIMES_S = 0.1 * np.arange(81)
RADIUS_M = 0.25
ORIGIN = Pose2(0.0, 0.0, 0.0)


def planned(request: MotionRequest) -> Motion:
    motion = plan_motion(request, PARAMS)
    assert violations(motion.rows, request, Vehicle(), DrivingLimits()) == ()
    return motion


def walking(x: float, y: float, vx: float, vy: float) -> MovingDiscs:
    return moving_discs(people((x, y, vx, vy)), TIMES_S, 12.0)


@pytest.mark.parametrize("walks_mps", [0.4, 0.8, 1.4])
def test_who_walks_into_the_flank_does_not_keep_a_vehicle_standing(walks_mps: float) -> None:
    motion = planned(a_request(agents=people((BOX.front_m - 1.2, 1.6, 0.0, -walks_mps))))
    assert motion.rows[-1, 7] > 5.0


def test_who_walks_along_the_nose_and_a_little_towards_it_does_not_keep_it_either() -> None:
    motion = planned(a_request(agents=people((BOX.front_m - 0.4, 1.35, -0.3, -0.1))))
    assert motion.rows[-1, 7] > 5.0


def test_a_vehicle_creeps_away_from_who_touches_its_flank() -> None:
    motion = planned(a_request(agents=people((BOX.front_m - 0.8, BOX.half_width_m + 0.2, 0.0, 0.0))))
    # Until its nose has passed them, then faster.
    beside = motion.rows[:, 7] < 0.4
    assert motion.rows[beside, 5].max() < 0.6
    assert motion.rows[-1, 7] > 4.0


@pytest.mark.parametrize("x_m", [BOX.front_m - 0.1, BOX.front_m + 0.4])
def test_who_steps_before_the_bumper_is_waited_for(x_m: float) -> None:
    motion = planned(a_request(agents=people((x_m, 1.5, 0.0, -0.4))))
    after_2s = np.searchsorted(motion.rows[:, 0], 2.0)
    assert motion.rows[min(after_2s, len(motion.rows) - 1), 7] < 0.1


def test_who_comes_in_by_the_front_is_left_as_predicted() -> None:
    ahead = walking(8.0, 0.3, -1.4, 0.0)
    assert held_at_flanks(ahead, ORIGIN, BOX).discs.tobytes() == ahead.discs.tobytes()


def test_who_is_right_at_a_flank_makes_no_more_room_than_their_velocity_proves() -> None:
    at_2s = np.searchsorted(TIMES_S, 2.0)

    def room_made_m(gap_m: float, away_mps: float) -> float:
        start_m = BOX.half_width_m + RADIUS_M + gap_m
        moving = held_at_flanks(walking(BOX.front_m - 1.2, start_m, 0.9, away_mps), ORIGIN, BOX)
        assert moving.discs[at_2s, 0, 0] == pytest.approx(BOX.front_m - 1.2 + 1.8), "they walk on along it"
        return float(moving.discs[at_2s, 0, 1]) - start_m

    assert room_made_m(0.1, 0.3) == pytest.approx(0.0, abs=1e-9)
    assert room_made_m(0.1, 1.2) > 2.0
    assert room_made_m(0.5, 0.3) == pytest.approx(0.6), "at arm's length they are left as predicted"


def test_vehicles_are_left_as_predicted() -> None:
    crossing = walking(1.0, 4.0, 0.0, -1.0)._replace(pedestrian=np.array([False]))
    assert held_at_flanks(crossing, ORIGIN, BOX).discs.tobytes() == crossing.discs.tobytes()


@given(
    x=st.floats(-4.0, 8.0),
    y=st.floats(-4.0, 4.0),
    vx=st.floats(-1.5, 1.5),
    vy=st.floats(-1.5, 1.5),
    yaw=st.floats(-3.1, 3.1),
)
def test_who_starts_beside_the_body_stays_out_of_it_on_their_side(
    x: float, y: float, vx: float, vy: float, yaw: float
) -> None:
    """And keeps their motion along it; who never comes near is left as predicted. In any pose."""
    cos, sin = np.cos(yaw), np.sin(yaw)
    turn = np.array([[cos, -sin], [sin, cos]])
    place, velocity = turn @ (x, y) + (30.0, -20.0), turn @ (vx, vy)
    raw = walking(*place, *velocity)
    held = held_at_flanks(raw, Pose2(30.0, -20.0, yaw), BOX)
    was, now = ((moving.discs[:, 0, :2] - (30.0, -20.0)) @ turn for moving in (raw, held))
    np.testing.assert_allclose(now[:, 0], was[:, 0], atol=1e-6)
    clear = BOX.half_width_m + RADIUS_M
    if -BOX.rear_m <= x <= BOX.front_m - 0.3 and abs(y) >= clear + 0.01:
        along = (now[:, 0] >= -BOX.rear_m) & (now[:, 0] <= BOX.front_m - 0.3)
        until = len(along) if along.all() else int(np.argmin(along))
        assert (np.sign(y) * now[:until, 1] >= clear - 1e-6).all()
    if (np.abs(was[:, 1]) >= clear + 0.31).all():
        np.testing.assert_allclose(now, was, atol=1e-9)
