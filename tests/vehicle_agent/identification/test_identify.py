import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from benchmarks.identify.__main__ import TOLERANCES, brake_map_error_pct
from benchmarks.identify.plant_drives import drive_plants
from simulator.vehicle.plant import PlantParams
from simulator.vehicle.random_plant import random_plant
from vehicle_agent.config import Profile
from vehicle_agent.identification.drive_signals import DriveSignals, IdentificationError
from vehicle_agent.identification.identify import Identification, identify

PROFILE = Profile()
SEED = 1


@cache
def a_drive() -> tuple[PlantParams, DriveSignals]:
    plant = random_plant(PROFILE, SEED)
    return plant, drive_plants(PROFILE, (plant,), (SEED,), 180.0)[0]


@cache
def identified() -> Identification:
    return identify(a_drive()[1], PROFILE)


def code_of(drive: DriveSignals) -> str:
    with pytest.raises(IdentificationError) as refused:
        identify(drive, PROFILE)
    return refused.value.code


def test_dead_times_of_an_unknown_vehicle_are_found() -> None:
    plant, response = a_drive()[0], identified().profile.response
    for name in ("steer", "throttle", "brake"):
        dead_s, true_s = getattr(response, f"{name}_dead_s"), getattr(plant, f"{name}_delay_s")
        assert 1e3 * abs(dead_s - true_s) < TOLERANCES["delay_ms"], name


def test_the_brake_map_of_an_unknown_vehicle_is_found() -> None:
    assert brake_map_error_pct(identified(), a_drive()[0]) < TOLERANCES["brake_map_pct"]


def test_bias_and_wheelbase_of_an_unknown_vehicle_are_found() -> None:
    plant, profile = a_drive()[0], identified().profile
    bias_rad = profile.response.steer_bias_rad
    assert math.degrees(abs(bias_rad - plant.steer_bias_rad)) < TOLERANCES["bias_deg"]
    assert 100.0 * abs(profile.body.wheelbase_m - plant.wheelbase_m) < TOLERANCES["wheelbase_cm"]


@pytest.mark.long
def test_a_few_outliers_do_not_change_the_result() -> None:
    drive = a_drive()[1]
    speed, steer = drive.speed_mps.copy(), drive.steer_rad.copy()
    speed[1000::500] += 0.4
    steer[1200::700] += 0.1
    found = identify(replace(drive, speed_mps=speed, steer_rad=steer), PROFILE).profile
    clean = identified().profile
    assert found.response.brake_dead_s == pytest.approx(clean.response.brake_dead_s, abs=0.01)
    assert found.body.wheelbase_m == pytest.approx(clean.body.wheelbase_m, abs=0.01)


def test_the_profile_keeps_what_a_drive_does_not_show() -> None:
    found = identified().profile
    assert found.lidar == PROFILE.lidar
    assert found.stack == PROFILE.stack


def test_a_short_drive_is_refused() -> None:
    assert code_of(_cut(a_drive()[1], 60.0)) == "too_short"


def test_a_drive_by_hand_is_refused() -> None:
    drive = a_drive()[1]
    assert code_of(replace(drive, driving=np.zeros_like(drive.driving))) == "not_enabled"


def test_a_drive_that_stood_still_is_refused() -> None:
    drive = a_drive()[1]
    assert code_of(replace(drive, speed_mps=np.zeros_like(drive.speed_mps))) == "stood_still"


@pytest.mark.parametrize(("column", "code"), [(1, "never_accelerated"), (2, "never_braked")])
def test_a_drive_without_a_pedal_is_refused(column: int, code: str) -> None:
    drive = a_drive()[1]
    commands = drive.commands.copy()
    commands[:, column] = 0.0
    assert code_of(replace(drive, commands=commands)) == code


def test_a_straight_drive_is_refused() -> None:
    drive = a_drive()[1]
    assert code_of(replace(drive, steer_rad=np.abs(drive.steer_rad))) == "never_turned"


def test_a_drive_without_poses_is_refused() -> None:
    drive = a_drive()[1]
    assert code_of(replace(drive, heading_rad=np.full_like(drive.heading_rad, np.nan))) == "no_pose"


def test_a_drive_with_long_gaps_is_refused() -> None:
    drive = a_drive()[1]
    late = np.where(drive.tick_s > 90.0, 5.0, 0.0)
    assert code_of(replace(drive, tick_s=drive.tick_s + late)) == "gap"


def test_times_that_do_not_rise_are_refused() -> None:
    drive = a_drive()[1]
    tick_s = drive.tick_s.copy()
    tick_s[100] = tick_s[99]
    assert code_of(replace(drive, tick_s=tick_s)) == "gap"


def test_misaligned_wheels_are_refused_as_outside_the_range() -> None:
    plant = replace(random_plant(PROFILE, SEED), steer_bias_rad=0.08)
    assert code_of(drive_plants(PROFILE, (plant,), (SEED,), 180.0)[0]) == "outside_range"


def test_a_weak_brake_is_refused_as_outside_the_range() -> None:
    plant = replace(random_plant(PROFILE, SEED), brake_full_mps2=1.5)
    assert code_of(drive_plants(PROFILE, (plant,), (SEED,), 180.0)[0]) == "outside_range"


def _cut(drive: DriveSignals, seconds: float) -> DriveSignals:
    n, m = (int(np.searchsorted(times, seconds)) for times in (drive.tick_s, drive.report_s))
    ticked = {
        name: getattr(drive, name)[:n]
        for name in ("tick_s", "commands", "driving", "yaw_rate_radps", "heading_rad")
    }
    reported = {name: getattr(drive, name)[:m] for name in ("report_s", "speed_mps", "steer_rad")}
    return DriveSignals(**ticked, **reported)
