"""Makes a late promise earlier when the shuttle can come earlier after all.

A renewed promise says when the shuttle could come at that moment. When a road opens or a held
shuttle drives again, it would wait for the time that the party was told, with the party at the stop.
"""

from dataclasses import replace
from datetime import datetime, timedelta

from server.domain.errors import NoRestingPlaceFree
from server.domain.planning.plans import Plan, PlannedVisit
from server.domain.rides.rides import Promise, Ride, RideState
from server.usecases.planning import plans
from server.usecases.ports import topics
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.server_events import record_event


def promise_earlier(uow: UnitOfWork) -> tuple[Ride, ...]:
    """The rides that are picked up earlier than they were told last, each with its new promise.

    No earlier than they were promised first, and no sooner than `promise_notice_s` from now: the party may
    have left the stop. The latest pickup and arrival stay, so that nothing that was said becomes untrue.
    """
    told = []
    for ride in uow.rides.in_states((RideState.ASSIGNED,)):
        promise = _earlier_promise(uow, ride)
        if promise is None or ride.promise is None or ride.vehicle_id is None:
            continue
        earlier = replace(ride, promise=promise)
        uow.rides.save(earlier)
        try:
            plans.choose_resting_place(uow, ride.vehicle_id)
        except NoRestingPlaceFree:
            # The plan stays, with its times: nothing is told before it can be changed.
            uow.rides.save(ride)
            continue
        said = f"{ride.promise.pickup_from:%H:%M:%S} UTC before, {promise.pickup_from:%H:%M:%S} UTC now"
        record_event(uow, "ride.promised_earlier", ride.ride_id, "", said)
        uow.publish(topics.ride(uow.campus_id, ride.ride_id), promise="earlier")
        told.append(earlier)
    return tuple(told)


def _earlier_promise(uow: UnitOfWork, ride: Ride) -> Promise | None:
    """None if the shuttle cannot come earlier by at least the notice."""
    promise, first = ride.promise, ride.first_promise
    if promise is None or first is None or ride.vehicle_id is None:
        return None
    vehicle, plan = uow.vehicles.get(ride.vehicle_id), uow.plans.get(ride.vehicle_id)
    pickup = None if plan is None else _pickup(plan, ride)
    if vehicle is None or not vehicle.accepts_rides or pickup is None:
        return None
    ready = _ready_at(uow, pickup)
    if ready is None:
        return None
    notice, early = (timedelta(seconds=s) for s in (uow.rules.promise_notice_s, uow.rules.pickup_early_s))
    pickup_from = max(first.pickup_from, ready - early, uow.now + notice)
    if promise.pickup_from - pickup_from < notice:
        return None
    return replace(promise, pickup_from=pickup_from)


def _pickup(plan: Plan, ride: Ride) -> PlannedVisit | None:
    return next((visit for visit in plan.visits if ride.ride_id in visit.board), None)


def _ready_at(uow: UnitOfWork, visit: PlannedVisit) -> datetime | None:
    """When the doors are open, if the shuttle does not wait for the party's time; None if it is not known."""
    if visit.eta is None or visit.departure_id:
        return None
    return max(visit.eta, uow.now) + timedelta(seconds=visit.dwell_s)
