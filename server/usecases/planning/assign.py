"""Assigns rides to shuttles, one after the other, on one snapshot of the fleet."""

from collections.abc import Collection, Sequence, Set
from dataclasses import dataclass, replace

import msgspec

from server.dispatch.alternatives import Alternative as DispatchAlternative
from server.dispatch.answer import Answer, PromiseRules, Quote, answer_all
from server.dispatch.problem import Request
from server.dispatch.problem_codec import encode_problem
from server.dispatch.schedule.schedule import Schedule
from server.domain.planning.decisions import (
    Alternative,
    Decision,
    DecisionKind,
    RideDecision,
)
from server.domain.planning.decisions import Quote as StoredQuote
from server.domain.rides.rides import Promise, Ride
from server.travel.fleet_roads import FleetRoads
from server.usecases.planning.issue_orders import adopt_routes
from server.usecases.planning.snapshot import Snapshot, moment, take_snapshot
from server.usecases.ports.unit_of_work import UnitOfWork


@dataclass(frozen=True, slots=True)
class AssignmentRequest:
    """What a stored decision depends on beside its problem; promised: request ids that keep their windows."""

    terms: PromiseRules
    promised: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class AssignmentResult:
    """A ride with its vehicle, promise and expected times, and rule ""; or as it was, with the rule that
    binds and what would be accepted instead."""

    ride: Ride
    rule: str
    alternatives: tuple[Alternative, ...] = ()


def assign_ride(uow: UnitOfWork, ride: Ride, kind: DecisionKind) -> AssignmentResult:
    """See `assign_rides`."""
    return assign_rides(uow, [ride], kind)[0]


def assign_rides(
    uow: UnitOfWork,
    wanted: Sequence[Ride],
    kind: DecisionKind,
    only: Collection[str] | None = None,
    walking: Set[str] = frozenset(),
) -> list[AssignmentResult]:
    """Assign each ride, in the given order; `only` these vehicles may take them. The rides of `walking` may
    begin and end at other stops within walking distance, and then have these stops.

    A ride that has a promise keeps it. The decision is stored with its snapshot, unless it changed nothing
    for a ride that goes on waiting.
    """
    if not wanted:
        return []
    snapshot = take_snapshot(uow, wanted=wanted)
    if only is not None:
        snapshot = _with_only_vehicles(snapshot, only)
    terms = uow.roads().promise_rules(uow.rules)
    requests = snapshot.problem.requests
    for ride_id in walking:
        requests[ride_id] = _with_walks(requests[ride_id], terms)
    schedule = Schedule(snapshot.problem)
    for ride in wanted:
        schedule.add(requests[ride.ride_id])
    if kind != "booking":
        terms = replace(terms, later_s_max=0.0)
    promised = {ride.ride_id for ride in wanted if ride.promise is not None}
    answers = answer_all(schedule, [ride.ride_id for ride in wanted], terms, promised)
    stay = _planned_but_refused(snapshot, answers)
    if stay:
        return _assign_others(uow, wanted, kind, stay, only)
    is_kept = kind == "booking" or any(answer.best for answer in answers)
    problem = encode_problem(snapshot.problem) if is_kept else b""
    for ride, answer in zip(wanted, answers, strict=True):
        if answer.best is not None:
            _promise(uow.roads(), snapshot, schedule, ride, answer)
    # A ride that comes from another vehicle leaves that one's route as well.
    taken = {answer.best.vehicle_id for answer in answers if answer.best is not None}
    adopt_routes(uow, snapshot, schedule.routes(taken if kind == "booking" else None))
    instead = [tuple(_alternative(uow.roads(), found) for found in answer.alternatives) for answer in answers]
    if is_kept:
        given = msgspec.json.encode(AssignmentRequest(terms, tuple(sorted(promised))))
        _store_decision(uow, snapshot, problem, answers, instead, kind, given)
    return [
        AssignmentResult(snapshot.rides[ride.ride_id] if answer.best else ride, answer.rule, others)
        for ride, answer, others in zip(wanted, answers, instead, strict=True)
    ]


def _planned_but_refused(snapshot: Snapshot, answers: Sequence[Answer]) -> dict[str, str]:
    """Refused rides that are in some vehicle's plan, with the rule: they must stay there."""
    refused = {answer.request_id: answer.rule for answer in answers if answer.best is None}
    planned = {ride_id for plan in snapshot.plans.values() for ride_id in plan.ride_ids}
    return {ride_id: rule for ride_id, rule in refused.items() if ride_id in planned}


def _with_only_vehicles(snapshot: Snapshot, only: Collection[str]) -> Snapshot:
    vehicles = tuple(
        replace(vehicle, accepts=vehicle.accepts and vehicle.vehicle_id in only)
        for vehicle in snapshot.problem.vehicles
    )
    return replace(snapshot, problem=replace(snapshot.problem, vehicles=vehicles))


def _assign_others(
    uow: UnitOfWork,
    wanted: Sequence[Ride],
    kind: DecisionKind,
    stay: dict[str, str],
    only: Collection[str] | None,
) -> list[AssignmentResult]:
    """Decide again, with these rides left in their plans."""
    others = assign_rides(uow, [ride for ride in wanted if ride.ride_id not in stay], kind, only)
    decided = iter(others)
    return [
        AssignmentResult(ride, stay[ride.ride_id]) if ride.ride_id in stay else next(decided)
        for ride in wanted
    ]


def _with_walks(request: Request, terms: PromiseRules) -> Request:
    if not terms.walks:
        return request
    return replace(
        request, pickup_walks=terms.walks[request.pickup], dropoff_walks=terms.walks[request.dropoff]
    )


def _promise(roads: FleetRoads, snapshot: Snapshot, schedule: Schedule, ride: Ride, answer: Answer) -> None:
    """Put the promise into the snapshot before the plan is stored, so that the visits keep its window."""
    if ride.promise is not None or answer.windows is None:
        return
    from_s, to_s, by_s = answer.windows
    promise = Promise(moment(from_s), moment(to_s), moment(by_s))
    taken = schedule.requests[schedule.rows[ride.ride_id]]
    snapshot.rides[ride.ride_id] = replace(
        ride, promise=promise, from_stop=roads.stop_ids[taken.pickup], to_stop=roads.stop_ids[taken.dropoff]
    )
    snapshot.problem.requests[ride.ride_id] = taken


def _store_decision(
    uow: UnitOfWork,
    snapshot: Snapshot,
    problem: bytes,
    answers: Sequence[Answer],
    instead: Sequence[tuple[Alternative, ...]],
    kind: DecisionKind,
    given: bytes,
) -> None:
    decision_id = uow.ids.new_id("decision")
    decision = Decision(
        uow.campus_id, decision_id, uow.now, kind, problem, given, msgspec.json.encode(answers)
    )
    uow.decisions.add(decision)
    vehicles = sum(vehicle.accepts for vehicle in snapshot.problem.vehicles)
    uow.decisions.add_rides(
        [
            RideDecision(
                uow.campus_id,
                answer.request_id,
                decision_id,
                uow.now,
                answer.rule,
                _stored_quote(answer.best),
                _stored_quote(answer.runner_up),
                others,
                vehicles,
            )
            for answer, others in zip(answers, instead, strict=True)
        ]
    )


def _stored_quote(quote: Quote | None) -> StoredQuote | None:
    if quote is None:
        return None
    return StoredQuote(
        quote.vehicle_id, round(quote.extra_cost, 1), moment(quote.pickup_s), moment(quote.arrival_s)
    )


def _alternative(roads: FleetRoads, found: DispatchAlternative) -> Alternative:
    return Alternative(
        found.kind,
        roads.stop_ids[found.pickup],
        roads.stop_ids[found.dropoff],
        found.parties,
        found.walk_s,
        tuple(moment(s) for s in found.pickup_s),
        tuple(moment(s) for s in found.arrival_s),
    )
