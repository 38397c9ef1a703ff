"""The fleet search: nobody is left out, fewer vehicles only, repeatable."""

import math
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.instances.rescore import rescored
from campusloop.studies.instances.instance import Instance
from campusloop.studies.instances.task import node_routes, task_of
from server.dispatch.engine.search.fleet import FleetSearch, FleetSettings
from server.dispatch.engine.search.optimise import Optimiser, Settings
from tests.server.dispatch.engine.instances import small_instance

_SHORT = FleetSettings(attempts=100)


def _without_rides(seed: int, requests: int, vehicles: int) -> Instance:
    return replace(small_instance(seed, requests, vehicles), ride_max=math.inf, duration_max=math.inf)


def _vehicles(routes: list[list[int]]) -> int:
    return sum(1 for route in routes if route)


@pytest.mark.parametrize("seed", range(5))
def test_everybody_is_served_with_fewer_vehicles_by_another_reckoning(seed: int) -> None:
    instance = _without_rides(seed, 12, 12)
    search = FleetSearch(task_of(instance), seed, _SHORT)
    used = []
    for _ in range(4):
        search.run_slice()
        used.append(search.task.vehicles)
    assert used == sorted(used, reverse=True)
    assert used[-1] < instance.vehicles
    assert (search.best.vehicle_of >= 0).all()
    routes = node_routes(instance, search.best)
    assert _vehicles(routes) == used[-1]
    rescored(instance, routes)


def test_two_requests_at_opposite_ends_at_one_time_need_two_vehicles() -> None:
    instance = _without_rides(1, 2, 4)
    early = np.array([0.0, 50.0, 50.0, 0.0, 0.0])
    xy = np.array([[0.0, 0.0], [-10.0, 0.0], [10.0, 0.0], [-9.0, 0.0], [9.0, 0.0]])
    instance = replace(instance, xy=xy, early=early, late=np.array([240.0, 51.0, 51.0, 240.0, 240.0]))
    search = FleetSearch(task_of(instance), 1, _SHORT)
    search.run_slice()
    assert search.task.vehicles == 2


def test_the_same_seed_gives_the_same_fleet_and_the_same_other_plans() -> None:
    instance = _without_rides(3, 14, 10)
    found = []
    for _ in range(2):
        search = FleetSearch(task_of(instance), 7, _SHORT)
        for _ in range(3):
            search.run_slice()
        plans = [search.best, search.another(), search.another()]
        found.append([node_routes(instance, plan) for plan in plans])
    assert found[0] == found[1]


def test_an_optimiser_goes_on_from_the_fleet_that_was_found() -> None:
    instance = _without_rides(4, 14, 10)
    search = FleetSearch(task_of(instance), 7, _SHORT)
    search.run_slice()
    first = rescored(instance, node_routes(instance, search.best))
    settings = Settings(attempts=100, cycle=1, afresh_every=1)
    optimiser = Optimiser(search.task, 7, settings, start=search.best, afresh=search.another)
    assert optimiser.cost == pytest.approx(first)
    for _ in range(3):
        optimiser.run_slice()
    routes = node_routes(instance, optimiser.best)
    assert rescored(instance, routes) <= first + 1e-9
    assert _vehicles(routes) <= search.task.vehicles
