"""Ruin and recreate under simulated annealing: many small attempts, each kept or taken back."""

from typing import NamedTuple

import numpy as np

from server.dispatch.arrays import AnyArray
from server.dispatch.engine.compiled import kernel
from server.dispatch.engine.draw import uniform
from server.dispatch.engine.plan import ABSENT, Plan, Scratch, copy_plan, copy_route, total_cost
from server.dispatch.engine.search.pool import RoutePool, remember
from server.dispatch.engine.search.recreate import InsertionOffers, put_back
from server.dispatch.engine.search.ruin import Undo, ruin_strings
from server.dispatch.engine.task import Task

_WORTH_S = 1e-9


class Annealing(NamedTuple):
    """How an annealing goes.

    attempts    how many
    hot, cold   temperatures of the first and of the last attempt, in cost
    mean_out, longest   see `ruin_strings`; blink, regretful: see `put_back`
    promising   the routes of an attempt that costs at most so much more are remembered
    """

    attempts: int
    hot: float
    cold: float
    mean_out: float
    longest: float
    blink: float
    regretful: float
    promising: float


@kernel
def anneal(
    task: Task,
    plan: Plan,
    best: Plan,
    scratch: Scratch,
    undo: Undo,
    offers: InsertionOffers,
    pool: RoutePool,
    near: AnyArray,
    rng: AnyArray,
    how: Annealing,
) -> int:
    """Improve `plan` by attempts; `best` takes over every plan that costs less than it.

    Returns how many attempts were kept.
    """
    cost = total_cost(task, plan)
    best_cost = total_cost(task, best)
    kept = 0
    for attempt in range(how.attempts):
        temperature = how.hot * (how.cold / how.hot) ** (attempt / how.attempts) if how.hot > 0.0 else 0.0
        begin_attempt(task, plan, undo)
        ruin_strings(task, plan, scratch, undo, near, how.mean_out, how.longest, rng)
        put_back(task, plan, scratch, undo, offers, how.blink, how.regretful, rng)
        changed = _changed_cost(task, plan, undo)
        limit = -temperature * np.log(1.0 - uniform(rng)) if temperature > 0.0 else 0.0
        if changed < limit + how.promising:
            for k in range(undo.counts[0]):
                remember(task, pool, plan, undo.touched_list[k])
        if changed < limit:
            kept += 1
            cost += changed
            if cost < best_cost - _WORTH_S:
                best_cost = cost
                copy_plan(best, plan)
        else:
            take_back(plan, undo)
    return kept


@kernel
def begin_attempt(task: Task, plan: Plan, undo: Undo) -> None:
    """Forget the previous attempt; requests in no route, and with a cost of absence, are to be put back."""
    for k in range(undo.counts[0]):
        undo.touched[undo.touched_list[k]] = False
    undo.counts[0], undo.counts[1] = 0, 0
    for r in range(len(plan.vehicle_of)):
        if plan.vehicle_of[r] == ABSENT and task.absent_cost[r] > 0.0:
            undo.absent[undo.counts[1]] = r
            undo.home[undo.counts[1]] = ABSENT
            undo.counts[1] += 1


@kernel
def _changed_cost(task: Task, plan: Plan, undo: Undo) -> float:
    changed = 0.0
    for k in range(undo.counts[0]):
        v = undo.touched_list[k]
        changed += plan.cost[v] - undo.before.cost[v]
    for k in range(undo.counts[1]):
        r = undo.absent[k]
        if undo.home[k] == ABSENT:
            changed -= task.absent_cost[r]
        if plan.vehicle_of[r] == ABSENT:
            changed += task.absent_cost[r]
    return changed


@kernel
def take_back(plan: Plan, undo: Undo) -> None:
    """Make the plan what it was before the attempt."""
    for k in range(undo.counts[0]):
        copy_route(plan, undo.before, undo.touched_list[k])
    for k in range(undo.counts[1]):
        plan.vehicle_of[undo.absent[k]] = undo.home[k]
