"""The dispatcher's rules written down a second time, plainly and slowly, for the engine to be held against.

When a vehicle makes its calls, or which rule its route breaks: exact, and as early as possible.

The unknowns are the times of leaving. Every rule is a lower bound of one of them by another (drive and
dwell, windows, longest ride) or a fixed upper bound, so the earliest schedule is the least solution of a
system of difference constraints. Forward passes raise the times until nothing moves; a route of n calls
that still moves after n + 1 passes has none (Bellman 1958). Delaying a departure so that nobody sits too
long in a waiting shuttle falls out of this by itself.
"""

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

from server.dispatch.problem import Call, CallTime, Problem, Request, VehicleState

Rule = Literal["seats", "wheelchair", "order", "pickup_window", "arrival", "departure", "ride_time"]
_EPSILON_S = 1e-6


@dataclass(frozen=True, slots=True)
class Broken:
    """The first rule that a route breaks, and whose: a request id, or the call_id for `departure`."""

    rule: Rule
    whose: str


def schedule(problem: Problem, vehicle: VehicleState, calls: Sequence[Call]) -> tuple[CallTime, ...] | Broken:
    """The earliest times of a route's calls, or the rule it breaks.

    Windows: a pickup's arrival is at most pickup_to_s, and the vehicle
    does not leave before pickup_from_s plus the dwell; an arrival is at most arrive_by_s.
    """
    requests = problem.requests
    broken = _overload(vehicle, calls, requests)
    if broken is not None:
        return broken
    times = _earliest(problem, vehicle, calls, [float("-inf")] * len(calls))
    boarded_at = _boarded_at(calls)
    for _ in range(len(calls) + 1):
        late = _late(calls, requests, times)
        if late is not None:
            return late
        bounds = _ride_time_bounds(calls, requests, boarded_at, times)
        if bounds is None:
            return times
        if isinstance(bounds, Broken):
            return bounds
        times = _earliest(problem, vehicle, calls, bounds)
    return Broken("ride_time", _longest_ride(calls, requests, boarded_at, times))


def _overload(vehicle: VehicleState, calls: Sequence[Call], requests: Mapping[str, Request]) -> Broken | None:
    inside = set(vehicle.aboard)
    seats = sum(requests[request_id].party for request_id in vehicle.aboard)
    wheelchairs = sum(requests[request_id].wheelchairs for request_id in vehicle.aboard)
    for call in calls:
        for request_id in call.alight:
            if request_id not in inside:
                return Broken("order", request_id)
            inside.remove(request_id)
            seats -= requests[request_id].party
            wheelchairs -= requests[request_id].wheelchairs
        for request_id in call.board:
            inside.add(request_id)
            seats += requests[request_id].party
            wheelchairs += requests[request_id].wheelchairs
            if seats > vehicle.seats:
                return Broken("seats", request_id)
            if wheelchairs > vehicle.wheelchair_places:
                return Broken("wheelchair", request_id)
    return Broken("order", min(inside)) if inside else None


def _earliest(
    problem: Problem, vehicle: VehicleState, calls: Sequence[Call], bounds: Sequence[float]
) -> tuple[CallTime, ...]:
    """One forward pass; bounds[i] is a further lower bound of leaving call i."""
    times = []
    row, clock_s = vehicle.to_places_s, vehicle.ready_s
    for call, bound_s in zip(calls, bounds, strict=True):
        arrive_s = clock_s + float(row[call.place]) * call.travel_time_factor
        clock_s = max(arrive_s + call.dwell_s, call.leave_from_s, bound_s)
        for request_id in call.board:
            clock_s = max(clock_s, problem.requests[request_id].pickup_from_s + call.dwell_s)
        times.append(CallTime(arrive_s, clock_s))
        row = problem.times[call.place]
    return tuple(times)


def _late(calls: Sequence[Call], requests: Mapping[str, Request], times: Sequence[CallTime]) -> Broken | None:
    for call, time in zip(calls, times, strict=True):
        if time.arrive_s > call.arrive_by_s + _EPSILON_S:
            return Broken("departure", call.call_id)
        for request_id in call.board:
            if time.arrive_s > requests[request_id].pickup_to_s + _EPSILON_S:
                return Broken("pickup_window", request_id)
        for request_id in call.alight:
            if time.arrive_s > requests[request_id].arrive_by_s + _EPSILON_S:
                return Broken("arrival", request_id)
    return None


def _boarded_at(calls: Sequence[Call]) -> dict[str, int]:
    return {request_id: i for i, call in enumerate(calls) for request_id in call.board}


def _ride_time_bounds(
    calls: Sequence[Call],
    requests: Mapping[str, Request],
    boarded_at: Mapping[str, int],
    times: Sequence[CallTime],
) -> list[float] | Broken | None:
    """How late each call must be left at least so that nobody rides too long; None when all is well."""
    bounds = [time.leave_s for time in times]
    moved = False
    for j, call in enumerate(calls):
        for request_id in call.alight:
            i = boarded_at.get(request_id)
            if i is None:
                continue
            least_s = times[j].arrive_s - requests[request_id].ride_s_max
            if least_s > times[i].leave_s + _EPSILON_S:
                # Boarding begins inside the window, however late the shuttle may leave.
                latest_s = requests[request_id].pickup_to_s + calls[i].dwell_s
                if i == j - 1 or least_s > latest_s + _EPSILON_S:
                    return Broken("ride_time", request_id)
                bounds[i] = max(bounds[i], least_s)
                moved = True
    return bounds if moved else None


def _longest_ride(
    calls: Sequence[Call],
    requests: Mapping[str, Request],
    boarded_at: Mapping[str, int],
    times: Sequence[CallTime],
) -> str:
    """Whose ride is longest compared with what it may be."""
    excess = {
        request_id: times[j].arrive_s
        - times[boarded_at[request_id]].leave_s
        - requests[request_id].ride_s_max
        for j, call in enumerate(calls)
        for request_id in call.alight
        if request_id in boarded_at
    }
    return max(sorted(excess), key=lambda request_id: excess[request_id])


def route_cost(
    problem: Problem, vehicle: VehicleState, calls: Sequence[Call], times: Sequence[CallTime]
) -> float:
    """Weighted seconds. Waiting counts from the start of a party's window to its pickup, riding from there
    to its arrival; who is aboard already rides from the snapshot on."""
    weights, requests = problem.weights, problem.requests
    drive_s = wait_s = ride_s = late_s = 0.0
    row = vehicle.to_places_s
    picked_up = dict.fromkeys(vehicle.aboard, vehicle.ready_s)
    for call, time in zip(calls, times, strict=True):
        drive_s += float(row[call.place]) * call.travel_time_factor
        row = problem.times[call.place]
        if math.isfinite(call.leave_from_s):
            late_s += max(0.0, time.leave_s - call.leave_from_s)
        for request_id in call.board:
            request = requests[request_id]
            picked_up[request_id] = max(time.arrive_s, request.pickup_from_s)
            wait_s += request.party * (picked_up[request_id] - request.pickup_from_s)
        for request_id in call.alight:
            ride_s += requests[request_id].party * (time.arrive_s - picked_up[request_id])
    cost = weights.drive * drive_s + weights.wait * wait_s + weights.ride * ride_s
    return cost + weights.late * late_s


def every_insertion(calls: Sequence[Call], request: Request, dwell_s: float) -> Iterator[tuple[Call, ...]]:
    """By brute force: both new calls anywhere in order, then any of them merged into an equal neighbour."""
    pickup = Call(
        request.pickup, (request.request_id,), (), dwell_s, travel_time_factor=request.travel_time_factor
    )
    dropoff = Call(
        request.dropoff, (), (request.request_id,), dwell_s, travel_time_factor=request.travel_time_factor
    )
    for i, j in itertools.combinations_with_replacement(range(len(calls) + 1), 2):
        whole = [*calls[:i], pickup, *calls[i:j], dropoff, *calls[j:]]
        for joins in ((), (j + 1,), (i,), (i, j + 1)):
            trial: list[Call] | None = list(whole)
            for index in sorted(joins, reverse=True):
                trial = _joined(trial, index) if trial is not None else None
            if trial is not None:
                yield tuple(trial)


def _joined(calls: list[Call], index: int) -> list[Call] | None:
    if index + 1 >= len(calls) or calls[index].place != calls[index + 1].place:
        return None
    one, two = calls[index], calls[index + 1]
    both = replace(
        two,
        board=two.board + one.board,
        alight=two.alight + one.alight,
        dwell_s=max(one.dwell_s, two.dwell_s),
        travel_time_factor=one.travel_time_factor,
    )
    return [*calls[:index], both, *calls[index + 2 :]]
