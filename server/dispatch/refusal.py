"""Why a request cannot be carried: the rule that binds, in one word."""

import math
from collections.abc import Sequence

from server.dispatch.insertion import Route
from server.dispatch.problem import Call, Problem, Request
from server.dispatch.schedule import Broken, schedule


def binding_rule(problem: Problem, routes: Sequence[Route], request: Request) -> str:
    """no_vehicle_free | seats | wheelchair | pickup_window | ride_time | arrival.

    The vehicle that would be there first after everything it has promised is asked what keeps it from
    serving the request then; nobody else's promise can be in its way.
    """
    accepting = [(v, r) for v, r in zip(problem.vehicles, routes, strict=True) if v.accepts]
    if not accepting:
        return "no_vehicle_free"
    if all(vehicle.seats < request.party for vehicle, _ in accepting):
        return "seats"
    fitting = [(v, r) for v, r in accepting if v.seats >= request.party]
    if all(vehicle.wheelchair_places < request.wheelchairs for vehicle, _ in fitting):
        return "wheelchair"
    fitting = [(v, r) for v, r in fitting if v.wheelchair_places >= request.wheelchairs]
    best_s, rule = math.inf, "no_vehicle_free"
    for vehicle, route in fitting:
        place = route.calls[-1].place if route.calls else vehicle.start
        free_s = route.times[-1].leave_s if route.times else vehicle.ready_s
        there_s = free_s + float(vehicle.times[place, request.pickup])
        if there_s < best_s:
            calls = (
                *route.calls,
                Call(request.pickup, (request.request_id,), (), problem.dwell_s),
                Call(request.dropoff, (), (request.request_id,), problem.dwell_s),
            )
            broken = schedule(vehicle, calls, problem.requests)
            best_s, rule = there_s, broken.rule if isinstance(broken, Broken) else "no_vehicle_free"
    return rule
