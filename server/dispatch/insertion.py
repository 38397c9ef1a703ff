"""The cheapest place for a new request, or for a timetable departure, in the routes that there are.

What is in a route keeps its order, and every promise made is a window of the schedule: an insertion that
would break one is no candidate (Jaw, Odoni, Psaraftis, Wilson 1986).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from server.dispatch.cost import route_cost
from server.dispatch.problem import Call, Chain, Problem, Request, VehicleState
from server.dispatch.schedule import Broken, CallTime, schedule

Calls = tuple[Call, ...]


@dataclass(frozen=True, slots=True)
class Route:
    """A vehicle's calls with their times and cost."""

    calls: Calls
    times: tuple[CallTime, ...]
    cost: float


@dataclass(frozen=True, slots=True)
class Insertion:
    """The route that a vehicle would have, and what it costs more than before."""

    vehicle: int
    route: Route
    extra_cost: float


def evaluated(problem: Problem, vehicle: VehicleState, calls: Calls) -> Route | Broken:
    """The route's times and cost, or the rule it breaks."""
    times = schedule(vehicle, calls, problem.requests)
    if isinstance(times, Broken):
        return times
    return Route(calls, times, route_cost(vehicle, calls, times, problem.requests, problem.weights))


def cheapest_insertion(problem: Problem, routes: Sequence[Route], request: Request) -> Insertion | None:
    """The feasible insertion with the least extra cost over all vehicles and positions, the first of equals.

    routes  one for each of the problem's vehicles, in their order
    """
    best: Insertion | None = None
    for number, (vehicle, present) in enumerate(zip(problem.vehicles, routes, strict=True)):
        if not vehicle.accepts:
            continue
        for calls in candidates(vehicle, present.calls, request, problem.dwell_s):
            route = evaluated(problem, vehicle, calls)
            if isinstance(route, Broken):
                continue
            extra_cost = route.cost - present.cost
            if best is None or extra_cost < best.extra_cost:
                best = Insertion(number, route, extra_cost)
    return best


def candidates(vehicle: VehicleState, calls: Calls, request: Request, dwell_s: float) -> Iterator[Calls]:
    """Every way to serve the request in this route: at a call that is there, or at a new one."""
    for at, boarded in _with_stop(calls, request.pickup, vehicle.locked, request.request_id, (), dwell_s):
        for _, served in _with_stop(boarded, request.dropoff, at + 1, "", (request.request_id,), dwell_s):
            yield served


def _with_stop(
    calls: Calls, place: int, first: int, board: str, alight: tuple[str, ...], dwell_s: float
) -> Iterator[tuple[int, Calls]]:
    """(index of the stop, calls with it) for joining a call at the place, or a new call, from `first` on."""
    boarding = (board,) if board else ()
    for i in range(first, len(calls) + 1):
        if i < len(calls) and calls[i].place == place:
            joined = replace(
                calls[i],
                board=calls[i].board + boarding,
                alight=calls[i].alight + alight,
                dwell_s=max(calls[i].dwell_s, dwell_s),
            )
            yield i, (*calls[:i], joined, *calls[i + 1 :])
        new = Call(place, boarding, alight, dwell_s)
        yield i, (*calls[:i], new, *calls[i:])


def cheapest_chain(problem: Problem, routes: Sequence[Route], chain: Chain) -> Insertion | None:
    """A cheap feasible insertion of a departure's calls into one vehicle's route, the first of equals.

    Every position of the first call is tried; each further call takes the cheapest one after it.
    """
    best: Insertion | None = None
    for number, (vehicle, present) in enumerate(zip(problem.vehicles, routes, strict=True)):
        if not vehicle.accepts:
            continue
        for first in range(vehicle.locked, len(present.calls) + 1):
            route = _chained(problem, vehicle, present, chain.calls, first)
            if route is not None and (best is None or route.cost - present.cost < best.extra_cost):
                best = Insertion(number, route, route.cost - present.cost)
    return best


def _chained(
    problem: Problem, vehicle: VehicleState, present: Route, chain: Calls, first: int
) -> Route | None:
    route, positions = present, [first]
    for call in chain:
        found: tuple[Route, int] | None = None
        for i in positions:
            longer = evaluated(problem, vehicle, (*route.calls[:i], call, *route.calls[i:]))
            if not isinstance(longer, Broken) and (found is None or longer.cost < found[0].cost):
                found = longer, i
        if found is None:
            return None
        route = found[0]
        positions = list(range(found[1] + 1, len(route.calls) + 1))
    return route


def without_request(calls: Calls, request_id: str) -> Calls:
    """The calls without this request; a call that nobody needs any more is left out, unless it is fixed."""
    left = (
        replace(
            call,
            board=tuple(other for other in call.board if other != request_id),
            alight=tuple(other for other in call.alight if other != request_id),
        )
        if request_id in call.board or request_id in call.alight
        else call
        for call in calls
    )
    return tuple(
        after
        for before, after in zip(calls, left, strict=True)
        if after is before or after.fixed or after.board or after.alight
    )
