"""Windows that cannot be kept any more, moved to what still can: a late ride is never made later."""

import math
from dataclasses import replace

from server.dispatch.problem import Problem, Request, VehicleState
from server.dispatch.schedule import Broken, CallTime, schedule


def loosened(problem: Problem) -> Problem:
    """The same problem with every vehicle's present route feasible in time.

    A window that the present route misses ends where that route makes it. Seats and order are not loosened.
    """
    requests = dict(problem.requests)
    vehicles = []
    for vehicle in problem.vehicles:
        times = _unhurried(vehicle, requests)
        if times is None:
            vehicles.append(vehicle)
            continue
        calls = tuple(
            replace(call, arrive_by_s=max(call.arrive_by_s, time.arrive_s))
            for call, time in zip(vehicle.calls, times, strict=True)
        )
        left = {}
        for call, time in zip(calls, times, strict=True):
            for request_id in call.board:
                request = requests[request_id]
                left[request_id] = time.leave_s
                requests[request_id] = replace(request, pickup_to_s=max(request.pickup_to_s, time.arrive_s))
            for request_id in call.alight:
                requests[request_id] = _still_arriving(requests[request_id], time, left.get(request_id))
        vehicles.append(replace(vehicle, calls=calls))
    return replace(problem, vehicles=tuple(vehicles), requests=requests)


def possible(problem: Problem) -> Problem:
    """The same problem without the vehicles whose present route cannot be driven at all.

    That is one which has more people aboard or waiting than seats, because its word crossed with a decision.
    """
    kept = (
        vehicle
        for vehicle in problem.vehicles
        if not isinstance(schedule(vehicle, vehicle.calls, problem.requests), Broken)
    )
    return replace(problem, vehicles=tuple(kept))


def _unhurried(vehicle: VehicleState, requests: dict[str, Request]) -> tuple[CallTime, ...] | None:
    """The present route's earliest times when nothing has a deadline; None when it is impossible even so."""
    patient = {
        request_id: replace(request, pickup_to_s=math.inf, arrive_by_s=math.inf, ride_s_max=math.inf)
        for request_id, request in requests.items()
    }
    calls = [replace(call, arrive_by_s=math.inf) for call in vehicle.calls]
    times = schedule(vehicle, calls, patient)
    return None if isinstance(times, Broken) else times


def _still_arriving(request: Request, time: CallTime, left_s: float | None) -> Request:
    ride_s = 0.0 if left_s is None else time.arrive_s - left_s
    return replace(
        request,
        arrive_by_s=max(request.arrive_by_s, time.arrive_s),
        ride_s_max=max(request.ride_s_max, ride_s),
    )
