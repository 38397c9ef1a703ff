"""The benchmark of pickup and delivery: vehicles count before distance."""

import math
from dataclasses import replace

from benchmarks.pdptw.__main__ import (
    measured,
    scored,
    solve,
    summary_of,
)
from campusloop.studies.instances.instance import Instance
from tests.server.dispatch.engine.instances import small_instance


def _instance() -> Instance:
    return replace(small_instance(2, 8, 6), ride_max=math.inf, duration_max=math.inf)


def test_a_solution_keeps_every_rule_and_is_as_good_as_itself() -> None:
    instance = _instance()
    routes, _ = solve(instance, 0.0, 1)
    vehicles, distance, broken = scored(instance, routes)
    assert not broken
    assert distance is not None
    row = measured(instance, 0.0, 1, (vehicles, distance), None, peers=False)
    assert row["optimal"] is True
    assert summary_of([row], peers=False)["vehicles_as_best_known_pct"] == 100.0


def test_a_distance_with_more_vehicles_than_the_best_known_has_no_gap() -> None:
    instance = _instance()
    row = measured(instance, 0.0, 1, (0.0, 1.0), None, peers=False)
    assert row["gap_pct"] is None
    assert row["optimal"] is False
    assert summary_of([row], peers=False)["vehicles_as_best_known_pct"] == 0.0


def test_routes_that_leave_somebody_out_have_no_distance() -> None:
    vehicles, distance, broken = scored(_instance(), [[1, 9]])
    assert (vehicles, distance) == (1, None)
    assert "not visited" in broken
