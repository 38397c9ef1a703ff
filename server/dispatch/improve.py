"""Moving one request at a time to where it costs less; every promise stays a window."""

from collections.abc import Sequence

import numpy as np

from server.dispatch.insertion import Route, cheapest_insertion, evaluated, without_request
from server.dispatch.problem import Problem, VehicleState
from server.dispatch.schedule import Broken

_WORTH_S = 1.0


def improve(
    problem: Problem, routes: Sequence[Route], moves: int, rng: np.random.Generator
) -> tuple[list[Route], int]:
    """Routes of no higher cost, and how many moves were tried: at most `moves`.

    A move takes a request that is not aboard out of its route and inserts it at the cheapest place of all.
    """
    best = list(routes)
    movable = [
        (number, request_id)
        for number, (vehicle, route) in enumerate(zip(problem.vehicles, best, strict=True))
        for request_id in _movable(vehicle, route)
    ]
    if not movable:
        return best, 0
    home = {request_id: number for number, request_id in movable}
    names = [request_id for _, request_id in movable]
    for tried in range(moves):
        request_id = names[int(rng.integers(len(names)))]
        number = home[request_id]
        moved = _relocated(problem, best, number, request_id)
        if moved is not None:
            best, home[request_id] = moved
        if len(names) == 1:
            return best, tried + 1
    return best, moves


def _movable(vehicle: VehicleState, route: Route) -> list[str]:
    return [
        request_id
        for call in route.calls[vehicle.locked :]
        for request_id in call.board
        if not any(request_id in locked.alight for locked in route.calls[: vehicle.locked])
    ]


def _relocated(
    problem: Problem, routes: list[Route], number: int, request_id: str
) -> tuple[list[Route], int] | None:
    """The routes with the request elsewhere and its new vehicle's number; None where that is not cheaper."""
    vehicle = problem.vehicles[number]
    emptied = evaluated(problem, vehicle, without_request(routes[number].calls, request_id))
    if isinstance(emptied, Broken):
        return None
    trial = list(routes)
    trial[number] = emptied
    found = cheapest_insertion(problem, trial, problem.requests[request_id])
    if found is None:
        return None
    saved = routes[number].cost - emptied.cost
    if found.extra_cost > saved - _WORTH_S:
        return None
    trial[found.vehicle] = found.route
    return trial, found.vehicle
