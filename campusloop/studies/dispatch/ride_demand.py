"""The stored rides of a day and the stored fleet, as input of a simulated day."""

from collections.abc import Sequence
from datetime import datetime

from server.domain.rides.rides import Ride, RideState
from server.travel.fleet_roads import FleetRoads
from server.usecases.planning.fleet_day import Shuttle
from server.usecases.ports.unit_of_work import UnitOfWork
from simulator.demand.day import WantedRide


class RideNotOnMap(ValueError):
    """A ride cannot be requested on the map; the text says which and why."""


def booked_between(uow: UnitOfWork, begins: datetime, ends: datetime) -> tuple[WantedRide, ...]:
    """The rides requested in that time, with the refused ones, in the order of booking."""
    rides = sorted(uow.rides.wanted_between(begins, ends), key=lambda ride: (ride.requested_at, ride.ride_id))
    return tuple(_wanted(ride) for ride in rides)


def enrolled(uow: UnitOfWork) -> tuple[Shuttle, ...]:
    """The shuttles that are not retired, by id."""
    return tuple(
        Shuttle(vehicle.vehicle_id, vehicle.seats, vehicle.wheelchair_places)
        for vehicle in uow.vehicles.all()
        if not vehicle.retired
    )


def require_on_map(rides: Sequence[WantedRide], roads: FleetRoads) -> None:
    """Raises RideNotOnMap."""
    for ride in rides:
        for stop in (ride.from_stop, ride.to_stop):
            if stop not in roads.stop_numbers:
                raise RideNotOnMap(
                    f"ride {ride.ride} is from or to {stop}, a stop that the map does not have"
                )
        if ride.from_stop == ride.to_stop:
            raise RideNotOnMap(f"ride {ride.ride} is from {ride.from_stop} to the same stop")


def _wanted(ride: Ride) -> WantedRide:
    """The ride to its first destination, with its cancellation."""
    return WantedRide(
        ride=ride.ride_id,
        announced_at=ride.requested_at,
        earliest=ride.earliest,
        from_stop=ride.from_stop,
        to_stop=ride.first_to_stop or ride.to_stop,
        party=ride.party,
        wheelchairs=ride.wheelchairs,
        booked_by=ride.source,
        cancelled_at=ride.ended_at if ride.state is RideState.CANCELLED else None,
    )
