"""How many people were around a vehicle, and how fast it drove among them."""

import numpy as np
import pytest

from campusloop.scenes.people_met import people_met
from campusloop.scenes.stacks import profile_of
from contract.geometry import Array
from simulator.traffic.actors import Bodies
from vehicle_agent.signals import PEDESTRIAN, VEHICLE

BODY = profile_of("snow_lion").body
FRONT_M = BODY.front_overhang_m


def bodies(places: list[tuple[float, float]], kind: int = PEDESTRIAN) -> Bodies:
    n = len(places)
    poses = np.zeros((n, 3))
    poses[:, :2] = np.array(places).reshape(n, 2)
    return Bodies(np.arange(n), np.full(n, kind), poses, np.zeros((n, 2)), np.full((n, 2), 0.5))


def rows(speeds_mps: list[float], *, yaw_rad: float = 0.0, every_s: float = 0.5) -> Array:
    return np.array([(every_s * k, 0.0, 0.0, yaw_rad, v, 0.0, 0.0) for k, v in enumerate(speeds_mps)])


def test_who_is_within_100m2_of_the_bumper_counts_and_nobody_else() -> None:
    near = [(0.0, FRONT_M + 5.6), (5.6, FRONT_M), (0.0, FRONT_M)]
    beyond = [(0.0, FRONT_M + 5.7), (0.0, FRONT_M - 5.7)]
    met = people_met(rows([0.0], yaw_rad=0.5 * np.pi), [bodies(near + beyond)], BODY)
    assert met.per_100m2 == 3.0


def test_it_is_a_mean_over_time_and_cars_are_no_people() -> None:
    here = [(FRONT_M, 1.0), (FRONT_M, 2.0)]
    met = people_met(rows([1.0] * 3), [bodies(here), bodies([]), bodies(here, VEHICLE)], BODY)
    assert met.per_100m2 == pytest.approx(2.0 / 3.0)


def test_only_moments_among_5_to_8_people_count_as_dense() -> None:
    crowds = [bodies([(FRONT_M + 1.0, 0.1 * k) for k in range(n)]) for n in (4, 5, 8, 9)]
    met = people_met(rows([9.0, 1.0, -2.0, 9.0]), crowds, BODY)
    assert (met.dense_s, met.dense_m) == (1.0, 1.5)


@pytest.mark.parametrize("every_s", [0.02, 1.0 / 23.976])
def test_moments_are_half_a_second_apart_at_any_rate(every_s: float) -> None:
    n = round(10.0 / every_s)
    met = people_met(rows([2.0] * n, every_s=every_s), [bodies([(FRONT_M, 0.0)] * 5)] * n, BODY)
    assert met.dense_s == pytest.approx(10.0, abs=0.5)
    assert met.dense_m == pytest.approx(20.0, abs=1.0)


def test_a_drive_that_never_began_met_nobody() -> None:
    met = people_met(np.zeros((0, 7)), [], BODY)
    assert (met.per_100m2, met.dense_s, met.dense_m) == (0.0, 0.0, 0.0)
