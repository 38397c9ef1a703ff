"""The dispatcher's door: a snapshot in, routes out. The same problem, budget and rng give the same answer."""

from dataclasses import dataclass

import numpy as np

from server.dispatch.improve import improve
from server.dispatch.insertion import Route, cheapest_chain, cheapest_insertion, evaluated
from server.dispatch.problem import Call, Problem
from server.dispatch.refusal import binding_rule
from server.dispatch.schedule import Broken, CallTime


@dataclass(frozen=True, slots=True)
class Budget:
    """Counts, never seconds, so that a decision can be repeated. improvements: moves tried at most."""

    improvements: int = 0


@dataclass(frozen=True, slots=True)
class VehicleRoute:
    """A vehicle's calls in order, each with its times."""

    vehicle_id: str
    calls: tuple[Call, ...]
    times: tuple[CallTime, ...]


@dataclass(frozen=True, slots=True)
class Solution:
    """routes as the problem's vehicles are ordered; refused: request or chain id -> the rule that binds.

    cost     weighted seconds of all routes; tried: how many improvement moves were tried
    """

    routes: tuple[VehicleRoute, ...]
    refused: dict[str, str]
    cost: float
    tried: int


class RouteInfeasible(ValueError):
    """A vehicle's present route breaks a rule already: the caller must loosen what cannot be kept."""

    def __init__(self, vehicle_id: str, broken: Broken) -> None:
        super().__init__(f"{vehicle_id}: {broken.rule} of {broken.whose or 'a call'}")
        self.vehicle_id, self.broken = vehicle_id, broken


def solve(problem: Problem, budget: Budget, rng: np.random.Generator) -> Solution:
    """Routes that carry every request and departure they can, none of the present ones broken or dropped.

    Departures first, then requests, each in the order given, by cheapest insertion; then relocations as the
    budget allows. Raises RouteInfeasible.
    """
    routes = _present_routes(problem)
    refused: dict[str, str] = {}
    for chain in problem.open_chains:
        found = cheapest_chain(problem, routes, chain)
        if found is None:
            refused[chain.chain_id] = "departure"
        else:
            routes[found.vehicle] = found.route
    for request_id in problem.open_requests:
        request = problem.requests[request_id]
        found = cheapest_insertion(problem, routes, request)
        if found is None:
            refused[request_id] = binding_rule(problem, routes, request)
        else:
            routes[found.vehicle] = found.route
    routes, tried = improve(problem, routes, budget.improvements, rng)
    return Solution(
        routes=tuple(
            VehicleRoute(vehicle.vehicle_id, route.calls, route.times)
            for vehicle, route in zip(problem.vehicles, routes, strict=True)
        ),
        refused=refused,
        cost=sum(route.cost for route in routes),
        tried=tried,
    )


def _present_routes(problem: Problem) -> list[Route]:
    routes = []
    for vehicle in problem.vehicles:
        route = evaluated(problem, vehicle, vehicle.calls)
        if isinstance(route, Broken):
            raise RouteInfeasible(vehicle.vehicle_id, route)
        routes.append(route)
    return routes
