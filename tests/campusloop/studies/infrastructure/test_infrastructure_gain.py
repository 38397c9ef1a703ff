"""The time-gain experiment in small: nobody is touched, it repeats, and the plots and figures are written."""

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from campusloop.cli import app_of
from campusloop.studies.infrastructure.crossing_loop import (
    CROSSING_M,
    CrossingLoop,
    People,
    loop_map,
)
from campusloop.studies.infrastructure.infrastructure_gain import GainCase, run_case, run_cases
from contract.roads.areas import areas_ahead
from vehicle_agent.config import load_profile

PROFILE = load_profile(Path(__file__).resolve().parents[4] / "vehicle_agent" / "profiles" / "nus-cart.toml")


def a_loop(infrastructure: bool, vehicles: int = 1, rate_1ps: float = 1e-6) -> CrossingLoop:
    return CrossingLoop(PROFILE, vehicles, 2.0, rate_1ps, infrastructure, seed=1)


def test_the_loop_has_one_crossing_in_each_lap() -> None:
    loop = a_loop(False)
    assert [area.area_id for area in areas_ahead(loop.network, loop.line)].count("crossing") == 2
    assert loop.lap_m == pytest.approx(2 * 50.0 + 2 * np.pi * 10.0, rel=0.01)
    assert loop_map().map_version == loop.road_map.map_version


def slowest_before_crossing(loop: CrossingLoop) -> float:
    slowest = np.inf
    for _ in range(1200):
        loop.step()
        bumper_m = loop.carts[0].at_m % loop.lap_m + PROFILE.body.front_overhang_m
        if CROSSING_M - 5.0 < bumper_m < CROSSING_M - 2.0:
            slowest = min(slowest, loop.plant.view(0).speed_mps)
    return slowest


def test_without_people_the_baseline_stops_and_the_camera_spares_the_stop() -> None:
    assert slowest_before_crossing(a_loop(False)) < 0.1
    assert slowest_before_crossing(a_loop(True)) > 1.0


@pytest.mark.parametrize("vehicles", [10, pytest.param(20, marks=pytest.mark.long)])
def test_carts_keep_their_distance(vehicles: int) -> None:
    loop = a_loop(False, vehicles)
    closest = np.inf
    for _ in range(800):
        loop.step()
        at = np.array([cart.start_m + cart.driven_m for cart in loop.carts])
        closest = min(closest, float(((np.roll(at, -1) - at) % loop.lap_m).min()))
    assert closest > PROFILE.body.length_m + 1.0


@pytest.mark.long
def test_nobody_is_touched_and_the_camera_gains_time() -> None:
    row = run_case(PROFILE, GainCase(3, 2.0, 0.05, 4, seed=2))
    assert row.contacts == 0
    assert row.laps_finished == 4
    assert row.cumulative_s[-1] == pytest.approx(sum(row.gain_s), abs=0.01)
    assert row.fleet_s[-1] == pytest.approx(3 * row.cumulative_s[-1], abs=0.01)
    assert row.cumulative_s[-1] > 0.0
    assert row.infra_lap_s < row.base_lap_s


@pytest.mark.long
def test_one_seed_gives_the_same_rows_with_one_worker_or_two() -> None:
    cases = [GainCase(1, 2.0, 0.1, 1, seed=3), GainCase(2, 2.0, 0.1, 1, seed=3)]
    assert list(run_cases(PROFILE, cases, 1)) == list(run_cases(PROFILE, cases, 2))


def test_people_come_as_often_as_they_should_and_cross_when_nobody_drives() -> None:
    people = People(0.5, np.random.default_rng(1))
    nobody = np.empty(0)
    arrived, before = 0, 0
    for k in range(20_000):
        people.step(0.1 * k, nobody, nobody, nobody)
        arrived += max(0, len(people.ways) - before)
        before = len(people.ways)
    assert arrived == pytest.approx(1000, rel=0.1)
    assert len(people.ways) < 15


def test_nobody_steps_in_front_of_a_moving_cart_and_everybody_goes_before_a_standing_one() -> None:
    people = People(1.0, np.random.default_rng(1))
    moving, standing = np.array([2.0]), np.array([0.0])
    bumper, tail = np.array([CROSSING_M - 4.0]), np.array([CROSSING_M - 6.0])
    for k in range(100):
        people.step(0.1 * k, bumper, tail, moving)
    assert len(people.ways) > 2
    assert np.all(np.abs(people.places[:, 1]) > 1.5)
    for k in range(100, 160):
        people.step(0.1 * k, bumper, tail, standing)
    assert np.any(np.abs(people.places[:, 1]) < 1.5)


def test_the_command_writes_figures_and_plots(tmp_path: Path) -> None:
    out = tmp_path / "gain"
    options = ["--vehicles", "1,2", "--speeds", "2", "--lambda", "0.1", "--laps", "1", "--out", str(out)]
    result = CliRunner().invoke(app_of(["infrastructure"]), ["infrastructure", "gain", *options])
    assert result.exit_code == 0, result.output
    report = json.loads((out / "gain.json").read_text())
    assert [row["vehicles"] for row in report["rows"]] == [1, 2]
    assert report["summary"]["contacts"] == 0
    for name in ("gain-one-vehicle.png", "gain-fleet.png"):
        assert (out / name).read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    "option", [["--vehicles", "0"], ["--vehicles", "a"], ["--speeds", "3"], ["--lambda", "-1"]]
)
def test_options_that_make_no_sense_are_refused(tmp_path: Path, option: list[str]) -> None:
    arguments = ["infrastructure", "gain", "--out", str(tmp_path), *option]
    assert CliRunner().invoke(app_of(["infrastructure"]), arguments).exit_code == 2
