"""Rides that no shuttle can serve at their time: the promise is kept or moved, or the ride fails."""

import math
from collections.abc import Sequence
from dataclasses import replace
from datetime import datetime, timedelta

import pytest

from server.domain.record.incidents import IncidentKind
from server.domain.rides.rides import Ride, RideState
from server.domain.roads.closures import Closure
from server.usecases.fleet import closures, vehicles
from server.usecases.fleet.closures import CloseRoad
from server.usecases.planning import unreachable_rides
from tests.server.usecases.fake_fleet import FakeFleet

# The lane at which the stop C6 lies.
AT_C6 = ("east-4",)


def in_hours(fleet: FakeFleet, hours: float) -> datetime:
    return fleet.campus.clock.now() + timedelta(hours=hours)


def will_close(fleet: FakeFleet, starts: datetime, ends: datetime | None) -> None:
    """The closure is entered, and no ride has been told of it yet."""
    now = fleet.campus.clock.now()
    closure = Closure("snow-lion", "closure-1", AT_C6, (), "water main", starts, ends, "ann", now)
    fleet.campus.do(lambda uow: uow.closures.add(closure))


def postponed(fleet: FakeFleet, *rides: Ride) -> Sequence[str]:
    return fleet.campus.do(lambda uow: unreachable_rides.postpone(uow, rides))


def causes(fleet: FakeFleet, kind: IncidentKind) -> list[str]:
    return [i.cause for i in fleet.campus.read(lambda uow: uow.incidents.all_open()) if i.kind is kind]


def test_a_ride_within_a_closure_is_told_its_new_time_and_its_shuttle_is_named_once(fleet: FakeFleet) -> None:
    rides = [fleet.book("NN20", "C6", earliest=in_hours(fleet, 3.0)) for _ in range(2)]
    assert rides[0].vehicle_id == rides[1].vehicle_id
    opens = in_hours(fleet, 4.0)
    will_close(fleet, in_hours(fleet, 2.0), opens)
    assert postponed(fleet, *rides) == (rides[0].vehicle_id,)
    for ride in rides:
        told = fleet.ride(ride.ride_id)
        assert (told.state, told.vehicle_id, told.promise_broken) == (RideState.REQUESTED, None, True)
        assert told.promise is not None
        assert ride.promise is not None
        assert told.promise.pickup_from >= opens
        minutes = math.ceil((told.promise.pickup_to - ride.promise.pickup_to).total_seconds() / 60.0)
        assert any(
            f"{minutes} minutes later" in cause for cause in causes(fleet, IncidentKind.PROMISE_BROKEN)
        )


def test_rides_whose_promise_can_be_kept_after_the_closure_lose_nothing(fleet: FakeFleet) -> None:
    rides = [fleet.book("NN20", "C6", earliest=in_hours(fleet, 3.0)) for _ in range(2)]
    will_close(fleet, in_hours(fleet, 1.0), in_hours(fleet, 2.0))
    assert postponed(fleet, *rides) == ()
    assert [fleet.ride(ride.ride_id) for ride in rides] == rides


def test_a_ride_without_a_shuttle_takes_none_from_its_plan(fleet: FakeFleet) -> None:
    ride = fleet.book("NN20", "C6", earliest=in_hours(fleet, 3.0))
    free = replace(ride, state=RideState.REQUESTED, vehicle_id=None, pickup_eta=None, arrival_eta=None)
    will_close(fleet, in_hours(fleet, 2.0), in_hours(fleet, 4.0))
    assert postponed(fleet, free) == ()
    assert fleet.ride(ride.ride_id).promise_broken


@pytest.mark.parametrize(("spare_s", "failed"), [(0.0, True), (1.0, False)])
def test_a_ride_on_a_road_that_stays_closed_fails_when_its_time_is_near(
    fleet: FakeFleet, spare_s: float, failed: bool
) -> None:
    ride = fleet.book("NN20", "C6", earliest=in_hours(fleet, 3.0))
    assert ride.promise is not None
    will_close(fleet, in_hours(fleet, 0.0), None)
    soon = ride.promise.pickup_from - timedelta(seconds=fleet.campus.rules.wait_s_max + spare_s)
    fleet.campus.clock.advance((soon - fleet.campus.clock.now()).total_seconds())
    assert postponed(fleet, ride) == ((ride.vehicle_id,) if failed else ())
    assert (fleet.ride(ride.ride_id).state is RideState.FAILED) is failed
    assert any("water main" in cause for cause in causes(fleet, IncidentKind.RIDE_FAILED)) is failed


@pytest.mark.parametrize(
    ("shuttles", "failed"),
    [
        ({"in_service": True}, True),
        ({"held": True}, False),
        ({"connected": False}, False),
        ({"in_service": False, "held": True}, True),
        ({"placed": False, "held": True}, True),
    ],
)
def test_a_ride_whose_road_is_open_waits_on_only_if_some_shuttle_may_still_take_it(
    fleet: FakeFleet, shuttles: dict[str, bool], failed: bool
) -> None:
    """Those that take rides have been asked already."""
    ride = fleet.book("NN20", "C1")
    for vehicle in fleet.campus.read(lambda uow: uow.vehicles.all()):
        fleet.campus.do(lambda uow, v=vehicle: uow.vehicles.save(replace(v, **shuttles)))  # type: ignore[misc]
    postponed(fleet, ride)
    assert (fleet.ride(ride.ride_id).state is RideState.FAILED) is failed


def test_without_a_shuttle_in_service_nothing_is_promised_for_after_the_closure(fleet: FakeFleet) -> None:
    ride = fleet.book("NN20", "C6", earliest=in_hours(fleet, 3.0))
    will_close(fleet, in_hours(fleet, 2.0), in_hours(fleet, 4.0))
    for shuttle in fleet.shuttles:
        fleet.campus.do(lambda uow, name=shuttle.vehicle_id: vehicles.recall(uow, name, "ann"))  # type: ignore[misc]
    waiting = fleet.ride(ride.ride_id)
    assert postponed(fleet, waiting) == ()
    assert fleet.ride(ride.ride_id) == waiting


def test_a_ride_that_begins_as_the_road_opens_is_promised_now(fleet: FakeFleet) -> None:
    opens = in_hours(fleet, 2.0)
    fleet.campus.do(lambda uow: closures.close(uow, CloseRoad(AT_C6, ends_at=opens), "ann"))
    ride = fleet.book("NN20", "C6", earliest=opens)
    assert (ride.state, ride.vehicle_id) == (RideState.REQUESTED, None)
    assert ride.promise is not None
    assert ride.promise.pickup_from >= opens
