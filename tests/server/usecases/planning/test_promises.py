"""Promises are checked against the plan, and a party whose promise breaks gets a new one and a cause."""

from dataclasses import replace
from datetime import datetime, timedelta

import pytest

from server.domain.record.incidents import IncidentKind
from server.domain.rides.rides import Promise, Ride, RideState
from server.usecases.planning.promises import check_promises
from tests.server.usecases.fake_fleet import FakeFleet
from tests.server.usecases.fake_shuttle import FakeShuttle

SECOND, MINUTE = timedelta(seconds=1), timedelta(minutes=1)


def stored(fleet: FakeFleet, ride: Ride, **changes: object) -> Ride:
    changed = replace(ride, **changes)  # type: ignore[arg-type]
    fleet.campus.do(lambda uow: uow.rides.save(changed))
    return changed


def checked(fleet: FakeFleet, ride: Ride) -> Ride:
    fleet.campus.do(check_promises)
    return fleet.ride(ride.ride_id)


def causes(fleet: FakeFleet) -> list[str]:
    return [
        incident.cause
        for incident in fleet.campus.read(lambda uow: uow.incidents.all_open())
        if incident.kind is IncidentKind.PROMISE_BROKEN
    ]


def shuttle_of(fleet: FakeFleet, ride: Ride) -> FakeShuttle:
    return next(shuttle for shuttle in fleet.shuttles if shuttle.vehicle_id == ride.vehicle_id)


def promise_of(ride: Ride) -> Promise:
    assert ride.promise is not None
    return ride.promise


def booked(fleet: FakeFleet) -> tuple[Ride, Promise, datetime]:
    """A ride that waits for its shuttle, its promise, and the moment."""
    ride = fleet.book("NN20", "C6")
    return ride, promise_of(ride), fleet.campus.clock.now()


def test_a_plan_that_misses_a_promise_by_less_than_the_lapse_changes_nothing(
    driven_fleet: FakeFleet,
) -> None:
    ride, promise, _ = booked(driven_fleet)
    lapse = timedelta(seconds=driven_fleet.campus.rules.promise_lapse_s)
    late = {"pickup_eta": promise.pickup_to + lapse, "arrival_eta": promise.arrive_by + lapse}
    same = stored(driven_fleet, ride, **late)
    assert checked(driven_fleet, ride) == same
    assert causes(driven_fleet) == []


def test_a_later_pickup_is_promised_anew_around_the_time_planned_now(driven_fleet: FakeFleet) -> None:
    ride, promise, _ = booked(driven_fleet)
    pickup_eta, arrival_eta = promise.pickup_to + 3 * MINUTE, promise.arrive_by - MINUTE
    stored(driven_fleet, ride, pickup_eta=pickup_eta, arrival_eta=arrival_eta)
    told = checked(driven_fleet, ride)
    new, early = promise_of(told), timedelta(seconds=driven_fleet.campus.rules.pickup_early_s)
    assert new.pickup_from == max(promise.pickup_from, pickup_eta - early)
    assert new.pickup_to > pickup_eta
    assert new.arrive_by >= promise.arrive_by
    assert (told.promise_broken, told.first_promise) == (True, promise)
    assert causes(driven_fleet) == [
        f"ride {ride.ride_code} will be picked up 3 minutes later than promised: {ride.vehicle_id} is late"
    ]


def test_a_later_arrival_alone_leaves_the_pickup_as_it_was_promised(driven_fleet: FakeFleet) -> None:
    ride, promise, _ = booked(driven_fleet)
    lapse = timedelta(seconds=driven_fleet.campus.rules.promise_lapse_s)
    arrival_eta = promise.arrive_by + lapse + SECOND
    stored(driven_fleet, ride, arrival_eta=arrival_eta)
    new = promise_of(checked(driven_fleet, ride))
    assert (new.pickup_from, new.pickup_to) == (promise.pickup_from, promise.pickup_to)
    assert new.arrive_by > arrival_eta
    assert "will arrive 1 minute later than promised" in causes(driven_fleet)[0]


def test_a_party_on_board_is_told_of_its_arrival_and_not_of_its_pickup(driven_fleet: FakeFleet) -> None:
    ride, promise, now = booked(driven_fleet)
    stored(
        driven_fleet,
        ride,
        state=RideState.ABOARD,
        boarded_at=now,
        pickup_eta=promise.pickup_to + 9 * MINUTE,
        arrival_eta=promise.arrive_by + 4 * MINUTE,
    )
    told = checked(driven_fleet, ride)
    assert promise_of(told).pickup_to == promise.pickup_to
    assert "will arrive 4 minutes later" in causes(driven_fleet)[0]


def test_a_party_is_told_once_of_a_window_that_is_over_and_of_an_arrival_that_was_missed(
    driven_fleet: FakeFleet,
) -> None:
    """Of a ride without a shuttle nothing else can be said."""
    ride, promise, now = booked(driven_fleet)
    waiting = {"state": RideState.REQUESTED, "vehicle_id": None, "pickup_eta": None, "arrival_eta": None}
    stored(driven_fleet, ride, **waiting)
    driven_fleet.campus.clock.advance((promise.pickup_to - now).total_seconds())
    assert not checked(driven_fleet, ride).promise_broken
    driven_fleet.campus.clock.advance(1.0)
    told = checked(driven_fleet, ride)
    assert (told.promise_broken, told.promise) == (True, promise)
    assert causes(driven_fleet) == [
        f"ride {ride.ride_code} not picked up within the window: no shuttle could take it over"
    ]
    assert checked(driven_fleet, ride) == told


@pytest.mark.parametrize(("state", "broken"), [(RideState.BOARDING, False), (RideState.ASSIGNED, True)])
def test_a_shuttle_with_open_doors_at_the_stop_has_come(
    driven_fleet: FakeFleet, state: RideState, broken: bool
) -> None:
    ride, promise, now = booked(driven_fleet)
    stored(driven_fleet, ride, state=state, arrival_eta=None)
    driven_fleet.campus.clock.advance((promise.pickup_to - now).total_seconds() + 1.0)
    assert checked(driven_fleet, ride).promise_broken == broken


def test_beyond_the_latest_arrival_a_boarding_party_is_late_too(driven_fleet: FakeFleet) -> None:
    ride, promise, now = booked(driven_fleet)
    stored(driven_fleet, ride, state=RideState.BOARDING, arrival_eta=None)
    driven_fleet.campus.clock.advance((promise.arrive_by - now).total_seconds() + 1.0)
    assert checked(driven_fleet, ride).promise_broken
    assert "not there by the latest arrival" in causes(driven_fleet)[0]


def test_the_cause_names_a_shuttle_that_is_held(driven_fleet: FakeFleet) -> None:
    ride, promise, _ = booked(driven_fleet)
    shuttle_of(driven_fleet, ride).hold()
    late = stored(driven_fleet, ride, pickup_eta=promise.pickup_to + 3 * MINUTE)
    checked(driven_fleet, late)
    assert causes(driven_fleet)[0].endswith(f"{ride.vehicle_id} stands (held)")


def test_the_cause_names_a_shuttle_that_cannot_be_reached(driven_fleet: FakeFleet) -> None:
    ride, promise, _ = booked(driven_fleet)
    shuttle_of(driven_fleet, ride).disconnect()
    late = stored(driven_fleet, ride, pickup_eta=promise.pickup_to + 3 * MINUTE)
    checked(driven_fleet, late)
    assert causes(driven_fleet)[0].endswith(f"{ride.vehicle_id} cannot be reached")
