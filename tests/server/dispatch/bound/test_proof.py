"""The proof against brute force on small instances."""

import math
from dataclasses import replace

import pytest
from hypothesis import given, settings

from server.dispatch.bound.network import network_of
from server.dispatch.bound.progress import Limits, Progress
from server.dispatch.bound.proof import prove
from server.dispatch.instance import Instance, InstanceBroken
from tests.server.dispatch.bound.small_instances import a_ring, cost_of, instances, is_feasible, optimum

LIMITS = Limits(labels_max=20_000, enumeration_labels_max=40_000)


def proven_steps(instance: Instance, upper: float = math.inf) -> list[Progress]:
    """All steps, none where the instance is found to be impossible."""
    try:
        return list(prove(network_of(instance), LIMITS, upper))
    except InstanceBroken:
        return []


@settings(max_examples=60, deadline=None)
@given(instances())
def test_bound_is_never_above_the_optimum_and_closed_means_equal(instance: Instance) -> None:
    best = optimum(instance)
    steps = proven_steps(instance)
    if math.isinf(best):
        assert not any(step.solution for step in steps)
        return
    assert all(step.bound <= best + 1e-6 for step in steps)
    assert steps[-1].closed
    assert steps[-1].bound == pytest.approx(best, abs=1e-4)


@settings(max_examples=30, deadline=None)
@given(instances())
def test_solution_found_serves_everybody_and_keeps_every_rule(instance: Instance) -> None:
    for step in proven_steps(instance)[-1:]:
        served = [node for route in step.solution for node in route]
        assert sorted(served) == sorted(instance.pairs.ravel())
        assert len(step.solution) <= instance.vehicles
        assert all(is_feasible(instance, route) for route in step.solution)
        assert sum(cost_of(instance, route) for route in step.solution) == pytest.approx(step.upper)


@settings(max_examples=30, deadline=None)
@given(instances(wanted_max=3))
def test_a_given_upper_bound_does_not_raise_the_bound_above_the_optimum(instance: Instance) -> None:
    best = optimum(instance)
    if math.isfinite(best):
        steps = proven_steps(instance, upper=best + 0.5)
        assert all(step.bound <= best + 1e-6 for step in steps)
        assert steps[-1].bound == pytest.approx(best, abs=1e-4)


def test_bounds_only_rise_from_step_to_step() -> None:
    steps = proven_steps(a_ring(10))
    bounds = [step.bound for step in steps]
    assert bounds == sorted(bounds)
    assert steps[-1].closed


def test_a_fleet_that_is_too_small_is_named() -> None:
    instance = replace(a_ring(6), vehicles=1, late=a_ring(6).early + 12.0)
    with pytest.raises(InstanceBroken, match="1 vehicles cannot serve"):
        list(prove(network_of(instance), LIMITS))
