"""Ends rides that no vehicle can carry, with their reason and an incident."""

from datetime import timedelta

from server.domain.record.incidents import IncidentKind
from server.domain.rides.rides import Ride, RideState, ended
from server.usecases.ports import topics
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.incidents import open_incident


def fail_ride(uow: UnitOfWork, ride: Ride, reason: str, detail: str, cause: str = "") -> None:
    """reason: a stable code; detail: for the party; cause: for operators, if it says more."""
    uow.rides.save(ended(ride, RideState.FAILED, uow.now, reason, detail))
    uow.publish(topics.ride(uow.campus_id, ride.ride_id))
    open_incident(
        uow,
        IncidentKind.RIDE_FAILED,
        ride.ride_id,
        f"ride {ride.ride_code}: {cause or detail}",
        vehicle_id=ride.vehicle_id,
        ride_id=ride.ride_id,
    )


def fail_late_ride(uow: UnitOfWork, ride: Ride, rule: str) -> None:
    """Fail a ride that no vehicle could take within the longest wait, whatever the rule."""
    wanted = ride.earliest if ride.promise is None else ride.promise.pickup_to
    if uow.now > wanted + timedelta(seconds=uow.rules.wait_s_max):
        cause = f"no shuttle could take it over ({rule})"
        fail_ride(uow, ride, rule, "no shuttle could take over the ride", cause)
