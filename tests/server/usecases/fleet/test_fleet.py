"""Whole days in small: fake shuttles obey their orders, people book, cancel and stay away, links break."""

import random
from collections import Counter
from datetime import datetime, timedelta

import pytest

from server.domain.rides.rides import RideState
from server.domain.service.timetable import DepartureState
from server.usecases.fleet import departures
from server.usecases.rides import rides
from tests.server.usecases.campus_under_test import CampusUnderTest
from tests.server.usecases.fake_fleet import FakeFleet
from tests.server.usecases.shipped_maps import shipped_map


def some_bookings(fleet: FakeFleet, chance: random.Random, count: int) -> None:
    stops = [stop.stop_id for stop in fleet.network.road_map.stops]
    for _ in range(count):
        from_stop, to_stop = chance.sample(stops, 2)
        fleet.book(from_stop, to_stop, chance.randint(1, 4))
        for _ in range(chance.randint(1, 60)):
            fleet.step()


@pytest.mark.long
@pytest.mark.parametrize(("name", "seed"), [("shanghai-university", 1), ("snow-lion", 1)])
def test_every_promise_is_kept_while_travel_times_are_as_planned(name: str, seed: int) -> None:
    campus = CampusUnderTest(shipped_map(name), seed=seed)
    fleet = FakeFleet(campus, shipped_map(name), 3).start()
    some_bookings(fleet, random.Random(seed), 4)
    fleet.run_until_idle(6000.0)
    assert Counter(ride.state for ride in fleet.rides()) == {RideState.COMPLETED: 4}
    for ride in fleet.rides():
        assert ride.promise is not None
        assert ride.boarded_at is not None
        assert ride.ended_at is not None
        assert ride.promise.pickup_from <= ride.boarded_at
        assert ride.boarded_at <= ride.promise.pickup_to + timedelta(seconds=campus.rules.dwell_s + 2.0)
        assert ride.ended_at <= ride.promise.arrive_by
    assert campus.read(lambda uow: uow.views.incidents(include_closed=True)) == ()
    campus.close()


@pytest.mark.parametrize("seed", [3])
def test_no_ride_is_lost_through_no_shows_cancellations_holds_and_broken_links(seed: int) -> None:
    campus = CampusUnderTest(shipped_map("shanghai-university"), seed=seed)
    fleet = FakeFleet(campus, shipped_map("shanghai-university"), 3).start()
    chance = random.Random(seed)
    stops = [stop.stop_id for stop in fleet.network.road_map.stops]
    back_at: dict[str, int] = {}
    absent, gone = set(), set()
    for number in range(7):
        from_stop, to_stop = chance.sample(stops, 2)
        ride = fleet.book(from_stop, to_stop, chance.randint(1, 4))
        if number % 4 == 1:
            absent.add(ride.ride_id)
            for shuttle in fleet.shuttles:
                shuttle.no_shows.add(ride.ride_id)
        elif number % 4 == 2 and ride.state is RideState.ASSIGNED:
            gone.add(ride.ride_id)
            campus.do(lambda uow, ride=ride: rides.cancel(uow, ride.ride_id, "passenger"))
        for step in range(chance.randint(10, 50)):
            fleet.step()
            shuttle = chance.choice(fleet.shuttles)
            if chance.random() < 0.02 and shuttle.vehicle_id not in back_at:
                shuttle.hold() if chance.random() < 0.5 else shuttle.disconnect()
                back_at[shuttle.vehicle_id] = step + chance.randint(5, 40)
            for other in fleet.shuttles:
                if back_at.get(other.vehicle_id, 999) <= step:
                    del back_at[other.vehicle_id]
                    other.recover()
    for shuttle in fleet.shuttles:
        shuttle.recover()
    fleet.run_until_idle(6000.0)
    for ride in fleet.rides():
        if ride.state is RideState.REFUSED:
            continue
        wanted = (
            RideState.NO_SHOW
            if ride.ride_id in absent
            else RideState.CANCELLED
            if ride.ride_id in gone
            else RideState.COMPLETED
        )
        assert ride.state is wanted
    assert not any(shuttle.aboard for shuttle in fleet.shuttles)
    campus.close()


@pytest.mark.long
def test_the_morning_timetable_is_kept_and_never_left_early() -> None:
    """Table 1 of the Snow Lion paper: five trips between 08:00 and 10:00, local time."""
    road_map = shipped_map("snow-lion")
    before_eight = datetime.fromisoformat("2026-11-23T07:35:00+08:00")
    campus = CampusUnderTest(road_map, now=before_eight)
    fleet = FakeFleet(campus, road_map, 3).start()
    left: dict[tuple[str, str], datetime] = {}
    calls: dict[str, tuple[str, str]] = {}
    while campus.clock.now() < before_eight + timedelta(hours=2, minutes=35):
        if campus.clock.now().second < 4:
            campus.do(departures.plan_departures)
        for plan in campus.read(lambda uow: uow.plans.all()):
            calls |= {v.visit_id: (v.departure_id, v.stop_id) for v in plan.visits if v.departure_id}
        fleet.step()
        for shuttle in fleet.shuttles:
            for visit_id, state in shuttle.states.items():
                if state == "done" and visit_id in calls:
                    left.setdefault(calls[visit_id], campus.clock.now())
    entered = campus.read(lambda uow: uow.views.departures())
    morning = [trip for trip in road_map.timetable if trip.trip_id.startswith("morning")]
    assert len(entered) == len(morning) == 5
    for departure in entered:
        assert departure.state is DepartureState.DONE
        for call in departure.calls:
            late_s = (left[(departure.departure_id, call.stop_id)] - call.leave_at).total_seconds()
            assert 0.0 <= late_s <= 60.0
    campus.close()
