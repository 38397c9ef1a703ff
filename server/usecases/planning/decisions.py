"""Stored decisions: improvements are stored like answers, and every decision can be repeated."""

from collections.abc import Iterator
from dataclasses import dataclass

import msgspec

from server.dispatch.answer import answer_all
from server.dispatch.problem import Problem
from server.dispatch.problem_codec import ProblemUnreadable, decode_problem, encode_problem
from server.dispatch.schedule.schedule import Schedule
from server.dispatch.solve import Budget, Solution, solve
from server.domain.planning.decisions import Decision, Quote, RideDecision
from server.domain.rides.rides import Ride
from server.usecases.planning.assign import AssignmentRequest
from server.usecases.planning.snapshot import moment
from server.usecases.ports.unit_of_work import UnitOfWork


class DecisionUnreadable(ValueError):
    """What was stored about a decision cannot be read by this version of the dispatcher."""


@dataclass(frozen=True, slots=True)
class SearchSettings:
    """What an improvement depends on beside its problem; budget.stop_after is how many slices ran."""

    budget: Budget
    seed: int


def keep_improvement(
    uow: UnitOfWork, problem: Problem, search: SearchSettings, solution: Solution, before: dict[str, Ride]
) -> None:
    """Store an adopted improvement, so that a ride that changed its shuttle can be explained.

    before  the rides as they were, with the times that were expected then
    """
    decision_id = uow.ids.new_id("decision")
    answer = msgspec.json.encode(solution.routes)
    given = msgspec.json.encode(search)
    uow.decisions.add(
        Decision(uow.campus_id, decision_id, uow.now, "improvement", encode_problem(problem), given, answer)
    )
    more_s = round(solution.cost - Schedule(problem, spare=0).cost, 1)
    vehicles = sum(vehicle.accepts for vehicle in problem.vehicles)
    uow.decisions.add_rides(
        [
            RideDecision(uow.campus_id, ride.ride_id, decision_id, uow.now, "", now, was, (), vehicles)
            for ride, now, was in _moved(solution, before, more_s)
        ]
    )


def repeated(decision: Decision) -> bytes:
    """The answer that the stored snapshot gives now; equal to `decision.answer` unless something changed.

    Raises DecisionUnreadable.
    """
    try:
        problem = decode_problem(decision.problem)
        if decision.kind == "improvement":
            search = msgspec.json.decode(decision.given, type=SearchSettings)
            return msgspec.json.encode(solve(problem, search.budget, search.seed).routes)
        given = msgspec.json.decode(decision.given, type=AssignmentRequest)
    except (ProblemUnreadable, msgspec.MsgspecError) as error:
        raise DecisionUnreadable(str(error)) from error
    schedule = Schedule(problem)
    for request_id in problem.open_requests:
        schedule.add(problem.requests[request_id])
    answers = answer_all(schedule, problem.open_requests, given.terms, frozenset(given.promised))
    return msgspec.json.encode(answers)


def _moved(
    solution: Solution, before: dict[str, Ride], more_s: float
) -> Iterator[tuple[Ride, Quote, Quote | None]]:
    """Rides that changed their shuttle: the new times, and the times with the previous shuttle."""
    for route in solution.routes:
        gets_off = {
            ride_id: time.arrive_s
            for call, time in zip(route.calls, route.times, strict=True)
            for ride_id in call.alight
        }
        for call, time in zip(route.calls, route.times, strict=True):
            for ride_id in call.board:
                ride = before[ride_id]
                if ride.vehicle_id == route.vehicle_id:
                    continue
                now = Quote(route.vehicle_id, more_s, moment(time.arrive_s), moment(gets_off[ride_id]))
                yield ride, now, _as_expected(ride)


def _as_expected(ride: Ride) -> Quote | None:
    """The ride with its previous shuttle, at no extra cost."""
    if ride.vehicle_id is None or ride.pickup_eta is None or ride.arrival_eta is None:
        return None
    return Quote(ride.vehicle_id, 0.0, ride.pickup_eta, ride.arrival_eta)
