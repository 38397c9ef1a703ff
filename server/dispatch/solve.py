"""The dispatcher's door: a snapshot in, routes out. The same problem, budget and rng give the same answer."""

from dataclasses import dataclass

import numpy as np

from server.dispatch.problem import Call, Problem


@dataclass(frozen=True, slots=True)
class Budget:
    """Counts, never seconds, so that a decision can be repeated. improvements: moves tried at most."""

    improvements: int = 0


@dataclass(frozen=True, slots=True)
class CallTime:
    """When a call is made under the plan."""

    arrive_s: float
    leave_s: float


@dataclass(frozen=True, slots=True)
class VehicleRoute:
    """A vehicle's calls in order, each with its times."""

    vehicle_id: str
    calls: tuple[Call, ...]
    times: tuple[CallTime, ...]


@dataclass(frozen=True, slots=True)
class Solution:
    """routes as the problem's vehicles are ordered; refused: request id -> the rule that binds.

    cost     weighted seconds of all routes; tried: how many improvement moves were tried
    """

    routes: tuple[VehicleRoute, ...]
    refused: dict[str, str]
    cost: float
    tried: int


def solve(problem: Problem, budget: Budget, rng: np.random.Generator) -> Solution:
    """Routes that carry every request they can."""
    raise NotImplementedError
