"""People who set off right before the shuttle: where they stand, and what is counted of them."""

import numpy as np
import pytest

from benchmarks.stepping_in import SteppingInDrive, drive, summary
from campusloop.scenes.contact_metrics import MOVING_MPS, contact_metrics
from campusloop.scenes.drive import SceneRun
from campusloop.scenes.stepping_in import PEOPLE, stepping_in_scene, steps_in
from campusloop.scenes.trace import SceneTrace
from simulator.traffic.actors import Bodies
from vehicle_agent.config import Profile
from vehicle_agent.signals import PEDESTRIAN

PROFILE = Profile()
BODY = PROFILE.body
STEP_S = 0.02


def test_a_seed_draws_the_same_people_and_another_one_other_people() -> None:
    def places(seed: int) -> list[list[float]]:
        actors = stepping_in_scene(PROFILE, seed).actors
        assert actors is not None
        return actors.bodies().poses_map.tolist()

    assert places(1) == places(1) != places(2)
    assert len(places(1)) == PEOPLE


def run_past_one(speed_mps: float, accel_mps2: float, begins_m: float, across_mps: float) -> SceneRun:
    """A person 0.5 m beside the way, 10 m ahead of the bumper at first, walks across it at across_mps once
    the vehicle, which drives along x, has driven begins_m. From then on it has accel_mps2."""
    trace, way_m = SceneTrace(), 0.0
    x, y = BODY.front_overhang_m + 10.0, 0.5 * BODY.width_m + 0.25 + 0.5
    for k in range(500):
        walks = way_m >= begins_m
        y -= across_mps * STEP_S * walks
        velocity = [0.0, -across_mps if walks else 0.0]
        trace.rows.append((k * STEP_S, way_m, 0.0, 0.0, speed_mps, accel_mps2, 0.0))
        trace.agents.append(
            Bodies(
                np.array([1]),
                np.array([PEDESTRIAN]),
                np.array([[x, y, 0.0]]),
                np.array([velocity]),
                np.array([[0.5, 0.5]]),
            )
        )
        way_m += speed_mps * STEP_S
        if walks:
            speed_mps = max(0.0, speed_mps + accel_mps2 * STEP_S)
    metrics = contact_metrics(trace.array(), trace.agents, BODY)
    return SceneRun("one", None, way_m, trace, metrics, (), 0.0, ())


def test_who_sets_off_in_time_for_a_full_brake_is_an_avoidable_contact() -> None:
    """3 m at 3 m/s: braking fully takes 0.8 + 0.8 m."""
    step = steps_in(run_past_one(3.0, 0.0, 7.0, 0.8), BODY)[0]
    assert step.speed_mps == 3.0
    assert step.impact_mps == pytest.approx(3.0)
    assert step.least_mps is None


def test_who_sets_off_at_the_bumper_cannot_be_avoided() -> None:
    step = steps_in(run_past_one(4.0, 0.0, 8.8, 1.4), BODY)[0]
    assert step.impact_mps == pytest.approx(4.0)
    assert step.least_mps is not None
    assert 2.0 < step.least_mps < 4.0


def test_who_is_braked_for_or_never_met_is_no_contact() -> None:
    braked = steps_in(run_past_one(3.0, -5.0, 6.0, 1.0), BODY)
    assert braked[0].begins_s is not None
    assert braked[0].impact_mps is None
    assert [step.begins_s for step in braked[1:]] == [None] * (PEOPLE - 1)


@pytest.mark.long
def test_a_drive_past_four_people_counts_them_and_says_how_fast_it_was() -> None:
    row = drive(SteppingInDrive("snow_lion", 2))
    found = summary([row])
    assert found["snow_lion.steps"] == PEOPLE
    contacts, impact_mps = found["snow_lion.contacts"], found["snow_lion.impact_mps_max"]
    if contacts:
        assert isinstance(impact_mps, float)
        assert MOVING_MPS < impact_mps < 4.2
    else:
        assert impact_mps is None
    speed_mps = found["snow_lion.speed_at_step_mps"]
    assert isinstance(speed_mps, float)
    assert 1.5 < speed_mps < 4.2
