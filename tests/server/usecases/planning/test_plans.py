"""What a plan keeps when it changes, and what it gives away."""

from dataclasses import replace
from datetime import timedelta

import pytest

from server.domain.errors import StopUnknown, VehicleNotPlaced, VehicleOutOfService, VehicleUnknown
from server.domain.planning.plans import Plan, PlannedVisit
from server.domain.rides.rides import Promise, Ride, RideState
from server.domain.service.timetable import Call, Departure, DepartureState
from server.usecases.planning import plans
from tests.server.usecases.fake_fleet import FakeFleet

MINUTE = timedelta(minutes=1)


def plan_of(fleet: FakeFleet, vehicle_id: str | None) -> Plan:
    return fleet.campus.read(lambda uow: plans.plan_of(uow, vehicle_id or ""))


def kinds(plan: Plan) -> list[str]:
    return [visit.kind for visit in plan.visits]


def test_a_shuttle_sent_to_a_stop_keeps_every_visit_that_it_has_promised(driven_fleet: FakeFleet) -> None:
    ride = driven_fleet.book("NN20", "C6")
    before = [
        visit.visit_id for visit in plan_of(driven_fleet, ride.vehicle_id).visits if visit.kind == "stop"
    ]
    after = driven_fleet.campus.do(lambda uow: plans.send_to_stop(uow, ride.vehicle_id or "", "NN20", "ann"))
    stops = [visit for visit in after.visits if visit.kind == "stop"]
    assert [visit.visit_id for visit in stops[:-1]] == before
    assert (stops[-1].stop_id, stops[-1].dwell_s) == ("NN20", driven_fleet.campus.rules.dwell_s)
    assert kinds(after).count("rest") == 1


def test_a_shuttle_that_is_not_there_or_not_in_service_is_not_sent(driven_fleet: FakeFleet) -> None:
    send = lambda vehicle_id, stop_id: driven_fleet.campus.do(  # noqa: E731
        lambda uow: plans.send_to_stop(uow, vehicle_id, stop_id, "ann")
    )
    with pytest.raises(VehicleUnknown):
        send("ghost", "C6")
    with pytest.raises(StopUnknown, match="nowhere"):
        send("shuttle-1", "nowhere")
    shuttle = driven_fleet.campus.read(lambda uow: uow.vehicles.get("shuttle-1"))
    assert shuttle is not None
    for change, error in (
        ({"placed": False}, VehicleNotPlaced),
        ({"in_service": False}, VehicleOutOfService),
    ):
        driven_fleet.campus.do(lambda uow, c=change: uow.vehicles.save(replace(shuttle, **c)))  # type: ignore[misc]
        with pytest.raises(error):
            send("shuttle-1", "C6")


def waiting(fleet: FakeFleet, ride: Ride, **changes: object) -> Ride:
    free = replace(
        ride,
        state=RideState.REQUESTED,
        vehicle_id=None,
        pickup_eta=None,
        arrival_eta=None,
        **changes,  # type: ignore[arg-type]
    )
    fleet.campus.do(lambda uow: uow.rides.save(free))
    return free


def test_a_ride_without_a_shuttle_gets_another_one_within_its_promise(driven_fleet: FakeFleet) -> None:
    ride = driven_fleet.book("NN20", "C6")
    waiting(driven_fleet, ride)
    (found,) = driven_fleet.campus.do(plans.assign_waiting)
    assert (found.ride_id, found.state, found.promise) == (ride.ride_id, RideState.ASSIGNED, ride.promise)
    assert not found.promise_broken


def test_a_ride_whose_window_is_over_is_taken_late_and_keeps_its_first_promise(
    driven_fleet: FakeFleet,
) -> None:
    ride = driven_fleet.book("NN20", "C6")
    now = driven_fleet.campus.clock.now()
    gone = Promise(now - 9 * MINUTE, now - MINUTE, now + MINUTE)
    waiting(driven_fleet, ride, promise=gone, requested_at=now - 20 * MINUTE)
    (found,) = driven_fleet.campus.do(plans.assign_waiting)
    assert found.promise is not None
    assert found.promise.pickup_to > now
    assert (found.first_promise, found.promise_broken) == (gone, True)
    assert found.requested_at == now - 20 * MINUTE


def test_a_ride_waits_on_while_its_window_is_open_and_no_shuttle_is_free(driven_fleet: FakeFleet) -> None:
    ride = driven_fleet.book("NN20", "C6")
    for shuttle in driven_fleet.shuttles:
        shuttle.hold()
    free = waiting(driven_fleet, ride)
    assert driven_fleet.campus.do(plans.assign_waiting) == ()
    assert driven_fleet.ride(ride.ride_id) == free


@pytest.mark.parametrize(("away_s", "reassigned"), [(59.0, False), (60.0, True)])
def test_a_shuttle_that_is_away_for_a_minute_loses_the_rides_that_wait_for_it(
    driven_fleet: FakeFleet, away_s: float, reassigned: bool
) -> None:
    """The other shuttle can be there in time."""
    ride = driven_fleet.book("NN20", "C6", earliest=driven_fleet.campus.clock.now() + 20 * MINUTE)
    shuttle = next(s for s in driven_fleet.shuttles if s.vehicle_id == ride.vehicle_id)
    shuttle.hold()
    driven_fleet.campus.clock.advance(away_s)
    driven_fleet.campus.do(plans.assign_waiting)
    assert (driven_fleet.ride(ride.ride_id).vehicle_id != ride.vehicle_id) == reassigned


def test_a_shuttle_that_is_held_for_a_time_keeps_what_it_can_still_do(driven_fleet: FakeFleet) -> None:
    ride = driven_fleet.book("NN20", "C6")
    shuttle = next(s for s in driven_fleet.shuttles if s.vehicle_id == ride.vehicle_id)
    shuttle.hold()
    vehicle = driven_fleet.campus.read(lambda uow: uow.vehicles.get(shuttle.vehicle_id))
    assert vehicle is not None
    ends = driven_fleet.campus.clock.now() + 2 * MINUTE
    driven_fleet.campus.do(lambda uow: uow.vehicles.save(replace(vehicle, hold_ends=ends)))
    driven_fleet.campus.clock.advance(61.0)
    driven_fleet.campus.do(plans.assign_waiting)
    assert driven_fleet.ride(ride.ride_id).vehicle_id == ride.vehicle_id


def a_call(departure: str, number: int, state: str = "pending") -> PlannedVisit:
    return PlannedVisit(
        f"{departure}-{number}",
        "stop",
        "C6",
        "l",
        1.0,
        state=state,
        departure_id=departure,
        call=number,  # type: ignore[arg-type]
    )


def test_departures_that_have_not_begun_are_given_back_and_begun_ones_are_finished(
    driven_fleet: FakeFleet,
) -> None:
    now = driven_fleet.campus.clock.now()
    calls = (Call("C6", now + MINUTE), Call("NN20", now + 9 * MINUTE))
    name = "shuttle-1"
    departures = [
        Departure("snow-lion", f"{n}@2026-11-23", n, calls, DepartureState.ASSIGNED, name) for n in "ab"
    ]
    begun, ahead = (departure.departure_id for departure in departures)
    before = plan_of(driven_fleet, name)
    visits = (a_call(begun, 1), a_call(ahead, 0), a_call(ahead, 1))

    def give(uow):  # type: ignore[no-untyped-def]
        for departure in departures:
            uow.departures.add(departure)
        uow.plans.save(replace(before, version=before.version + 1, visits=visits), before.version)

    driven_fleet.campus.do(give)
    driven_fleet.campus.do(lambda uow: plans.release_departures(uow, name))
    assert [visit.visit_id for visit in plan_of(driven_fleet, name).visits] == [f"{begun}-1"]
    left = driven_fleet.campus.read(lambda uow: uow.departures.get(ahead))
    kept = driven_fleet.campus.read(lambda uow: uow.departures.get(begun))
    assert left is not None
    assert kept is not None
    assert (left.state, left.vehicle_id) == (DepartureState.PLANNED, None)
    assert (kept.state, kept.vehicle_id) == (DepartureState.ASSIGNED, name)
