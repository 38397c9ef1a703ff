"""Where a party may be let out on the route of its vehicle, and the cheapest of these routes."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from contract.geometry import Array
from server.dispatch.problem import Call, Problem, Request, VehicleRoute, VehicleState
from server.dispatch.schedule.schedule import Schedule

# How many of the soonest stops are tried for a rider who wants to get off.
_EXITS_TRIED = 6
# Differences below this do not count as later.
_LATER_S = 1.0


def without_drop_off(vehicle: VehicleState, request_id: str) -> tuple[Call, ...]:
    """The vehicle's calls without this drop-off; a call that was only for it is left out."""
    kept = []
    for number, call in enumerate(vehicle.calls):
        if request_id not in call.alight:
            kept.append(call)
            continue
        rest = replace(call, alight=tuple(other for other in call.alight if other != request_id))
        if rest.board or rest.alight or rest.fixed or number < vehicle.locked:
            kept.append(rest)
    return tuple(kept)


def first_index(vehicle: VehicleState, calls: Sequence[Call], request_id: str) -> int:
    """The first of the calls before which the party may be let out: not before it has boarded."""
    return max([vehicle.locked, *(n + 1 for n, call in enumerate(calls) if request_id in call.board)])


def exits(times: Array, vehicle: VehicleState, request_id: str) -> list[tuple[int, int]]:
    """Where the party could be let out, the soonest first: the place, and the call before which.

    times  (P, P) seconds from place to place
    """
    calls = without_drop_off(vehicle, request_id)
    index = first_index(vehicle, calls, request_id)
    origin = calls[index - 1].place if index else None
    row: Array = vehicle.to_places_s if origin is None else times[origin]
    reached = [int(place) for place in np.argsort(row, kind="stable") if np.isfinite(row[place])]
    soonest = [place for place in reached if place != origin][:_EXITS_TRIED]
    return [*((place, index) for place in soonest), *((calls[n].place, n) for n in range(index, len(calls)))]


def cheapest_with_drop_off(
    problem: Problem, vehicle: VehicleState, wanted: Request, out: Call, only_before: int | None = None
) -> VehicleRoute | None:
    """The vehicle's cheapest route with another drop-off of a party; None if no route keeps every promise.

    problem      as planned so far
    wanted, out  the party with its new drop-off, and the call that lets it out
    only_before  the one call before which it gets out, among those without its present drop-off; None for
                 wherever that is cheapest
    """
    before = Schedule(replace(problem, vehicles=(vehicle,), open_requests=()))
    requests = problem.requests | {wanted.request_id: wanted}
    calls = without_drop_off(vehicle, wanted.request_id)
    first = first_index(vehicle, calls, wanted.request_id)
    indices = range(first, len(calls) + 1) if only_before is None else (only_before,)
    made: list[Schedule] = []
    for route in _routes(calls, out, indices):
        changed = replace(vehicle, calls=route)
        schedule = Schedule(replace(problem, vehicles=(changed,), requests=requests, open_requests=()))
        if _keeps_promises(schedule, before, wanted.request_id):
            made.append(schedule)
    return min(made, key=lambda schedule: schedule.cost).route(0) if made else None


def _routes(calls: tuple[Call, ...], out: Call, indices: Sequence[int]) -> Iterator[tuple[Call, ...]]:
    """The calls with the party let out at one there is already, and at a new one before each index."""
    for index in indices:
        here = calls[index] if index < len(calls) else out
        if here is not out and here.place == out.place and not here.off_duty:
            together = replace(here, alight=(*here.alight, *out.alight))
            yield (*calls[:index], together, *calls[index + 1 :])
        yield (*calls[:index], out, *calls[index:])


def _keeps_promises(schedule: Schedule, before: Schedule, request_id: str) -> bool:
    """The route breaks no promise that was kept so far, and delays no other ride that is late already."""
    if schedule.impossible or schedule.overdue - before.overdue:
        return False
    # A vehicle that ends its shift late is overdue without a name.
    late = [name for name in schedule.overdue if name in before.rows and name != request_id]
    return all(schedule.arrival_s(name) <= before.arrival_s(name) + _LATER_S for name in late)
