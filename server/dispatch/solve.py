"""A snapshot in, routes out. The same problem, budget and seed give the same answer."""

from collections.abc import Callable
from dataclasses import dataclass

from server.dispatch.decide import offers_for, take
from server.dispatch.improve import CoolingSchedule, improve
from server.dispatch.problem import Problem, VehicleRoute
from server.dispatch.refusal import binding_rule
from server.dispatch.schedule.chains import insert_chain
from server.dispatch.schedule.schedule import Schedule


@dataclass(frozen=True, slots=True)
class Budget:
    """Counts, never seconds, so that a decision can be repeated.

    slices      of improvement, each of so many attempts to take a few requests out and put them back
    stop_after  how many slices an earlier run did in its time, to repeat it; None for a first run
    """

    slices: int = 0
    attempts: int = 50
    stop_after: int | None = None


@dataclass(frozen=True, slots=True)
class Solution:
    """routes of all vehicles but those in `impossible`, in the problem's order.

    refused     request or chain id -> the rule that binds
    impossible  vehicles with more people than seats; overdue: requests whose promise cannot be kept
    cost        weighted seconds of all routes, up to a constant of the problem
    slices      of improvement that ran
    """

    routes: tuple[VehicleRoute, ...]
    refused: dict[str, str]
    impossible: tuple[str, ...]
    overdue: frozenset[str]
    cost: float
    slices: int


def without_deadline() -> bool:
    """For callers without a deadline."""
    return True


def solve(
    problem: Problem, budget: Budget, seed: int, may_continue: Callable[[], bool] = without_deadline
) -> Solution:
    """Routes that carry as many requests and departures as possible. No present one is dropped.

    Departures first, then requests, each in the order given, by cheapest insertion; then improvement as the
    budget allows, which also tries the requests that were left over.

    may_continue  asked before each slice; the solution says how many slices ran
    """
    schedule = Schedule(problem, spare=0)
    refused: dict[str, str] = {}
    for chain in problem.open_chains:
        if not insert_chain(schedule, chain):
            refused[chain.chain_id] = "departure"
    for request_id in problem.open_requests:
        schedule.add(problem.requests[request_id])
        best = offers_for(schedule, request_id).best
        if best is not None:
            take(schedule, best)
    most = budget.slices if budget.stop_after is None else budget.stop_after
    slices = improve(schedule, CoolingSchedule(budget.slices, budget.attempts), seed, most, may_continue)
    carried = set(schedule.carried(problem.open_requests))
    for request_id in problem.open_requests:
        if request_id not in carried:
            refused[request_id] = binding_rule(schedule, request_id)
    return Solution(
        routes=schedule.routes(),
        refused=refused,
        impossible=tuple(schedule.vehicle_ids[v] for v in sorted(schedule.impossible)),
        overdue=frozenset(schedule.overdue),
        cost=schedule.cost,
        slices=slices,
    )
