"""A renewed promise becomes earlier again when the shuttle can come earlier after all."""

from dataclasses import replace
from datetime import datetime, timedelta

import pytest

from server.domain.rides.rides import Promise, Ride, promised_anew
from server.usecases.planning import plans
from server.usecases.planning.earlier_promises import promise_earlier
from server.usecases.record.enrolled_vehicles import enrolled_vehicle
from tests.server.usecases.fake_fleet import FakeFleet

MINUTE = timedelta(minutes=1)


def told_later(fleet: FakeFleet, by: timedelta) -> Ride:
    """A ride for now whose promise was renewed, so much later, and planned for it."""
    ride = fleet.book("NN20", "C6")
    promise = ride.promise
    assert promise is not None
    later = Promise(promise.pickup_from + by, promise.pickup_to + by, promise.arrive_by + by)
    late = promised_anew(ride, later)
    fleet.campus.do(lambda uow: uow.rides.save(late))
    assert ride.vehicle_id is not None
    vehicle_id = ride.vehicle_id
    fleet.campus.do(lambda uow: plans.choose_resting_place(uow, vehicle_id))
    planned_for = not_before(fleet, late)
    assert planned_for is not None
    assert planned_for >= later.pickup_from
    return fleet.ride(ride.ride_id)


def pickup_from(ride: Ride) -> datetime:
    assert ride.promise is not None
    return ride.promise.pickup_from


def not_before(fleet: FakeFleet, ride: Ride) -> datetime | None:
    known = fleet.campus.read(lambda uow: uow.plans.all())
    return next(v.not_before for plan in known for v in plan.visits if ride.ride_id in v.board)


def promised(fleet: FakeFleet, ride: Ride) -> Ride:
    fleet.campus.do(promise_earlier)
    return fleet.ride(ride.ride_id)


def test_a_party_that_waits_is_picked_up_when_the_shuttle_can_come_and_not_when_it_was_told(
    driven_fleet: FakeFleet,
) -> None:
    late = told_later(driven_fleet, 20 * MINUTE)
    told_at = driven_fleet.campus.clock.now()
    earlier = promised(driven_fleet, late)
    rules = driven_fleet.campus.rules
    assert pickup_from(earlier) >= told_at + timedelta(seconds=rules.promise_notice_s)
    assert pickup_from(earlier) < told_at + 10 * MINUTE
    driven_fleet.run_until(lambda: driven_fleet.ride(late.ride_id).boarded_at is not None, 1200.0)
    boarded_at = driven_fleet.ride(late.ride_id).boarded_at
    assert boarded_at is not None
    assert pickup_from(earlier) <= boarded_at < pickup_from(late)


def test_the_latest_times_that_were_told_stay(driven_fleet: FakeFleet) -> None:
    late = told_later(driven_fleet, 20 * MINUTE)
    earlier = promised(driven_fleet, late)
    assert earlier.promise == replace(late.promise, pickup_from=pickup_from(earlier))  # type: ignore[type-var]
    assert (earlier.promise_broken, earlier.first_promise) == (True, late.first_promise)
    assert not_before(driven_fleet, earlier) == pickup_from(earlier) + timedelta(
        seconds=driven_fleet.campus.rules.dwell_s
    )
    assert promised(driven_fleet, earlier) == earlier


def test_never_before_the_first_promise(driven_fleet: FakeFleet) -> None:
    ride = driven_fleet.book("NN20", "C6", earliest=driven_fleet.campus.clock.now() + 40 * MINUTE)
    promise = ride.promise
    assert promise is not None
    later = Promise(promise.pickup_from + 20 * MINUTE, promise.pickup_to + 20 * MINUTE, promise.arrive_by)
    late = promised_anew(ride, later)
    driven_fleet.campus.do(lambda uow: uow.rides.save(late))
    assert pickup_from(promised(driven_fleet, late)) == promise.pickup_from


@pytest.mark.parametrize("why", ["little", "held", "unreachable", "unplaced", "as_promised"])
def test_nothing_is_told_where_there_is_nothing_to_say(driven_fleet: FakeFleet, why: str) -> None:
    """Of a shuttle that stands or is out of reach nothing is known; few minutes are not worth it."""
    if why == "as_promised":
        late = driven_fleet.book("NN20", "C6", earliest=driven_fleet.campus.clock.now() + 40 * MINUTE)
    else:
        late = told_later(driven_fleet, 2 * MINUTE if why == "little" else 20 * MINUTE)
    shuttle = next(s for s in driven_fleet.shuttles if s.vehicle_id == late.vehicle_id)
    if why == "held":
        shuttle.hold()
    if why == "unreachable":
        shuttle.disconnect()
    if why == "unplaced":
        driven_fleet.campus.do(
            lambda uow: uow.vehicles.save(replace(enrolled_vehicle(uow, shuttle.vehicle_id), placed=False))
        )
    assert promised(driven_fleet, late).promise == late.promise


def test_nothing_is_told_while_the_plan_cannot_be_changed(driven_fleet: FakeFleet) -> None:
    """The shuttle would still wait for the time that was told before."""
    late = told_later(driven_fleet, 20 * MINUTE)
    assert late.vehicle_id is not None
    driven_fleet.leave_homeless(late.vehicle_id)
    assert promised(driven_fleet, late).promise == late.promise
