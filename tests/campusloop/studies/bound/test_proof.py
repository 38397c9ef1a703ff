"""The proof against brute force on small instances, in full, starved and interrupted."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings

from campusloop.studies.bound.network import network_of
from campusloop.studies.bound.progress import Limits, Progress
from campusloop.studies.bound.proof import prove
from campusloop.studies.instances.instance import Instance, InstanceBroken
from tests.campusloop.studies.bound.small_instances import (
    a_ring,
    cost_of,
    instances,
    is_feasible,
    optimum,
    seeded_instance,
)

AMPLE = Limits(labels_max=20_000, enumeration_labels_max=40_000)
SCARCE = Limits(labels_max=60, enumeration_labels_max=100, columns_a_round=2, cuts_a_round=2)


def proven_steps(instance: Instance, limits: Limits = AMPLE, upper: float = math.inf) -> list[Progress]:
    """All steps, none where the instance is found to be impossible."""
    try:
        return list(prove(network_of(instance), limits, upper))
    except InstanceBroken:
        return []


def check_solution(instance: Instance, step: Progress) -> None:
    """Serves everybody once, keeps every rule, costs what it says."""
    if not step.solution:
        return
    assert sorted(node for route in step.solution for node in route) == sorted(instance.pairs.ravel())
    assert len(step.solution) <= instance.vehicles
    assert all(is_feasible(instance, route) for route in step.solution)
    assert sum(cost_of(instance, route) for route in step.solution) == pytest.approx(step.upper)


@pytest.mark.parametrize("first", range(0, 90, 10))
def test_the_bound_ends_at_the_optimum_and_is_never_above(first: int) -> None:
    for seed in range(first, first + 10):
        instance = seeded_instance(seed)
        best = optimum(instance)
        steps = proven_steps(instance)
        if math.isinf(best):
            assert not steps
            continue
        assert max(step.bound for step in steps) <= best + 1e-9
        assert steps[-1].closed
        assert steps[-1].bound == pytest.approx(best, abs=1e-4)
        check_solution(instance, steps[-1])


@pytest.mark.parametrize("first", range(100, 150, 10))
def test_a_proof_that_runs_out_of_labels_is_still_one(first: int) -> None:
    """Every step is where an interruption would leave it: bounds rise and never pass the optimum."""
    for seed in range(first, first + 10):
        instance = seeded_instance(seed)
        best = optimum(instance)
        bounds = [step.bound for step in proven_steps(instance, SCARCE)]
        assert bounds == sorted(bounds)
        assert max(bounds, default=0.0) <= best + 1e-9


def test_a_proof_that_runs_out_of_labels_says_so() -> None:
    *_, last = proven_steps(a_ring(12), SCARCE)
    assert not last.closed
    assert "labels" in last.limit


@settings(max_examples=40, deadline=None)
@given(instances())
def test_odd_instances_are_no_exception(instance: Instance) -> None:
    """Places that coincide, windows of one instant, no service time."""
    best = optimum(instance)
    steps = proven_steps(instance)
    assert bool(steps) == math.isfinite(best)
    if steps:
        assert steps[-1].bound == pytest.approx(best, abs=1e-4)
        assert steps[-1].bound <= best + 1e-9
        check_solution(instance, steps[-1])


@pytest.mark.parametrize("seed", range(20))
def test_a_cost_known_from_elsewhere_does_not_raise_the_bound_above_the_optimum(seed: int) -> None:
    instance = seeded_instance(seed)
    best = optimum(instance)
    if math.isfinite(best):
        steps = proven_steps(instance, upper=best + 0.5)
        assert max(step.bound for step in steps) <= best + 1e-9
        assert steps[-1].bound == pytest.approx(best, abs=1e-4)


def test_a_cost_that_no_plan_has_is_all_that_is_proven() -> None:
    best = proven_steps(a_ring(10))[-1].upper
    steps = proven_steps(a_ring(10), upper=best - 5.0)
    assert best - 5.0 - 1e-4 <= steps[-1].bound <= best


def test_bounds_only_rise_from_step_to_step() -> None:
    steps = proven_steps(a_ring(10))
    bounds = [step.bound for step in steps]
    assert bounds == sorted(bounds)
    assert bounds[0] == 0.0
    assert len(np.unique(bounds)) > 3
    assert steps[-1].closed


def test_a_fleet_that_is_too_small_is_named() -> None:
    instance = replace(a_ring(6), vehicles=1)
    with pytest.raises(InstanceBroken, match="1 vehicles cannot serve"):
        list(prove(network_of(instance), AMPLE))
