"""Putting absent requests back: one after the other in some order, or whoever would lose most by waiting
first."""

from typing import NamedTuple

import numpy as np

from server.dispatch.arrays import AnyArray
from server.dispatch.engine.compiled import kernel
from server.dispatch.engine.draw import below, shuffle, uniform
from server.dispatch.engine.insertion import best_place, insert
from server.dispatch.engine.plan import ABSENT, Plan, Scratch
from server.dispatch.engine.ruin import Undo, touch
from server.dispatch.engine.task import LOAD_KINDS, Task, drive_s

# Orders of insertion and their shares (Christiaens and Vanden Berghe 2020, section 5.4, for pickup and
# delivery).
_ORDERS = np.array([0, 0, 0, 0, 1, 1, 2, 3, 3, 4, 4])


class Offers(NamedTuple):
    """What was found of serving a request with a vehicle, valid while the vehicle's route is the same.

    stamp  (R, V) the route's stamp at that time; cost (R, V) extra cost, inf for none; at (R, V, 2) positions
    """

    stamp: AnyArray
    cost: AnyArray
    at: AnyArray


def no_offers(task: Task) -> Offers:
    shape = (task.requests, task.vehicles)
    return Offers(np.full(shape, -1, np.int64), np.zeros(shape), np.zeros((*shape, 2), np.int32))


@kernel
def offer(task: Task, plan: Plan, scratch: Scratch, offers: Offers, r: int, v: int, rng: AnyArray) -> float:
    """Least extra cost of serving r with vehicle v."""
    if offers.stamp[r, v] != plan.stamp[v]:
        cost, i, j = best_place(task, plan, scratch, v, r, np.inf, 0.0, rng)
        offers.stamp[r, v] = plan.stamp[v]
        offers.cost[r, v] = cost
        offers.at[r, v, 0], offers.at[r, v, 1] = i, j
    return float(offers.cost[r, v])


@kernel
def put_back(
    task: Task,
    plan: Plan,
    scratch: Scratch,
    undo: Undo,
    offers: Offers,
    blink: float,
    regretful: float,
    rng: AnyArray,
) -> None:
    """Insert every absent request that fits anywhere.

    blink      chance to overlook a vehicle
    regretful  chance to go by regret
    """
    if uniform(rng) < regretful:
        _by_regret(task, plan, scratch, undo, offers, blink, rng)
    else:
        _in_order(task, plan, scratch, undo, offers, blink, rng)


@kernel
def _in_order(
    task: Task, plan: Plan, scratch: Scratch, undo: Undo, offers: Offers, blink: float, rng: AnyArray
) -> None:
    n = undo.counts[1]
    _set_order(task, undo, rng)
    for k in range(n):
        r = undo.absent[undo.order[k]]
        best, found = task.absent_cost[r], ABSENT
        for v in range(len(plan.length)):
            cost = offer(task, plan, scratch, offers, r, v, rng)
            if cost < best and uniform(rng) >= blink:
                best, found = cost, v
        if found != ABSENT:
            touch(plan, undo, found)
            insert(task, plan, scratch, found, r, offers.at[r, found, 0], offers.at[r, found, 1])


@kernel
def _by_regret(
    task: Task, plan: Plan, scratch: Scratch, undo: Undo, offers: Offers, noise: float, rng: AnyArray
) -> None:
    """Next comes who would lose most if its best vehicle were gone (Potvin and Rousseau 1993)."""
    n = undo.counts[1]
    waiting = undo.order
    for k in range(n):
        waiting[k] = 1
    for _ in range(n):
        chosen, chosen_v, most = -1, ABSENT, -np.inf
        for k in range(n):
            if waiting[k] == 0:
                continue
            r = undo.absent[k]
            best, second, best_v = task.absent_cost[r], task.absent_cost[r], ABSENT
            for v in range(len(plan.length)):
                cost = offer(task, plan, scratch, offers, r, v, rng)
                if cost < best:
                    best, second, best_v = cost, best, v
                elif cost < second:
                    second = cost
            if best_v != ABSENT:
                regret = (second - best) * (1.0 + 0.3 * uniform(rng))
                if regret > most:
                    chosen, chosen_v, most = k, best_v, regret
        if chosen < 0:
            return
        waiting[chosen] = 0
        r = undo.absent[chosen]
        touch(plan, undo, chosen_v)
        insert(task, plan, scratch, chosen_v, r, offers.at[r, chosen_v, 0], offers.at[r, chosen_v, 1])


@kernel
def _set_order(task: Task, undo: Undo, rng: AnyArray) -> None:
    """Fill undo.order with the positions in undo.absent in one of several orders, drawn at random."""
    n, places, key = undo.counts[1], undo.order, undo.key
    for k in range(n):
        places[k] = k
    shuffle(rng, places, n)
    how = _ORDERS[below(rng, len(_ORDERS))]
    if how == 0:
        return
    for k in range(n):
        p, d = 2 * undo.absent[k], 2 * undo.absent[k] + 1
        if how == 1:
            key[k] = -drive_s(task, p, d)
        elif how == 2:
            key[k] = 0.0
            for kind in range(LOAD_KINDS):
                key[k] -= task.load[p, kind]
        elif how == 3:
            key[k] = task.late_s[p] - task.early_s[p] + task.late_s[d] - task.early_s[d]
        else:
            key[k] = task.late_s[p]
    # Few at a time: insertion sort, which keeps equals in their drawn order.
    for k in range(1, n):
        place = places[k]
        at = k
        while at > 0 and key[places[at - 1]] > key[place]:
            places[at] = places[at - 1]
            at -= 1
        places[at] = place
