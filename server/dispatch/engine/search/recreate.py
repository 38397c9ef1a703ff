"""Puts absent requests back: one after the other in some order, or by regret."""

from typing import NamedTuple

import numpy as np
from numba import uint64

from server.dispatch.arrays import AnyArray
from server.dispatch.engine.compiled import inlined, kernel
from server.dispatch.engine.draw import below, bits, seeded, shuffle, uniform
from server.dispatch.engine.insertion import best_place, insert
from server.dispatch.engine.plan import ABSENT, Plan, Scratch
from server.dispatch.engine.search.ruin import Undo, touch
from server.dispatch.engine.task import LOAD_KINDS, Task, drive_s

# Orders of insertion and their shares (Christiaens and Vanden Berghe 2020, section 5.4, for pickup and
# delivery).
_ORDERS = np.array([0, 0, 0, 0, 1, 1, 2, 3, 3, 4, 4])

# Written as `int(...)`: numba compiles a callee once more for each constant that a variable begins with.
_NOWHERE = 0
_OFFERS = 1 << 16
_MARKS_SEED = 0x0FFE


class InsertionOffers(NamedTuple):
    """Insertion offers for the routes that were met lately: attempts meet the same routes
    again and again. Arrays (H,), H a power of two; an entry gives way to the next at its place.

    marks  (R,) uint64
    key    of the route's stamp and the request
    cost   extra cost, inf where there is no place that costs less than `below`
    at     (H, 2) positions
    """

    marks: AnyArray
    key: AnyArray
    cost: AnyArray
    below: AnyArray
    at: AnyArray


def no_offers(task: Task) -> InsertionOffers:
    state = seeded(_MARKS_SEED)
    return InsertionOffers(
        marks=np.array([bits(state) for _ in range(task.requests)], dtype=np.uint64),
        key=np.zeros(_OFFERS, np.uint64),
        cost=np.zeros(_OFFERS),
        below=np.zeros(_OFFERS),
        at=np.zeros((_OFFERS, 2), np.int32),
    )


@inlined
def offer(
    task: Task,
    plan: Plan,
    scratch: Scratch,
    offers: InsertionOffers,
    r: int,
    v: int,
    below: float,
    rng: AnyArray,
) -> tuple[float, int, int]:
    """(extra cost, i, j) of serving r with vehicle v, see `best_place`; cost is inf where it is not less than
    `below`."""
    key = plan.stamp[v] ^ offers.marks[r]
    place = np.int64(key & uint64(len(offers.key) - 1))
    cost = offers.cost[place]
    if offers.key[place] == key and (cost < np.inf or offers.below[place] >= below):
        return cost, offers.at[place, 0], offers.at[place, 1]
    cost, i, j = best_place(task, plan, scratch, v, r, below, 0.0, rng)
    offers.key[place], offers.cost[place], offers.below[place] = key, cost, below
    offers.at[place, 0], offers.at[place, 1] = i, j
    return cost, i, j


@kernel
def put_back(
    task: Task,
    plan: Plan,
    scratch: Scratch,
    undo: Undo,
    offers: InsertionOffers,
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
    task: Task, plan: Plan, scratch: Scratch, undo: Undo, offers: InsertionOffers, blink: float, rng: AnyArray
) -> None:
    n, vehicles = undo.counts[1], len(plan.length)
    _set_order(task, undo, rng)
    for k in range(n):
        r = undo.absent[undo.order[k]]
        best, found, best_i, best_j = task.absent_cost[r], int(ABSENT), int(_NOWHERE), int(_NOWHERE)
        home = max(undo.home[undo.order[k]], 0)
        for turn in range(vehicles):
            # The previous vehicle is tried first: the others must then be better than a good offer.
            v = home + turn if home + turn < vehicles else home + turn - vehicles
            cost, i, j = offer(task, plan, scratch, offers, r, v, best, rng)
            if cost < best and uniform(rng) >= blink:
                best, found, best_i, best_j = cost, v, i, j
        if found != ABSENT:
            touch(plan, undo, found)
            insert(task, plan, scratch, found, r, best_i, best_j)


@kernel
def _by_regret(
    task: Task, plan: Plan, scratch: Scratch, undo: Undo, offers: InsertionOffers, noise: float, rng: AnyArray
) -> None:
    """Next is the request that loses most without its best vehicle (Potvin and Rousseau 1993)."""
    n, vehicles = undo.counts[1], len(plan.length)
    waiting = undo.order
    for k in range(n):
        waiting[k] = 1
    for _ in range(n):
        chosen, chosen_v, most = int(ABSENT), int(ABSENT), -np.inf
        for k in range(n):
            if waiting[k] == 0:
                continue
            r = undo.absent[k]
            best, second, best_v = task.absent_cost[r], task.absent_cost[r], int(ABSENT)
            home = max(undo.home[k], 0)
            for turn in range(vehicles):
                v = home + turn if home + turn < vehicles else home + turn - vehicles
                cost, _, _ = offer(task, plan, scratch, offers, r, v, second, rng)
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
        _, i, j = offer(task, plan, scratch, offers, r, chosen_v, np.inf, rng)
        insert(task, plan, scratch, chosen_v, r, i, j)


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
