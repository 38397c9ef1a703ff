"""Satellites between buildings, and receivers that know their kind of solution but no reflections."""

import math

import numpy as np
import pytest

from contract.geometry import Pose2
from contract.roads.model import Building, Origin
from contract.roads.projection import project
from contract.roads.walls import wall_edges
from simulator.sensors.gnss import CampusReceiver, GnssNoise
from simulator.sensors.sky import FIXED, FLOATING, Sky, SolutionFinder, skyline_rad
from simulator.vehicle.plant import PlantView

ORIGIN = Origin(31.3, 121.4)
TICK_NS = 20_000_000


def block(x_m: float, y_m: float, width_m: float, depth_m: float, height_m: float) -> Building:
    x1, y1 = x_m + width_m, y_m + depth_m
    return Building(((x_m, y_m), (x1, y_m), (x1, y1), (x_m, y1)), height_m)


# A canyon along x: walls of 30 m on both sides of a way of 12 m.
CANYON = (block(-200.0, 6.0, 400.0, 10.0, 30.0), block(-200.0, -16.0, 400.0, 10.0, 30.0))


def standing(x_m: float, y_m: float) -> PlantView:
    return PlantView(Pose2(x_m, y_m, 0.0), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)


def errors_m(buildings: tuple[Building, ...], seconds: float, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Errors (n, 2) and stated deviations (n,) of a receiver that stands in the middle."""
    rng = np.random.default_rng(seed)
    receiver = CampusReceiver(ORIGIN, GnssNoise(), Sky(buildings, rng), rng)
    errors, stated = [], []
    for k in range(round(seconds * 50)):
        fix = receiver.fix(k * TICK_NS, standing(0.0, 0.0))
        assert fix is not None
        if math.isfinite(fix.position_std_m):
            errors.append(project(ORIGIN, fix.latitude_deg, fix.longitude_deg))
            stated.append(fix.position_std_m)
    return np.array(errors), np.array(stated)


def test_the_skyline_is_as_high_as_its_walls() -> None:
    edges = wall_edges((block(10.0, -50.0, 5.0, 100.0, 12.3),))
    skyline = skyline_rad(edges, np.full(len(edges), 12.3), 0.0, 0.0, 2.3, 8)
    facing = skyline[[0, 7]]
    assert facing == pytest.approx(math.atan(10.0 / (10.0 / math.cos(math.pi / 8))), abs=1e-9)
    assert skyline[3] == skyline[4] == 0.0


def test_under_an_open_sky_the_solution_is_fixed_and_as_good_as_stated() -> None:
    errors, stated = errors_m((), 200.0, seed=1)
    assert stated.max() < 0.03
    assert 0.4 < np.hypot(*errors.T).mean() / stated.mean() < 2.5


def test_between_high_walls_there_are_fewer_satellites_and_errors_that_nobody_states() -> None:
    ratios, stated = [], []
    for seed in range(8):
        errors, said = errors_m(CANYON, 60.0, seed)
        if len(said):
            stated.append(said.mean())
            ratios.append(float(np.sqrt((errors**2).sum(axis=1).mean()) / said.mean()))
    assert max(stated) > 0.1
    assert max(ratios) > 2.0


def test_a_fixed_solution_comes_back_a_while_after_the_satellites() -> None:
    finder = SolutionFinder(Sky(CANYON, np.random.default_rng(3)))
    assert finder.solution(0, 500.0, 0.0)[0] is FIXED
    assert finder.solution(2_000_000_000, 0.0, 0.0)[0] is not FIXED
    assert finder.solution(4_000_000_000, 500.0, 0.0)[0] is FLOATING
    assert finder.solution(13_000_000_000, 500.0, 0.0)[0] is FIXED


def test_the_same_seed_gives_the_same_fixes() -> None:
    first, again = errors_m(CANYON, 5.0, seed=4), errors_m(CANYON, 5.0, seed=4)
    assert np.array_equal(first[0], again[0])
