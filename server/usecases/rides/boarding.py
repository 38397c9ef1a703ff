"""Applies boardings, alightings and no-shows that vehicles report.

A vehicle speaks for itself only: its report on a ride that it was never ordered to serve has no effect and is
an incident.
"""

from dataclasses import replace

from contract.wire.messages import BoardedHow, RiderAlighted, RiderBoarded, RiderDidNotAlight, RiderNoShow
from server.domain.errors import IllegalTransition
from server.domain.record.incidents import IncidentKind
from server.domain.rides.rides import (
    Ride,
    RideState,
    boarded,
    ended,
)
from server.usecases.planning import plans
from server.usecases.planning.routes import vehicles_with_ride
from server.usecases.ports import topics
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.incidents import clear_incident, open_incident
from server.usecases.record.server_events import record_event
from server.usecases.rides import lost_vehicles


def rider_boarded(uow: UnitOfWork, vehicle_id: str, event: RiderBoarded) -> None:
    """The party is on board, whatever the server has stored. Its planned vehicle is replanned."""
    ride = _ride_of(uow, vehicle_id, "boarded", event.ride_id)
    if ride is None or ride.state is RideState.ABOARD:
        return None
    expected = ride.vehicle_id == vehicle_id and not ride.has_ended
    aboard = _boarded(uow, ride, event.how)
    if aboard is None:
        return None
    uow.rides.save(replace(aboard, vehicle_id=vehicle_id))
    _record_and_publish(uow, ride, "ride.boarded", vehicle_id, event.how)
    if not expected:
        for other in vehicles_with_ride(uow.plans.all(), ride.ride_id):
            if other != vehicle_id:
                plans.replan(uow, other)
        plans.replan(uow, vehicle_id)
    return None


def rider_alighted(uow: UnitOfWork, vehicle_id: str, event: RiderAlighted) -> None:
    """The ride is completed; early, if the vehicle does not stand at the ride's own stop."""
    ride = _ride_of(uow, vehicle_id, "alighted", event.ride_id)
    if ride is None or ride.state is RideState.COMPLETED:
        return None
    if ride.stranded_by == vehicle_id and not ride.has_ended and ride.vehicle_id != vehicle_id:
        return lost_vehicles.rider_left_lost_vehicle(uow, vehicle_id, ride)
    if ride.state is not RideState.ABOARD or ride.vehicle_id != vehicle_id:
        return _contradiction(uow, vehicle_id, ride, "alighted")
    plan = uow.plans.get(vehicle_id)
    here = None if plan is None else plan.under_way
    early = here is None or here.stop_id != ride.to_stop
    done = ended(ride, RideState.COMPLETED, uow.now)
    uow.rides.save(replace(done, left_early=early or ride.let_out))
    clear_incident(uow, IncidentKind.RIDER_DID_NOT_ALIGHT, ride.ride_id)
    _record_and_publish(uow, ride, "ride.completed", vehicle_id, event.how)
    if early:
        plans.replan(uow, vehicle_id)
    return None


def rider_no_show(uow: UnitOfWork, vehicle_id: str, event: RiderNoShow) -> None:
    """The seats are free again, and the visits made for this party leave the plan."""
    ride = _ride_of(uow, vehicle_id, "no_show", event.ride_id)
    if ride is None:
        return None
    if ride.vehicle_id != vehicle_id or ride.state not in (RideState.ASSIGNED, RideState.BOARDING):
        return None
    detail = "the party did not board before the shuttle had to leave"
    uow.rides.save(ended(ride, RideState.NO_SHOW, uow.now, "no_show", detail))
    _record_and_publish(uow, ride, "ride.no_show", vehicle_id)
    plans.replan(uow, vehicle_id)
    return None


def rider_did_not_alight(uow: UnitOfWork, vehicle_id: str, event: RiderDidNotAlight) -> None:
    """An incident; the vehicle lets the rider out at a further visit. The second time the ride fails."""
    ride = _ride_of(uow, vehicle_id, "did_not_alight", event.ride_id)
    if ride is None or ride.state is not RideState.ABOARD or ride.vehicle_id != vehicle_id:
        return None
    again = uow.incidents.open_about(IncidentKind.RIDER_DID_NOT_ALIGHT, ride.ride_id) is not None
    open_incident(
        uow,
        IncidentKind.RIDER_DID_NOT_ALIGHT,
        ride.ride_id,
        f"ride {ride.ride_code} stayed in the shuttle at its stop",
        vehicle_id=vehicle_id,
        ride_id=ride.ride_id,
    )
    if again:
        detail = "stayed in the shuttle, or left without being seen"
        uow.rides.save(ended(ride, RideState.FAILED, uow.now, "did_not_alight", detail))
    _record_and_publish(uow, ride, "ride.did_not_alight", vehicle_id)
    return None


def _boarded(uow: UnitOfWork, ride: Ride, how: BoardedHow) -> Ride | None:
    try:
        return boarded(ride, how, uow.now)
    except IllegalTransition:
        _contradiction(uow, ride.vehicle_id or "", ride, "boarded")
        return None


def _ride_of(uow: UnitOfWork, vehicle_id: str, what: str, ride_id: str) -> Ride | None:
    """The ride that a vehicle reports on; None if the vehicle never had it, which is recorded.

    A vehicle had a ride if it has it now, had to leave it at a stop, or was once sent an order that names it.
    The plan may have changed while the vehicle was out of reach.
    """
    ride = uow.rides.get(ride_id)
    if ride is None:
        record_event(uow, f"rider_{what}.unknown_ride", vehicle_id, vehicle_id, ride_id)
        return None
    if vehicle_id in (ride.vehicle_id, ride.stranded_by) or uow.orders.has_named(vehicle_id, ride_id):
        return ride
    cause = f"{vehicle_id} reports ({what}) on ride {ride.ride_code}, which it was never ordered to serve"
    subject = f"{vehicle_id}/{ride_id}"
    open_incident(uow, IncidentKind.FALSE_REPORT, subject, cause, vehicle_id=vehicle_id, ride_id=ride_id)
    record_event(uow, "ride.false_report", ride_id, vehicle_id, what)
    return None


def _contradiction(uow: UnitOfWork, vehicle_id: str, ride: Ride, what: str) -> None:
    detail = f"{vehicle_id} says {what}, the ride is {ride.state} with {ride.vehicle_id or 'no vehicle'}"
    record_event(uow, "ride.contradiction", ride.ride_id, vehicle_id, detail)


def _record_and_publish(uow: UnitOfWork, ride: Ride, name: str, vehicle_id: str, detail: str = "") -> None:
    record_event(uow, name, ride.ride_id, vehicle_id, detail)
    uow.publish(topics.ride(uow.campus_id, ride.ride_id), vehicle_id=vehicle_id)
