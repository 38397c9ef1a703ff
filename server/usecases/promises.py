"""Promises once made: an incident with a cause when one is broken."""

from dataclasses import replace

from server.domain.incidents import IncidentKind
from server.domain.rides import Ride, RideState
from server.domain.rules import FleetRules
from server.usecases import topics
from server.usecases.incidents import open_incident
from server.usecases.ports import UnitOfWork


def check_promises(uow: UnitOfWork) -> tuple[Ride, ...]:
    """The rides whose promise has been broken since the last look."""
    under_way = (RideState.REQUESTED, RideState.ASSIGNED, RideState.BOARDING, RideState.ABOARD)
    broken = []
    for ride in uow.rides.in_states(under_way):
        what = _broken(uow, ride)
        if what and not ride.promise_broken:
            late = replace(ride, promise_broken=True)
            uow.rides.save(late)
            _tell(uow, late, what)
            broken.append(late)
    return tuple(broken)


def _broken(uow: UnitOfWork, ride: Ride) -> str:
    if ride.promise is None:
        return ""
    if uow.now > ride.promise.arrive_by:
        return "not there by the latest arrival"
    # A shuttle that stands at the stop with open doors has come.
    waiting = ride.state in (RideState.REQUESTED, RideState.ASSIGNED)
    return "not picked up within the window" if waiting and uow.now > ride.promise.pickup_to else ""


def _tell(uow: UnitOfWork, ride: Ride, what: str) -> None:
    cause = f"ride {ride.ride_code} {what}: {_reason(uow, ride)}"
    open_incident(
        uow,
        IncidentKind.PROMISE_BROKEN,
        ride.ride_id,
        cause,
        vehicle_id=ride.vehicle_id,
        ride_id=ride.ride_id,
    )
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


def arrival_slack_s(rules: FleetRules, on_board_s: float) -> float:
    """How long after the planned arrival the promised one lies."""
    return rules.arrival_slack_s + rules.arrival_slack_ratio * on_board_s
