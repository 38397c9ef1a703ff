"""Checks promises: if one cannot be kept, the party gets a new one, and an incident names the cause."""

import math
from dataclasses import replace
from datetime import timedelta

from server.dispatch.problem import CUT_OFF_S
from server.domain.record.incidents import IncidentKind
from server.domain.rides.rides import (
    Promise,
    Ride,
    RideState,
    promised_anew,
)
from server.usecases.planning.snapshot import moment, seconds
from server.usecases.ports import topics
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.incidents import open_incident
from server.usecases.record.server_events import record_event

# No plan is so long: a closed road is in between, which `detours` handles.
_CUT_OFF_S = 0.5 * CUT_OFF_S
_UNDER_WAY = (RideState.REQUESTED, RideState.ASSIGNED, RideState.BOARDING, RideState.ABOARD)


def check_promises(uow: UnitOfWork) -> tuple[Ride, ...]:
    """The rides whose promise has turned out to be broken since the last check.

    As soon as the plan misses the promise, the party gets a new promise with the usual room around the times
    planned now, and an incident names the cause.
    """
    told = []
    for ride in uow.rides.in_states(_UNDER_WAY):
        what, promise = _missed_promise(uow, ride)
        if promise is not None:
            late = promised_anew(ride, promise)
        elif what and not ride.promise_broken:
            late = replace(ride, promise_broken=True)
        else:
            continue
        uow.rides.save(late)
        publish_broken_promise(uow, late, what)
        told.append(late)
    return tuple(told)


def _missed_promise(uow: UnitOfWork, ride: Ride) -> tuple[str, Promise | None]:
    """How the plan misses the promise now, and what can be promised instead; "" if it does not."""
    promise, rules = ride.promise, uow.rules
    if promise is None or ride.vehicle_id is None or ride.arrival_eta is None:
        return _missed_time(uow, ride), None
    room = timedelta(seconds=rules.promise_lapse_s)
    waits = ride.state in (RideState.REQUESTED, RideState.ASSIGNED)
    pickup_eta = ride.pickup_eta if waits else None
    # Times in the past belong to a plan that was not refreshed since.
    arrival_eta = max(ride.arrival_eta, uow.now)
    if (arrival_eta - uow.now).total_seconds() > _CUT_OFF_S:
        return _missed_time(uow, ride), None
    pickup_eta = None if pickup_eta is None else max(pickup_eta, uow.now)
    what = ""
    if pickup_eta is not None and pickup_eta > promise.pickup_to + room:
        what = f"will be picked up {_minutes(pickup_eta - promise.pickup_to)} later than promised"
    elif arrival_eta > promise.arrive_by + room:
        what = f"will arrive {_minutes(arrival_eta - promise.arrive_by)} later than promised"
    if not what:
        return "", None
    terms = uow.roads().promise_rules(rules)
    begins = pickup_eta or ride.pickup_eta or uow.now
    pickup_from, pickup_to = promise.pickup_from, promise.pickup_to
    if pickup_eta is not None:
        pickup_from = max(pickup_from, pickup_eta - timedelta(seconds=rules.pickup_early_s))
        pickup_to = max(pickup_to, moment(terms.pickup_to_s(seconds(pickup_eta), seconds(uow.now))))
    arrive_by = moment(terms.arrive_by_s(seconds(begins), seconds(arrival_eta), seconds(uow.now)))
    return what, Promise(pickup_from, pickup_to, max(promise.arrive_by, arrive_by))


def _minutes(late: timedelta) -> str:
    minutes = math.ceil(late.total_seconds() / 60.0)
    return f"{minutes} minute{'s' if minutes != 1 else ''}"


def _missed_time(uow: UnitOfWork, ride: Ride) -> str:
    if ride.promise is None:
        return ""
    if uow.now > ride.promise.arrive_by:
        return "not there by the latest arrival"
    # A shuttle that stands at the stop with open doors has come.
    waiting = ride.state in (RideState.REQUESTED, RideState.ASSIGNED)
    return "not picked up within the window" if waiting and uow.now > ride.promise.pickup_to else ""


def publish_broken_promise(uow: UnitOfWork, ride: Ride, what: str, reason: str = "") -> None:
    """Open an incident that names the cause, and publish the ride, so that the phone shows it."""
    cause = f"ride {ride.ride_code} {what}: {reason or _reason(uow, ride)}"
    open_incident(
        uow,
        IncidentKind.PROMISE_BROKEN,
        ride.ride_id,
        cause,
        vehicle_id=ride.vehicle_id,
        ride_id=ride.ride_id,
    )
    record_event(uow, "ride.promise_broken", ride.ride_id, "", cause)
    uow.publish(topics.ride(uow.campus_id, ride.ride_id), promise="broken")


def _reason(uow: UnitOfWork, ride: Ride) -> str:
    if ride.vehicle_id is None:
        return "no shuttle could take it over"
    vehicle = uow.vehicles.get(ride.vehicle_id)
    if vehicle is None or not vehicle.connected:
        return f"{ride.vehicle_id} cannot be reached"
    if vehicle.held:
        return f"{ride.vehicle_id} stands ({vehicle.mode})"
    if uow.incidents.open_about(IncidentKind.VEHICLE_BLOCKED, ride.vehicle_id) is not None:
        return f"{ride.vehicle_id} is blocked"
    return f"{ride.vehicle_id} is late"
