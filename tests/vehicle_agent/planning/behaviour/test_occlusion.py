"""Speeds past hidden places are held against what they are for: somebody runs out at the worst moment."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from contract.geometry import Array, Pose2
from vehicle_agent.planning.behaviour.occlusion import (
    H_BESIDE,
    OcclusionRules,
    PathStations,
    Sight,
    hidden_beside,
    occlusion_speeds,
)
from vehicle_agent.signals import VEHICLE, Tracks
from vehicle_agent.world.view import VisibilityParams

FRONT_M, SENSOR_M, HALF_M = 3.5, 3.2, 0.815
RUN_MPS, REACT_S, DECEL_MPS2, CREEP_MPS, CAP_MPS = 2.2, 0.6, 5.0, 1.0, 4.2
STATIONS = np.column_stack((np.arange(0.0, 60.0, 0.5), np.zeros(120)))
ZERO = np.zeros(120)
RULES = OcclusionRules(FRONT_M, FRONT_M - SENSOR_M, HALF_M, RUN_MPS, REACT_S, DECEL_MPS2, CREEP_MPS)


def parked(x_m: float, gap_m: float) -> Tracks:
    """A car to the right whose front is at x_m."""
    y_m = -(HALF_M + gap_m + 0.9)
    return Tracks(
        1,
        np.zeros(1, np.int64),
        np.full(1, VEHICLE, np.int64),
        np.array([[x_m - 2.25, y_m, 0.0]]),
        np.zeros((1, 2)),
        np.array([[4.5, 1.8]]),
    )


def limits_at(rear_x_m: float, car: Tracks) -> Array:
    pose = Pose2(rear_x_m, 0.0, 0.0)
    view = VisibilityParams(SENSOR_M).view(pose, np.empty((0, 2)), car, np.empty((0, 4)))
    first = math.ceil((rear_x_m + FRONT_M) / 0.5)
    sight = Sight(view.pose_map.x_m, view.pose_map.y_m, 0.0, view.ranges_m)
    return np.asarray(occlusion_speeds(hidden_from(sight, first, 120), 0.5, CAP_MPS, RULES))


def hidden_from(sight: Sight, first: int, last: int, solid: Array = np.empty((0, 2))) -> Array:
    path = PathStations(STATIONS, ZERO, ZERO, first, last)
    return np.asarray(hidden_beside(path, sight, solid, HALF_M, 3.0, 0.25))


def test_an_open_road_has_no_hidden_places() -> None:
    hidden = hidden_from(Sight(0.0, 0.0, 0.0, np.full(720, 40.0)), 8, 60)
    assert np.isinf(hidden[:, H_BESIDE]).all()


def test_nobody_comes_through_a_wall() -> None:
    """A wall along the road hides what is behind it, and keeps it there."""
    wall = np.column_stack((np.arange(0.0, 60.0, 0.3), np.full(200, 2.5)))
    ranges = np.array([min(40.0, 2.5 / max(math.sin(b), 1e-3)) for b in np.linspace(-math.pi, math.pi, 720)])
    hidden = hidden_from(Sight(0.0, 0.0, 0.0, ranges), 8, 60, wall)
    assert np.isinf(hidden[:, H_BESIDE]).all()


@settings(deadline=None)
@given(gap_m=st.floats(0.6, 1.6), run_out_m=st.floats(0.2, 1.0), begins_m=st.floats(4.0, 20.0))
def test_a_runner_from_behind_a_parked_car_is_stopped_for_or_passed(
    gap_m: float, run_out_m: float, begins_m: float
) -> None:
    """Drive at the limits; at any moment somebody comes into sight: the vehicle stops short or has passed."""
    front_x_m = 30.0
    car, line_x_m = parked(front_x_m, gap_m), front_x_m + run_out_m
    rear_x_m, speed_mps = front_x_m - FRONT_M - begins_m, CAP_MPS
    corner_m = HALF_M + gap_m
    for _ in range(1000):
        if rear_x_m + FRONT_M >= line_x_m:
            break
        limits = limits_at(rear_x_m, car)
        allowed = float(limits[round(rear_x_m / 0.5)])
        speed_mps = max(allowed, speed_mps - 2.0 * 0.1)
        if speed_mps <= allowed + 1e-6 and allowed > CREEP_MPS:
            togo_m = line_x_m - rear_x_m - FRONT_M
            eye_m = line_x_m - rear_x_m - SENSOR_M
            if eye_m > run_out_m + 0.1:
                beside_m = corner_m * eye_m / (eye_m - run_out_m) - HALF_M
                arrives_s = beside_m / RUN_MPS
                stops_m = speed_mps * REACT_S + speed_mps**2 / (2.0 * DECEL_MPS2)
                assert stops_m <= togo_m + 0.8 or speed_mps * arrives_s >= togo_m - 0.8
        rear_x_m += speed_mps * 0.1
    else:
        raise AssertionError("the vehicle does not come past the car in 100 s")


@pytest.mark.parametrize(("gap_m", "slower"), [(0.6, True), (2.9, False)])
def test_a_near_corner_slows_and_a_far_one_does_not(gap_m: float, slower: bool) -> None:
    limits = limits_at(18.0, parked(30.0, gap_m))
    assert bool((limits < CAP_MPS - 0.2).any()) is slower
