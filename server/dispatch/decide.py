"""The answer to one request: the cheapest place in all routes, and the next best vehicle's."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from server.dispatch.arrays import AnyArray
from server.dispatch.engine.compiled import kernel
from server.dispatch.engine.draw import seeded
from server.dispatch.engine.insertion import best_place, insert, times_at
from server.dispatch.engine.plan import Plan, Scratch
from server.dispatch.engine.task import Task
from server.dispatch.problem import CUT_OFF_S, Request, Walk
from server.dispatch.schedule.schedule import Schedule

NO_OFFER = -1


@dataclass(frozen=True, slots=True)
class Offer:
    """Serving a request with a vehicle: pickup after position i of its route, drop-off after j.

    cost     more weighted seconds than without it, walking included
    request  with the stops and windows that the offer is for
    """

    vehicle: int
    i: int
    j: int
    cost: float
    request: Request


@dataclass(frozen=True, slots=True)
class Offers:
    """The cheapest offer, and the cheapest of any other vehicle; None where there is none."""

    best: Offer | None
    runner_up: Offer | None


def offers_for(schedule: Schedule, request_id: str) -> Offers:
    """What the fleet can offer a request that is in no route. The schedule stays unchanged."""
    r = schedule.rows[request_id]
    original = schedule.requests[r]
    choices = _choices(original) if original.pickup_walks or original.dropoff_walks else [(original, 0.0)]
    found: list[Offer] = []
    rows, costs = np.zeros((2, 3), np.int64), np.zeros(2)
    for request, walk_s in choices:
        if request is not original:
            schedule.write(r, request)
        walked = walk_s * request.party * schedule.problem.weights.walk
        _two_cheapest(
            schedule.task, schedule.plan, schedule.scratch, schedule.accepts, r, _NO_DRAWS, rows, costs
        )
        found += [
            Offer(int(v), int(i), int(j), float(cost) + walked, request)
            for (v, i, j), cost in zip(rows, costs, strict=True)
            if v != NO_OFFER
        ]
    if len(choices) > 1:
        schedule.write(r, original)
    found.sort(key=lambda offer: offer.cost)
    others = (offer for offer in found if offer.vehicle != found[0].vehicle)
    return Offers(found[0] if found else None, next(others, None))


def take(schedule: Schedule, offer: Offer) -> None:
    """Insert the request where it was offered. The schedule must not have changed since."""
    r = schedule.rows[offer.request.request_id]
    if schedule.requests[r] is not offer.request:
        schedule.write(r, offer.request)
    insert(schedule.task, schedule.plan, schedule.scratch, offer.vehicle, r, offer.i, offer.j)


def earliest_quotes(
    schedule: Schedule, request: Request, tries: Sequence[tuple[int, int, float, float, float]]
) -> list[tuple[float, float]]:
    """Pickup and arrival of a request in each of several ways, where an early pickup counts most.

    The schedule stays unchanged; the request is not in it.
    tries  pickup place, drop-off place, pickup from, pickup to, arrival by. Infinite where no vehicle can.
    """
    ways, quotes = np.array(tries).reshape(-1, 5), np.zeros((len(tries), 2))
    ways[:, 2:] -= schedule.origin_s
    ways[:, 4] = np.minimum(ways[:, 4], 0.5 * CUT_OFF_S)
    r = schedule.add(request)
    schedule.task.delay_cost[2 * r] *= _URGENT
    rows, costs = np.zeros((2, 3), np.int64), np.zeros(2)
    _earliest(
        schedule.task,
        schedule.plan,
        schedule.scratch,
        schedule.accepts,
        r,
        ways,
        quotes,
        _NO_DRAWS,
        rows,
        costs,
    )
    schedule.remove(request.request_id)
    quotes += schedule.origin_s
    return [(float(pickup_s), float(arrival_s)) for pickup_s, arrival_s in quotes]


def quoted_times(schedule: Schedule, offer: Offer) -> tuple[float, float]:
    """Pickup and arrival if the offer were taken."""
    r = schedule.rows[offer.request.request_id]
    if schedule.requests[r] is not offer.request:
        schedule.write(r, offer.request)
    at_s = times_at(schedule.task, schedule.plan, schedule.scratch, offer.vehicle, r, offer.i, offer.j)
    return at_s[0] + schedule.origin_s, at_s[1] + schedule.origin_s


def _choices(request: Request) -> list[tuple[Request, float]]:
    """The request at every possible pair of stops, and the seconds on foot in all."""
    plain = replace(request, pickup_walks=(), dropoff_walks=())
    return [
        (
            replace(
                plain,
                pickup=up.place,
                dropoff=down.place,
                pickup_from_s=request.pickup_from_s + up.walk_s,
                pickup_to_s=request.pickup_to_s + up.walk_s,
                arrive_by_s=request.arrive_by_s - down.walk_s,
            ),
            up.walk_s + down.walk_s,
        )
        for up in (Walk(request.pickup, 0.0), *request.pickup_walks)
        for down in (Walk(request.dropoff, 0.0), *request.dropoff_walks)
        if up.place != down.place
    ]


_URGENT = 1000.0
# Without blinks nothing is drawn, but the kernel needs a generator.
_NO_DRAWS = seeded(0)


@kernel
def _two_cheapest(
    task: Task,
    plan: Plan,
    scratch: Scratch,
    accepts: AnyArray,
    r: int,
    rng: AnyArray,
    rows: AnyArray,
    costs: AnyArray,
) -> None:
    """Fill (2, 3) rows with vehicle, i, j and (2,) costs with the extra cost of the two vehicles that serve r
    most cheaply; NO_OFFER and inf where there are fewer."""
    for k in range(2):
        rows[k, 0], costs[k] = NO_OFFER, np.inf
    for v in range(len(plan.length)):
        if not accepts[v]:
            continue
        cost, i, j = best_place(task, plan, scratch, v, r, costs[1], 0.0, rng)
        if cost < costs[0]:
            costs[1] = costs[0]
            for column in range(3):
                rows[1, column] = rows[0, column]
            costs[0] = cost
            rows[0, 0], rows[0, 1], rows[0, 2] = v, i, j
        elif cost < costs[1]:
            costs[1] = cost
            rows[1, 0], rows[1, 1], rows[1, 2] = v, i, j


@kernel
def _earliest(
    task: Task,
    plan: Plan,
    scratch: Scratch,
    accepts: AnyArray,
    r: int,
    ways: AnyArray,
    quotes: AnyArray,
    rng: AnyArray,
    rows: AnyArray,
    costs: AnyArray,
) -> None:
    """Fill (K, 2) quotes for (K, 5) ways: places, pickup from and to, arrival by."""
    p, d = 2 * r, 2 * r + 1
    not_before = task.early_s[d]
    for k in range(len(ways)):
        task.place[p], task.place[d] = int(ways[k, 0]), int(ways[k, 1])
        task.early_s[p], task.late_s[p] = ways[k, 2], ways[k, 3]
        task.early_s[d], task.late_s[d] = max(not_before, ways[k, 2]), ways[k, 4]
        _two_cheapest(task, plan, scratch, accepts, r, rng, rows, costs)
        quotes[k] = np.inf
        if rows[0, 0] != NO_OFFER:
            pickup_s, arrival_s = times_at(task, plan, scratch, rows[0, 0], r, rows[0, 1], rows[0, 2])
            quotes[k, 0], quotes[k, 1] = pickup_s, arrival_s
