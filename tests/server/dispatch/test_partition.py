"""Routes put together anew in a fleet under way: nobody is lost, no rule is broken, nothing costs more."""

import numpy as np
import pytest

from server.dispatch.answer import PromiseRules, answer_all
from server.dispatch.engine.draw import seeded
from server.dispatch.engine.insertion import best_place, insert
from server.dispatch.engine.plan import Plan, copy_plan, empty_plan, refresh, scratch_for, total_cost
from server.dispatch.engine.search.optimise import Optimiser, Settings
from server.dispatch.engine.search.partition import Partitioning, repartition
from server.dispatch.engine.search.pool import empty_pool, remember
from server.dispatch.engine.task import EPSILON_S, Task, drive_s, stand_s
from server.dispatch.improve import CoolingSchedule, improve
from server.dispatch.problem import Call, Problem, Request, VehicleState
from server.dispatch.schedule.part import Subproblem, part_of
from server.dispatch.schedule.schedule import Schedule
from server.dispatch.solve import without_deadline

_TERMS = PromiseRules(60.0, 300.0, 300.0, 0.5, 3600.0)
_NOBODY = np.zeros(0, np.int64)
_LINE = 100.0 * np.abs(np.arange(8)[:, None] - np.arange(8)[None, :])


def _under_way(seed: int) -> Schedule:
    """Three vehicles some minutes after the first of two dozen bookings."""
    rng = np.random.default_rng(seed)
    xy = rng.uniform(0.0, 900.0, (12, 2))
    times = np.linalg.norm(xy[:, None] - xy[None, :], axis=2) / 3.0
    fleet = tuple(VehicleState(f"v{k}", times[int(rng.integers(12))], 0.0, 6, 1) for k in range(3))
    schedule = Schedule(Problem(fleet, {}, times, dwell_s=15.0), spare=24)
    for k in range(24):
        pickup, dropoff = (int(place) for place in rng.permutation(12)[:2])
        from_s = 60.0 * k + 600.0 * float(rng.uniform())
        longest_s = 2.0 * float(times[pickup, dropoff]) + 300.0
        schedule.add(
            Request(
                f"r{k}", pickup, dropoff, int(rng.integers(1, 3)), 0, from_s, from_s + 900.0, 1e6, longest_s
            )
        )
        answer_all(schedule, [f"r{k}"], _TERMS)
        schedule.advance(40.0 * k)
    return schedule


def _searched(part: Subproblem, seed: int) -> Optimiser:
    """Still hot, so that the routes met can be put together better than they are."""
    settings = Settings(attempts=8, cycle=100, hot=1.0, columns=2000, visits=100_000)
    search = Optimiser(part.task, seed, settings, start=part.plan)
    for _ in range(3):
        search.run_slice()
    return search


def _keeps_every_rule(task: Task, plan: Plan, v: int) -> bool:
    """Windows, loads and rides at the plan's own times, visit by visit."""
    route, at_s = plan.route[v, : plan.length[v]], plan.least_s[v]
    load = task.load[route[0]].copy()
    for k in range(1, len(route)):
        a, b = int(route[k - 1]), int(route[k])
        load += task.load[b]
        partner = np.flatnonzero(route[:k] == b - 1) if b & 1 else _NOBODY
        rides = [at_s[k] - at_s[q] - task.service_s[b - 1] - task.ride_s_max[b - 1] for q in partner]
        if (
            at_s[k] < at_s[k - 1] + stand_s(task, a, b) + drive_s(task, a, b) - EPSILON_S
            or not task.early_s[b] - EPSILON_S <= at_s[k] <= task.late_s[b] + EPSILON_S
            or (load > task.capacity[v]).any()
            or any(ride > EPSILON_S for ride in rides)
        ):
            return False
    return True


@pytest.mark.parametrize("seed", range(8))
def test_putting_together_loses_nobody_breaks_no_rule_and_never_costs_more(seed: int) -> None:
    schedule = _under_way(seed)
    part = part_of(schedule, np.arange(3), _NOBODY)
    task, was = part.task, part.plan
    assert not was.movable.all(), "somebody is aboard"
    search = _searched(part, seed)
    cost = search.cost
    assert search.put_together() == (search.cost < cost)
    best = search.best
    assert search.cost <= cost
    assert search.cost == pytest.approx(total_cost(task, best))
    assert (best.vehicle_of >= 0).all()
    assert (best.vehicle_of[~was.movable] == was.vehicle_of[~was.movable]).all()
    visits = []
    for v in range(task.vehicles):
        locked = int(was.locked[v])
        assert (best.route[v, :locked] == was.route[v, :locked]).all()
        route = best.route[v, : best.length[v]]
        assert {int(node) >> 1 for node in route[1:-1]} <= set(np.flatnonzero(best.vehicle_of == v))
        assert _keeps_every_rule(task, best, v)
        visits += [int(node) for node in route]
    before = [int(node) for v in range(task.vehicles) for node in was.route[v, : was.length[v]]]
    assert sorted(visits) == sorted(before)


def test_routes_that_a_hot_search_met_do_go_together_better_at_times() -> None:
    cheaper = 0
    for seed in range(8):
        cheaper += _searched(part_of(_under_way(seed), np.arange(3), _NOBODY), seed).put_together()
    assert cheaper > 0


def test_the_same_seed_puts_the_same_plan_together() -> None:
    found = []
    for _ in range(2):
        schedule = _under_way(2)
        improve(schedule, CoolingSchedule(4, 50), 7, 4, without_deadline)
        found.append(schedule.routes())
    assert found[0] == found[1]


def _with_one_aboard() -> tuple[Task, Plan, Plan]:
    """A task, a plan in which the vehicle with somebody aboard fetches the other too, and the cheaper one in
    which the second, idle at that other's stop, does."""
    far, near = Request("far", 1, 7, 1, 0, 0.0, 1e6, 1e6), Request("near", 2, 1, 1, 0, 0.0, 1e6, 1e6)
    calls = (Call(7, (), ("far",), 10.0), Call(2, ("near",), (), 10.0), Call(1, (), ("near",), 10.0))
    fleet = (
        VehicleState("v", _LINE[6], 0.0, 4, 1, calls=calls, aboard=("far",)),
        VehicleState("w", _LINE[2], 0.0, 4, 1),
    )
    schedule = Schedule(Problem(fleet, {"far": far, "near": near}, _LINE, dwell_s=10.0))
    part = part_of(schedule, np.arange(2), _NOBODY)
    task, room = part.task, part.plan.route.shape[1]
    scratch = scratch_for(task, room)
    other = empty_plan(task, room)
    copy_plan(other, part.plan)
    r = int(np.flatnonzero(part.plan.movable)[0])
    other.route[0, 2], other.length[0] = other.route[0, part.plan.length[0] - 1], 3
    assert refresh(task, other, scratch, 0)
    _, i, j = best_place(task, other, scratch, 1, r, np.inf, 0.0, seeded(1))
    insert(task, other, scratch, 1, r, i, j)
    return task, part.plan, other


def test_a_vehicle_with_somebody_aboard_has_a_route_even_where_none_would_be_cheaper() -> None:
    task, plan, other = _with_one_aboard()
    room = plan.route.shape[1]
    pool, scratch = empty_pool(task, 100, 1000), scratch_for(task, room)
    # Of the first vehicle only its present route is known: to let the second fetch would leave it without.
    remember(task, pool, other, 1)
    mine = empty_plan(task, room)
    copy_plan(mine, plan)
    changed, _ = repartition(task, mine, pool, scratch, Partitioning())
    assert not changed
    assert (mine.route == plan.route).all()
    for v in range(2):
        remember(task, pool, other, v)
    changed, _ = repartition(task, mine, pool, scratch, Partitioning())
    assert changed
    assert list(mine.length) == list(other.length) == [3, 4]
    assert total_cost(task, mine) == pytest.approx(total_cost(task, other))


def test_a_bound_vehicle_that_others_stand_for_is_refused() -> None:
    task, plan, _ = _with_one_aboard()
    pool = empty_pool(task, 100, 1000)
    alike = task._replace(kind=np.zeros(2, np.int32))
    with pytest.raises(ValueError, match="only one of its kind"):
        repartition(alike, plan, pool, scratch_for(task, plan.route.shape[1]), Partitioning())
