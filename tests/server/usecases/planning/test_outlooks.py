"""What a waiting party is told of its shuttle: when it comes, and how full it gets."""

from dataclasses import replace
from datetime import timedelta

import pytest

from server.domain.planning.outlooks import NO_OUTLOOK, RideOutlook
from server.domain.rides.rides import Ride, RideState
from server.usecases.planning import outlooks
from server.usecases.planning.outlooks import outlook_of
from server.usecases.rides import rides
from tests.server.usecases.fake_fleet import FakeFleet


def outlook(fleet: FakeFleet, ride: Ride) -> RideOutlook:
    return fleet.campus.read(lambda uow: outlook_of(uow, rides.ride_of(uow, ride.ride_id)))


def set_vehicle(fleet: FakeFleet, vehicle_id: str | None, **changes: object) -> None:
    def work(uow: rides.UnitOfWork) -> None:
        vehicle = uow.vehicles.get(vehicle_id or "")
        assert vehicle is not None
        uow.vehicles.save(replace(vehicle, **changes))  # type: ignore[arg-type]

    fleet.campus.do(work)


def test_a_waiting_party_is_told_a_range_around_its_planned_pickup(fleet: FakeFleet) -> None:
    ride = fleet.book("NN20", "C6", party=2)
    told = outlook(fleet, ride).pickup
    assert told is not None
    assert ride.pickup_eta is not None
    assert fleet.campus.clock.now() <= told.earliest <= ride.pickup_eta <= told.latest


def test_a_shuttle_that_stands_or_is_out_of_reach_promises_no_time(fleet: FakeFleet) -> None:
    ride = fleet.book("NN20", "C6")
    set_vehicle(fleet, ride.vehicle_id, held=True)
    assert outlook(fleet, ride).pickup is None
    set_vehicle(fleet, ride.vehicle_id, held=False, connected=False)
    assert outlook(fleet, ride).pickup is None
    set_vehicle(fleet, ride.vehicle_id, connected=True)
    assert outlook(fleet, ride).pickup is not None


def test_seats_are_counted_on_the_fullest_part_of_the_ride(fleet: FakeFleet) -> None:
    ride = fleet.book("NN20", "C6", party=2)
    assert outlook(fleet, ride).seats_left == 4
    # It may go with the same shuttle or another one: only together do they fill seats.
    other = fleet.book("NN20", "C6", party=3)
    together = ride.vehicle_id == other.vehicle_id
    assert outlook(fleet, other).seats_left == (1 if together else 3)
    assert outlook(fleet, fleet.ride(ride.ride_id)).seats_left == (1 if together else 4)


def test_seats_are_counted_while_the_party_rides_and_no_longer(driven_fleet: FakeFleet) -> None:
    fleet = driven_fleet
    ride = fleet.book("NN20", "C6", party=2)
    fleet.run_until(lambda: fleet.ride(ride.ride_id).state is RideState.ABOARD)
    aboard = outlook(fleet, ride)
    assert (aboard.pickup, aboard.seats_left) == (None, 4)
    arrival_eta = fleet.ride(ride.ride_id).arrival_eta
    assert aboard.arrival is not None
    assert arrival_eta is not None
    assert aboard.arrival.earliest < arrival_eta <= aboard.arrival.latest
    fleet.run_until(lambda: fleet.ride(ride.ride_id).has_ended)
    assert outlook(fleet, ride) == RideOutlook(vehicle_name=ride.vehicle_id or "")


def test_an_arrival_is_told_from_the_booking_on_but_not_while_the_shuttle_is_out_of_reach(
    driven_fleet: FakeFleet,
) -> None:
    fleet = driven_fleet
    ride = fleet.book("NN20", "C6")
    told = outlook(fleet, ride)
    assert told.pickup is not None
    assert told.arrival is not None
    assert told.pickup.earliest < told.arrival.earliest < told.arrival.latest
    assert ride.promise is not None
    assert told.arrival.latest <= ride.promise.arrive_by
    fleet.run_until(lambda: fleet.ride(ride.ride_id).state is RideState.ABOARD)
    next(one for one in fleet.shuttles if one.vehicle_id == ride.vehicle_id).disconnect()
    assert outlook(fleet, ride).arrival is None


def test_many_outlooks_at_once_are_what_each_is_alone(
    driven_fleet: FakeFleet, monkeypatch: pytest.MonkeyPatch
) -> None:
    fleet = driven_fleet
    ended = fleet.book("NN20", "C6", party=2)
    fleet.run_until(lambda: fleet.ride(ended.ride_id).has_ended)
    later = fleet.campus.clock.now() + timedelta(hours=1)
    for wish in (("NN20", "GYM"), ("GYM", "C6"), ("C6", "NN20")):
        fleet.book(*wish, party=2)
        fleet.book(*wish, earliest=later)
    fleet.run_until(lambda: any(ride.state is RideState.ABOARD for ride in fleet.rides()))
    every = fleet.rides()
    alone = {ride.ride_id: outlook(fleet, ride) for ride in every}
    assert any(one.pickup is not None for one in alone.values())
    monkeypatch.setattr(outlooks, "_MANY", 1)
    assert fleet.campus.read(lambda uow: outlooks.outlooks_of(uow, every)) == alone


def test_a_refused_ride_has_no_outlook(fleet: FakeFleet) -> None:
    for shuttle in fleet.shuttles:
        set_vehicle(fleet, shuttle.vehicle_id, in_service=False)
    refused = fleet.book("NN20", "C6")
    assert refused.state is RideState.REFUSED
    assert outlook(fleet, refused) == NO_OUTLOOK
