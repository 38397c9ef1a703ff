"""The search: feasible by another's reckoning, repeatable, and optimal where that can be checked."""

import math
from dataclasses import replace
from itertools import pairwise, permutations, product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.instances.rescore import RouteBroken, rescored
from campusloop.studies.instances.instance import Instance
from campusloop.studies.instances.task import node_routes, task_of
from server.dispatch.engine.draw import seeded
from server.dispatch.engine.insertion import best_place, exact_cost
from server.dispatch.engine.plan import refresh, scratch_for
from server.dispatch.engine.search.optimise import Optimiser, Settings, settings_for
from tests.server.dispatch.engine.instances import small_instance

_SHORT = Settings(attempts=200, cycle=2, columns=5000, visits=100_000)


def _cheapest(instance: Instance) -> float:
    """By looking at every order of every share of the requests; inf where nothing is feasible."""
    requests = range(len(instance.pairs))
    best_of: dict[tuple[int, ...], float] = {(): 0.0}
    for size in range(1, len(instance.pairs) + 1):
        for chosen in permutations(requests, size):
            if list(chosen) == sorted(chosen):
                best_of[chosen] = _cheapest_route(instance, chosen)
    total = math.inf
    for share in product(range(instance.vehicles), repeat=len(instance.pairs)):
        routes = [tuple(r for r in requests if share[r] == v) for v in range(instance.vehicles)]
        total = min(total, sum(best_of[route] for route in routes))
    return total


def _cheapest_route(instance: Instance, chosen: tuple[int, ...]) -> float:
    nodes = [int(instance.nodes[k]) for r in chosen for k in instance.pairs[r]]
    best = math.inf
    for order in permutations(nodes):
        best = min(best, _scored(instance, order))
    return best


def _scored(instance: Instance, order: tuple[int, ...]) -> float:
    try:
        return rescored(instance, [order])
    except RouteBroken as error:
        missing = "are not visited" in str(error)
        assert not missing or len(order) < len(instance.nodes) - 1
        return _distance(instance, order) if missing else math.inf


def _distance(instance: Instance, order: tuple[int, ...]) -> float:
    stops = [0, *order, 0]
    return sum(math.dist(instance.xy[a], instance.xy[b]) for a, b in pairwise(stops))


@pytest.mark.parametrize("seed", range(6))
def test_three_requests_are_served_at_least_cost(seed: int) -> None:
    instance = small_instance(seed, 3)
    optimiser = Optimiser(task_of(instance), 1, _SHORT)
    for _ in range(3):
        optimiser.run_slice()
    optimum = _cheapest(instance)
    if math.isinf(optimum):
        assert (optimiser.best.vehicle_of < 0).any()
    else:
        assert rescored(instance, node_routes(instance, optimiser.best)) == pytest.approx(optimum)


@settings(deadline=None, max_examples=25)
@given(seed=st.integers(0, 10_000), requests=st.integers(4, 14))
def test_every_route_keeps_every_rule_by_another_reckoning(seed: int, requests: int) -> None:
    instance = small_instance(seed, requests, vehicles=4)
    optimiser = Optimiser(task_of(instance), seed, _SHORT)
    costs = [optimiser.cost]
    for _ in range(3):
        optimiser.run_slice()
        costs.append(optimiser.cost)
    assert costs == sorted(costs, reverse=True)
    if (optimiser.best.vehicle_of >= 0).all():
        assert rescored(instance, node_routes(instance, optimiser.best)) == pytest.approx(optimiser.cost)


def test_the_same_seed_gives_the_same_plan() -> None:
    instance = small_instance(5, 14, vehicles=4)
    found = []
    for _ in range(2):
        optimiser = Optimiser(task_of(instance), 3, _SHORT)
        for _ in range(5):
            optimiser.run_slice()
        found.append((optimiser.cost, node_routes(instance, optimiser.best)))
    assert found[0] == found[1]


@pytest.mark.parametrize(("window_s", "hot", "cycle"), [(0.0, 0.2, 15), (40.0, 0.48, 35), (400.0, 0.7, 3520)])
def test_wide_windows_are_annealed_hotter_and_longer(window_s: float, hot: float, cycle: int) -> None:
    """Forty requests of which each visit takes ten seconds of driving and standing."""
    task = task_of(small_instance(1, 40))
    visits = 2 * task.requests
    task.late_s[:visits] = task.early_s[:visits] + window_s
    task.service_s[:visits] = 10.0
    task.travel_s[:] = 0.0
    found = settings_for(task)
    assert (round(found.hot, 6), found.cycle) == (hot, cycle)
    assert (found.afresh_every == 1) == (window_s > 30.0)


@settings(deadline=None, max_examples=40)
@given(seed=st.integers(0, 10_000), rides=st.booleans())
def test_the_quick_insertion_test_misses_no_better_place(seed: int, rides: bool) -> None:
    """Against the exact check of every pair of positions, with longest rides and without."""
    instance = small_instance(seed, 8, vehicles=3)
    if not rides:
        instance = replace(instance, ride_max=math.inf, duration_max=math.inf)
    task = task_of(instance)
    optimiser = Optimiser(task, seed, _SHORT)
    optimiser.run_slice()
    plan, scratch, rng = optimiser.best, scratch_for(task, 18), seeded(1)
    absent = [int(r) for r in np.flatnonzero(plan.vehicle_of < 0)] or [_taken_out(optimiser, 0)]
    for r in absent:
        for v in range(task.vehicles):
            cost, _, _ = best_place(task, plan, scratch, v, r, np.inf, 0.0, rng)
            n = int(plan.length[v])
            fits = (
                exact_cost(task, plan, scratch, v, r, i, j) - plan.cost[v]
                for i in range(n - 1)
                for j in range(i, n - 1)
                if _has_room(plan.load[v], task.load[2 * r], task.capacity[v], i, j)
            )
            assert cost == pytest.approx(min(fits, default=np.inf))


def _taken_out(optimiser: Optimiser, r: int) -> int:
    plan = optimiser.best
    v = int(plan.vehicle_of[r])
    left = [node for node in plan.route[v, : plan.length[v]] if node >> 1 != r]
    plan.route[v, : len(left)], plan.length[v] = left, len(left)
    plan.vehicle_of[r] = -1
    assert refresh(optimiser.task, plan, scratch_for(optimiser.task, 18), v)
    return r


def _has_room(load: np.ndarray, more: np.ndarray, capacity: np.ndarray, i: int, j: int) -> bool:
    return bool((load[i : j + 1] + more <= capacity).all())
