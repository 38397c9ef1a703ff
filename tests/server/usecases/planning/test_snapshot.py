"""The fleet as the dispatcher sees it: who is where, who is aboard, and which windows hold."""

from dataclasses import replace
from datetime import timedelta
from itertools import pairwise

import pytest

from server.dispatch.problem import VehicleState
from server.domain.rides.rides import Ride, RideState
from server.domain.service.timetable import Call as ServiceCall
from server.domain.service.timetable import Departure
from server.usecases.planning import plans
from server.usecases.planning.snapshot import Snapshot, request_of, seconds, take_snapshot
from tests.server.usecases.fake_fleet import FakeFleet
from tests.server.usecases.fake_shuttle import FakeShuttle


def seen(fleet: FakeFleet) -> Snapshot:
    return fleet.campus.read(take_snapshot)


def state_of(fleet: FakeFleet, vehicle_id: str | None) -> VehicleState:
    return next(v for v in seen(fleet).problem.vehicles if v.vehicle_id == vehicle_id)


def shuttle_of(fleet: FakeFleet, ride: Ride) -> FakeShuttle:
    return next(s for s in fleet.shuttles if s.vehicle_id == fleet.ride(ride.ride_id).vehicle_id)


def now_s(fleet: FakeFleet) -> float:
    return seconds(fleet.campus.clock.now())


def test_only_shuttles_that_are_placed_are_seen(driven_fleet: FakeFleet) -> None:
    driven_fleet.campus.enrol("shuttle-3")
    assert [v.vehicle_id for v in seen(driven_fleet).problem.vehicles] == ["shuttle-1", "shuttle-2"]


def test_a_new_wish_may_be_fetched_from_its_beginning_until_nobody_waits_any_longer(
    driven_fleet: FakeFleet,
) -> None:
    ride = driven_fleet.book("NN20", "C6")
    wish = replace(ride, promise=None, vehicle_id=None, earliest=ride.earliest + timedelta(minutes=10))
    request = driven_fleet.campus.read(lambda uow: request_of(uow, wish))
    assert request.pickup_from_s == seconds(wish.earliest)
    assert request.pickup_to_s == seconds(wish.earliest) + driven_fleet.campus.rules.wait_s_max
    assert request.arrive_by_s == float("inf")


def test_a_promise_keeps_its_reserve_from_later_riders_and_gives_it_to_who_looks_for_a_shuttle(
    driven_fleet: FakeFleet,
) -> None:
    ride, rules = driven_fleet.book("NN20", "C6"), driven_fleet.campus.rules
    assert ride.promise is not None
    ahead_s = (ride.promise.pickup_to - ride.requested_at).total_seconds()
    reserve_s = rules.reserve_s(ahead_s, told_anew=False)
    assert reserve_s > 0.0
    planned = driven_fleet.campus.read(lambda uow: request_of(uow, ride))
    assert planned.pickup_from_s == seconds(ride.promise.pickup_from)
    assert planned.pickup_to_s == seconds(ride.promise.pickup_to) - reserve_s
    assert planned.arrive_by_s == seconds(ride.promise.arrive_by) - reserve_s
    free = driven_fleet.campus.read(lambda uow: request_of(uow, replace(ride, vehicle_id=None)))
    assert free.pickup_to_s == seconds(ride.promise.pickup_to)
    assert free.arrive_by_s == seconds(ride.promise.arrive_by)


def test_a_new_wish_ends_before_closing_and_a_promise_holds_beyond_it(driven_fleet: FakeFleet) -> None:
    ride = driven_fleet.book("NN20", "C6")
    assert ride.promise is not None
    closes = ride.promise.arrive_by - timedelta(minutes=30)
    bound = replace(ride, arrive_before=closes)
    kept = driven_fleet.campus.read(lambda uow: request_of(uow, replace(bound, vehicle_id=None)))
    assert kept.arrive_by_s == seconds(ride.promise.arrive_by)
    wish = driven_fleet.campus.read(
        lambda uow: request_of(uow, replace(bound, promise=None, vehicle_id=None))
    )
    assert wish.arrive_by_s == seconds(closes)


def test_a_ride_that_waits_is_a_call_to_make_and_one_aboard_a_call_to_end(driven_fleet: FakeFleet) -> None:
    fleet = driven_fleet
    ride = fleet.book("NN20", "C6")
    waiting = state_of(fleet, ride.vehicle_id)
    assert (waiting.aboard, waiting.locked) == ((), 0)
    assert [(c.board, c.alight) for c in waiting.calls] == [((ride.ride_id,), ()), ((), (ride.ride_id,))]
    fleet.run_until(lambda: fleet.ride(ride.ride_id).state is RideState.ABOARD)
    aboard = state_of(fleet, ride.vehicle_id)
    assert aboard.aboard == (ride.ride_id,)
    assert all(call.board == () for call in aboard.calls)
    assert aboard.calls[-1].alight == (ride.ride_id,)


def test_a_rider_aboard_whom_no_visit_lets_out_is_let_out_all_the_same(driven_fleet: FakeFleet) -> None:
    fleet = driven_fleet
    ride = fleet.book("NN20", "C6")
    fleet.run_until(lambda: fleet.ride(ride.ride_id).state is RideState.ABOARD)
    plan = fleet.campus.read(lambda uow: plans.plan_of(uow, ride.vehicle_id or ""))
    rests = tuple(visit for visit in plan.visits if visit.kind == "rest")
    fleet.campus.do(
        lambda uow: uow.plans.save(replace(plan, version=plan.version + 1, visits=rests), plan.version)
    )
    (call,) = state_of(fleet, ride.vehicle_id).calls
    roads_to = fleet.campus.read(lambda uow: uow.roads().stop_numbers["C6"])
    assert (call.place, call.alight, call.call_id) == (roads_to, (ride.ride_id,), "")


def test_at_its_stop_a_shuttle_is_locked_to_it_and_no_way_is_left(driven_fleet: FakeFleet) -> None:
    fleet = driven_fleet
    ride = fleet.book("NN20", "C6")
    there = fleet.campus.read(lambda uow: uow.roads().stop_numbers["NN20"])
    assert state_of(fleet, ride.vehicle_id).to_places_s[there] > 0.0
    fleet.run_until(
        lambda: (
            fleet.campus.read(lambda uow: plans.plan_of(uow, ride.vehicle_id or "")).under_way is not None
            and fleet.ride(ride.ride_id).state is not RideState.ASSIGNED
        )
    )
    state = state_of(fleet, ride.vehicle_id)
    assert (state.locked, state.to_places_s[there]) == (1, 0.0)


def test_a_shuttle_that_cannot_be_reached_or_is_held_takes_nobody_new(driven_fleet: FakeFleet) -> None:
    fleet = driven_fleet
    assert all(vehicle.accepts for vehicle in seen(fleet).problem.vehicles)
    fleet.shuttles[0].hold()
    fleet.shuttles[1].disconnect()
    fleet.campus.clock.advance(fleet.campus.rules.reassign_after_s + 10.0)
    assert not state_of(fleet, "shuttle-1").accepts


def test_a_shuttle_is_ready_now_and_one_held_for_a_time_when_its_hold_ends(driven_fleet: FakeFleet) -> None:
    fleet = driven_fleet
    ends = fleet.campus.clock.now() + timedelta(minutes=20)
    known = fleet.campus.read(lambda uow: uow.vehicles.get("shuttle-1"))
    assert known is not None
    fleet.campus.do(lambda uow: uow.vehicles.save(replace(known, hold_ends=ends)))
    assert state_of(fleet, "shuttle-1").ready_s == seconds(ends)
    assert state_of(fleet, "shuttle-2").ready_s == now_s(fleet)


@pytest.mark.parametrize("left_out", ["ended", "another's"])
def test_a_visit_for_riders_who_are_no_longer_of_the_vehicle_is_left_out(
    driven_fleet: FakeFleet, left_out: str
) -> None:
    fleet = driven_fleet
    ride = fleet.book("NN20", "C6")
    vehicle_id = ride.vehicle_id
    other = next(s.vehicle_id for s in fleet.shuttles if s.vehicle_id != vehicle_id)
    changes = {"state": RideState.CANCELLED} if left_out == "ended" else {"vehicle_id": other}
    fleet.campus.do(lambda uow: uow.rides.save(replace(ride, **changes)))  # type: ignore[arg-type]
    assert state_of(fleet, vehicle_id).calls == ()


def test_calls_of_a_timetable_that_is_faster_than_planned_driving_follow_as_fast_as_it_allows(
    driven_fleet: FakeFleet,
) -> None:
    """A trip over three stops, all of them at the same moment."""
    campus = driven_fleet.campus
    rules, leave_at = campus.rules, campus.clock.now() + timedelta(hours=1)
    stops = ("NN20", "C6", "GYM")
    calls = tuple(ServiceCall(stop_id, leave_at) for stop_id in stops)
    departure = Departure("snow-lion", f"trip@{leave_at:%Y-%m-%d}", "trip", calls)
    problem = campus.read(lambda uow: take_snapshot(uow, (), (departure,))).problem
    (chain,) = problem.open_chains
    assert [call.leave_from_s for call in chain.calls] == [seconds(leave_at)] * 3
    latest_s = [call.arrive_by_s - rules.departure_tolerance_s - seconds(leave_at) for call in chain.calls]
    assert latest_s[0] == -rules.dwell_s
    factor = campus.read(lambda uow: uow.travel_time_factor_at(leave_at))
    drive = campus.read(lambda uow: uow.roads().stop_times(frozenset(uow.roads().network.resting_places)))
    numbers = campus.read(lambda uow: [uow.roads().stop_numbers[stop_id] for stop_id in stops])
    first_s, second_s = (factor * float(drive[a, b]) for a, b in pairwise(numbers))
    assert latest_s[1] == pytest.approx(first_s)
    assert latest_s[2] == pytest.approx(latest_s[1] + rules.dwell_s + second_s)
