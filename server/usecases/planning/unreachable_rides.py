"""Rides that a closed road cuts off: they get a promise for the time after the closure, or they fail."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from datetime import datetime, timedelta

from server.dispatch.answer import Answer, PromiseRules, answer_all
from server.dispatch.problem import Problem, Request, VehicleState
from server.dispatch.refusal import CLOSED
from server.dispatch.schedule.schedule import Schedule
from server.domain.rides.rides import (
    Promise,
    Ride,
    RideState,
    promised_anew,
    unassigned,
)
from server.domain.roads.closures import Closure, ClosureState, ends_of
from server.travel.closed_roads import sections_closed_within
from server.travel.fleet_roads import FleetRoads
from server.usecases.planning import promises
from server.usecases.planning.assign import AssignmentResult
from server.usecases.planning.snapshot import moment, request_of, seconds
from server.usecases.ports import topics
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.failed_rides import fail_ride

Assign = Callable[[UnitOfWork, Sequence[Ride]], list[AssignmentResult]]


def book_around_closures(uow: UnitOfWork, rides: Sequence[Ride], assign: Assign) -> list[AssignmentResult]:
    """Book new rides with regard to closures at other times than now.

    A ride for a time at which its stops will be cut off is refused. If its stops are cut off now but not at
    its time, it gets its promise now, and its vehicle when the road is open.
    """
    standing = uow.closures.standing()
    refused = {ride.ride_id for ride in rides if is_cut_off_then(uow, ride, standing)}
    asked = [ride for ride in rides if ride.ride_id not in refused]
    answers = dict(zip([ride.ride_id for ride in asked], assign(uow, asked) if asked else [], strict=True))
    for ride in asked:
        if answers[ride.ride_id].rule == CLOSED:
            promise = _after_reopening(uow, [ride], standing, ride.earliest).get(ride.ride_id)
            if promise is not None:
                kept = replace(ride, promise=promise)
                uow.rides.save(kept)
                uow.publish(topics.dispatch(uow.campus_id))
                answers[ride.ride_id] = AssignmentResult(kept, "")
    return [answers.get(ride.ride_id) or AssignmentResult(ride, CLOSED) for ride in rides]


def postpone(uow: UnitOfWork, rides: Sequence[Ride]) -> tuple[str, ...]:
    """Postpone rides that no vehicle can serve at their time. Returns the vehicles that lost one of them.

    If a closure ends in time, they keep their promise or get a new one for the time after it. Otherwise they
    fail as soon as their time comes near.
    """
    if not rides:
        return ()
    standing = uow.closures.standing()
    found = _after_reopening(uow, rides, standing)
    changed = []
    for ride in rides:
        promise = found.get(ride.ride_id)
        if promise is None:
            ended_now = _fail_if_certain(uow, ride, standing)
        else:
            ended_now = promise != ride.promise and _promise_later(uow, ride, promise, standing)
        if ended_now and ride.vehicle_id is not None:
            changed.append(ride.vehicle_id)
    return tuple(dict.fromkeys(changed))


def will_be_cut_off(uow: UnitOfWork, ride: Ride, standing: Sequence[Closure]) -> bool:
    """A closure at the promised time of the ride will cut its stops off."""
    if ride.promise is None:
        return False
    begins = max(uow.now, ride.pickup_eta or ride.promise.pickup_from)
    ends = max(begins, ride.arrival_eta or ride.promise.arrive_by)
    roads = uow.roads()
    closed = sections_closed_within(standing, roads.network, begins, ends)
    return roads.closed_to(closed).is_cut_off(ride.from_stop, ride.to_stop)


def is_cut_off_then(uow: UnitOfWork, ride: Ride, standing: Sequence[Closure]) -> bool:
    """The stops are cut off at the requested time, as far as present closures tell."""
    roads = uow.roads()
    soonest = ride.earliest + timedelta(seconds=roads.direct_s(ride.from_stop, ride.to_stop))
    closed = sections_closed_within(standing, roads.network, ride.earliest, soonest)
    if closed == roads.closed:
        return False
    return roads.closed_to(closed).is_cut_off(ride.from_stop, ride.to_stop)


# ---------------------------------------------------------------- when the road is open again


def _after_reopening(
    uow: UnitOfWork, rides: Sequence[Ride], standing: Sequence[Closure], latest: datetime | None = None
) -> dict[str, Promise]:
    """The promises that can be kept or made after closures have ended, the earliest end first.

    latest  no end after this helps
    """
    found: dict[str, Promise] = {}
    left = list(rides)
    for opens in ends_of(standing):
        if not left or (latest is not None and opens > latest):
            break
        closed = sections_closed_within(standing, uow.network(), opens, opens)
        roads = uow.roads().closed_to(closed)
        found |= _promises_from(uow, roads, opens, left)
        left = [ride for ride in left if ride.ride_id not in found]
    return found


def _promises_from(
    uow: UnitOfWork, roads: FleetRoads, opens: datetime, rides: Sequence[Ride]
) -> dict[str, Promise]:
    """What the fleet could promise if it waited at its resting places until then; nothing is reserved."""
    problem = Problem(
        vehicles=_resting_fleet(uow, roads, seconds(max(opens, uow.now))),
        requests={},
        times=roads.stop_times(frozenset()),
        dwell_s=uow.rules.dwell_s,
    )
    schedule = Schedule(problem, spare=len(rides))
    terms = replace(roads.promise_rules(uow.rules), later_s_max=0.0)
    found: dict[str, Promise] = {}
    for ride in rides:
        if ride.promise is not None and _answered(
            schedule, request_of(uow, replace(ride, vehicle_id=None)), terms, promised=True
        ):
            found[ride.ride_id] = ride.promise
            continue
        free = replace(ride, promise=None, earliest=max(ride.earliest, opens), arrive_before=None)
        answer = _answered(schedule, request_of(uow, free), terms, promised=False)
        if answer is not None and answer.windows is not None:
            found[ride.ride_id] = Promise(*(moment(at_s) for at_s in answer.windows))
    return found


def _answered(schedule: Schedule, request: Request, terms: PromiseRules, *, promised: bool) -> Answer | None:
    """The answer with the request in some route. None if no vehicle can carry it: it leaves the schedule."""
    schedule.add(request)
    keeps = {request.request_id} if promised else frozenset[str]()
    answer = answer_all(schedule, [request.request_id], terms, keeps)[0]
    return None if answer.best is None else answer


def _resting_fleet(uow: UnitOfWork, roads: FleetRoads, ready_s: float) -> tuple[VehicleState, ...]:
    """The shuttles that take rides, each at its own resting place."""
    places = roads.network.resting_places
    rests = {plan.vehicle_id: places.get(plan.resting_place_id) for plan in uow.plans.all()}
    return tuple(
        VehicleState(
            vehicle.vehicle_id,
            roads.times_from_rest(rest),
            ready_s,
            vehicle.seats,
            vehicle.wheelchair_places,
        )
        for vehicle in uow.vehicles.all()
        if vehicle.accepts_rides and (rest := rests.get(vehicle.vehicle_id)) is not None
    )


# ---------------------------------------------------------------- telling


def _promise_later(uow: UnitOfWork, ride: Ride, promise: Promise, standing: Sequence[Closure]) -> bool:
    free = ride if ride.state is RideState.REQUESTED else unassigned(ride)
    later = promised_anew(free, promise)
    uow.rides.save(later)
    minutes = math.ceil((promise.pickup_to - (ride.promise or promise).pickup_to).total_seconds() / 60.0)
    promises.publish_broken_promise(
        uow, later, f"will be picked up {minutes} minutes later than promised", names_of(standing)
    )
    return True


def _fail_if_certain(uow: UnitOfWork, ride: Ride, standing: Sequence[Closure]) -> bool:
    """Fail the ride if its time is near and no shuttle can come. Returns whether it failed."""
    soon = ride.promise is None or ride.promise.pickup_from <= uow.now + timedelta(
        seconds=uow.rules.wait_s_max
    )
    stands = any(v.in_service and v.placed and not v.accepts_rides for v in uow.vehicles.all())
    fails = soon and (will_be_cut_off(uow, ride, standing) or not stands)
    if fails:
        fail_ride(uow, ride, CLOSED, f"no shuttle can come: {names_of(standing)}")
    return fails


def names_of(standing: Sequence[Closure]) -> str:
    """The names of the closures in force, or of the scheduled ones if there are none."""
    in_force = [closure for closure in standing if closure.state is ClosureState.IN_FORCE]
    return ", ".join(closure.label for closure in in_force or standing)
