"""Vehicles outside the identified range: the drive stops with a clear word, and a usual vehicle does not."""

import math
from dataclasses import replace

import numpy as np
import pytest

from campusloop.scenes.drive import VEHICLE_ID, Scene, SceneDrive, SceneRun
from campusloop.scenes.path_map import path_map
from campusloop.scenes.stacks import profile_of
from simulator.vehicle.plant import PlantParams
from simulator.vehicle.random_plant import nominal_with_tyres
from simulator.world import WorldOptions


def driven(stack: str, resumes_s: tuple[float, ...] = (), **plant: float) -> SceneRun:
    profile = profile_of(stack)
    path = np.column_stack((np.arange(0.0, 160.0), np.zeros(160)))
    changed: PlantParams = replace(nominal_with_tyres(profile), **plant)
    scene = Scene(
        name="unlike",
        road_map=path_map("unlike", path, width_m=5.0, speed_limit_mps=4.2),
        profile=profile,
        start_s_m=6.0,
        start_mps=0.0,
        goal_s_m=150.0,
        limit_s=40.0,
        seed=1,
        options=WorldOptions(traffic=None, plants={VEHICLE_ID: changed}),
        resumes_s=resumes_s,
    )
    return SceneDrive(scene).run()


@pytest.mark.parametrize("stack", ["snow_lion", "gem", "nus"])
def test_a_bent_linkage_is_named_and_stops_the_vehicle(stack: str) -> None:
    run = driven(stack, steer_bias_rad=0.09)
    assert "steering_unlike_profile" in run.reported
    assert run.time_s is None
    assert abs(run.trace.array()[-1, 4]) < 0.01


@pytest.mark.long
def test_a_road_steeper_than_any_load_explains_is_named_too() -> None:
    downhill = driven("snow_lion", slope_ratio=0.18, slope_direction_rad=math.pi)
    assert "pedals_unlike_profile" in downhill.reported
    assert downhill.time_s is None
    assert abs(downhill.trace.array()[-1, 4]) < 0.01


@pytest.mark.parametrize("strength", [pytest.param(0.35, marks=pytest.mark.long), 2.6])
def test_a_drive_far_stronger_or_weaker_than_its_profiles_is_named_too(strength: float) -> None:
    full_mps2 = nominal_with_tyres(profile_of("snow_lion")).throttle_full_mps2
    run = driven("snow_lion", throttle_full_mps2=strength * full_mps2)
    assert "pedals_unlike_profile" in run.reported
    assert run.time_s is None
    assert abs(run.trace.array()[-1, 4]) < 0.01


def test_after_a_resume_it_stops_again() -> None:
    once = driven("gem", steer_bias_rad=0.09)
    twice = driven("gem", resumes_s=(25.0,), steer_bias_rad=0.09)
    assert twice.driven_m > once.driven_m + 1.0
    assert abs(twice.trace.array()[-1, 4]) < 0.01


@pytest.mark.parametrize("stack", ["snow_lion", "gem"])
@pytest.mark.parametrize("bias_rad", [pytest.param(-0.0175, marks=pytest.mark.long), 0.0175])
def test_a_vehicle_within_the_range_is_not_stopped(stack: str, bias_rad: float) -> None:
    run = driven(stack, steer_bias_rad=bias_rad)
    assert not [code for code in run.reported if code.endswith("unlike_profile")]
