"""Applies boardings, alightings and no-shows that vehicles report."""

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
    ride = uow.rides.get(event.ride_id)
    if ride is None:
        return _unknown(uow, vehicle_id, "rider_boarded", event.ride_id)
    if ride.state is RideState.ABOARD:
        return None
    planned_by = ride.vehicle_id
    expected = planned_by == vehicle_id and not ride.has_ended
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
    ride = uow.rides.get(event.ride_id)
    if ride is None:
        return _unknown(uow, vehicle_id, "rider_alighted", event.ride_id)
    if ride.state is RideState.COMPLETED:
        return None
    if ride.stranded_by == vehicle_id and not ride.has_ended and ride.vehicle_id != vehicle_id:
        return lost_vehicles.rider_left_lost_vehicle(uow, vehicle_id, ride)
    if ride.state is not RideState.ABOARD:
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
    ride = uow.rides.get(event.ride_id)
    if ride is None:
        return _unknown(uow, vehicle_id, "rider_no_show", event.ride_id)
    if ride.vehicle_id != vehicle_id or ride.state not in (RideState.ASSIGNED, RideState.BOARDING):
        return None
    detail = "the party did not board before the shuttle had to leave"
    uow.rides.save(ended(ride, RideState.NO_SHOW, uow.now, "no_show", detail))
    _record_and_publish(uow, ride, "ride.no_show", vehicle_id)
    plans.replan(uow, vehicle_id)
    return None


def rider_did_not_alight(uow: UnitOfWork, vehicle_id: str, event: RiderDidNotAlight) -> None:
    """An incident; the vehicle lets the rider out at a further visit. The second time the ride fails."""
    ride = uow.rides.get(event.ride_id)
    if ride is None:
        return _unknown(uow, vehicle_id, "rider_did_not_alight", event.ride_id)
    if ride.state is not RideState.ABOARD:
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


def _unknown(uow: UnitOfWork, vehicle_id: str, what: str, ride_id: str) -> None:
    record_event(uow, f"{what}.unknown_ride", vehicle_id, vehicle_id, ride_id)


def _contradiction(uow: UnitOfWork, vehicle_id: str, ride: Ride, what: str) -> None:
    detail = f"{vehicle_id} says {what}, the ride is {ride.state}"
    record_event(uow, "ride.contradiction", ride.ride_id, vehicle_id, detail)


def _record_and_publish(uow: UnitOfWork, ride: Ride, name: str, vehicle_id: str, detail: str = "") -> None:
    record_event(uow, name, ride.ride_id, vehicle_id, detail)
    uow.publish(topics.ride(uow.campus_id, ride.ride_id), vehicle_id=vehicle_id)
