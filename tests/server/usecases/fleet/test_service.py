"""The service's days and hours as bookings and departures meet them."""

from dataclasses import replace
from datetime import date, timedelta

import msgspec
import pytest

from contract.roads.load import with_version
from contract.roads.model import TimetableTrip
from server.domain.errors import ExceptionUnknown, NoService, PatternInUse, PatternUnknown
from server.domain.rides.rides import RideState
from server.domain.service.service import Hours, ServiceException, ServicePattern
from server.domain.service.timetable import DepartureState
from server.usecases.fleet import departures, service
from server.usecases.record import calendars
from tests.server.usecases.campus_under_test import CampusUnderTest
from tests.server.usecases.fake_fleet import FakeFleet
from tests.server.usecases.shipped_maps import shipped_map

MONDAY = date(2026, 11, 23)
EIGHT = 8 * 3600


def pattern(service_id: str, *hours: Hours, weekdays: tuple[int, ...] = tuple(range(7))) -> ServicePattern:
    return ServicePattern("snow-lion", service_id, service_id, weekdays, hours=hours)


def open_for(campus: CampusUnderTest, minutes: int) -> None:
    """The clock shows 08:00."""
    hours = Hours(EIGHT, EIGHT + 60 * minutes)
    campus.do(lambda uow: service.save_pattern(uow, pattern("rides", hours), "ann"))


def holiday(campus: CampusUnderTest, day: date, service_id: str = "", runs: bool = False) -> None:
    exception = ServiceException("snow-lion", day, service_id, runs, "Founding Day", "ann")
    campus.do(lambda uow: service.save_exception(uow, exception))


def test_a_map_brings_its_services_and_keeps_what_operators_made_of_them(campus: CampusUnderTest) -> None:
    (daily,) = campus.read(lambda uow: uow.service.patterns())
    assert (daily.service_id, daily.weekdays) == ("daily", tuple(range(7)))
    workdays = replace(daily, weekdays=(0, 1, 2, 3, 4), starts_on=MONDAY, hours=(Hours(0, 90_000),))
    campus.do(lambda uow: service.save_pattern(uow, workdays, "ann"))
    campus.do(lambda uow: service.enter_services(uow, shipped_map("snow-lion")))
    assert campus.read(lambda uow: uow.service.patterns()) == (workdays,)


def test_the_last_run_and_the_last_call_at_each_stop_are_known(campus: CampusUnderTest) -> None:
    today = campus.read(calendars.service_day)
    assert today.day == MONDAY
    assert len(today.departures) == 13
    assert today.last_run is not None
    assert today.last_run.trip_id == "evening-3"
    zone = campus.read(calendars.calendar_of).zone
    clocks = {stop: f"{at.astimezone(zone):%H:%M}" for stop, at in today.last_calls.items()}
    assert (clocks["NN7"], clocks["SE13"], clocks["C1"]) == ("18:10", "18:32", "18:43")


def test_a_ride_that_cannot_end_before_closing_is_refused_and_names_the_next_opening(
    fleet: FakeFleet,
) -> None:
    open_for(fleet.campus, 2)
    with pytest.raises(NoService, match=r"closes at 08:02.*Tuesday 24 November 08:00"):
        fleet.book("NN7", "C1")
    fleet.campus.clock.advance(180.0)
    with pytest.raises(NoService, match="Tuesday 24 November 08:00"):
        fleet.book("NN7", "NN20")


def test_a_ride_that_only_a_shuttle_far_away_could_make_in_time_is_refused_as_no_service(
    fleet: FakeFleet,
) -> None:
    free = fleet.book("1B", "C1")
    assert free.arrival_eta is not None
    planned_s = (free.arrival_eta - fleet.campus.clock.now()).total_seconds()
    open_for(fleet.campus, int(planned_s / 60) - 1)
    ride = fleet.book("1B", "C1", 4)
    assert (ride.state, ride.reason) == (RideState.REFUSED, "no_service")
    assert "Tuesday 24 November" in ride.reason_detail


def test_no_arrival_is_promised_for_after_closing(fleet: FakeFleet) -> None:
    free = fleet.book("NN7", "C6")
    assert free.arrival_eta is not None
    assert free.promise is not None
    planned_s = (free.arrival_eta - fleet.campus.clock.now()).total_seconds()
    minutes = int(planned_s / 60) + 1
    closes = fleet.campus.clock.now() + timedelta(minutes=minutes)
    assert free.promise.arrive_by > closes, "the promise leaves room, which closing takes away"
    open_for(fleet.campus, minutes)
    ride = fleet.book("NN7", "C6")
    assert ride.state is RideState.ASSIGNED
    assert ride.promise is not None
    assert ride.promise.arrive_by <= closes


def test_a_promised_ride_is_kept_past_closing_when_its_shuttle_is_lost(driven_fleet: FakeFleet) -> None:
    fleet = driven_fleet
    open_for(fleet.campus, 30)
    ride = fleet.book("NN20", "C6")
    assert ride.arrive_before is not None
    shuttle = next(s for s in fleet.shuttles if s.vehicle_id == ride.vehicle_id)
    shuttle.disconnect()
    shuttle.mode = "held"
    fleet.campus.clock.advance(1801.0)
    for _ in range(70):
        fleet.step()
    assert fleet.ride(ride.ride_id).state in (RideState.ASSIGNED, RideState.BOARDING, RideState.ABOARD)
    shuttle.recover()
    fleet.run_until_idle(6000.0)
    assert fleet.ride(ride.ride_id).state is RideState.COMPLETED


def test_on_a_holiday_nothing_runs_but_what_has_an_exception_of_its_own(campus: CampusUnderTest) -> None:
    holiday(campus, MONDAY)
    assert campus.read(calendars.service_day).departures == ()
    assert campus.do(departures.plan_departures) == ()
    holiday(campus, MONDAY, "daily", runs=True)
    assert len(campus.read(calendars.service_day).departures) == 13


def test_departures_of_a_day_that_is_taken_off_are_withdrawn_and_come_back_with_it(fleet: FakeFleet) -> None:
    campus = fleet.campus
    campus.clock.advance(-1200.0)
    assigned = campus.do(departures.plan_departures)
    assert assigned[0].trip_id == "morning-1"
    holiday(campus, MONDAY)
    first = campus.read(lambda uow: uow.departures.get(assigned[0].departure_id))
    assert first is not None
    assert (first.state, first.vehicle_id) == (DepartureState.WITHDRAWN, None)
    plans = campus.read(lambda uow: uow.plans.all())
    assert not any(visit.departure_id for plan in plans for visit in plan.visits)
    campus.do(lambda uow: service.remove_exception(uow, MONDAY, "", "ann"))
    campus.do(departures.plan_departures)
    again = campus.read(lambda uow: uow.departures.get(assigned[0].departure_id))
    assert again is not None
    assert again.state is DepartureState.ASSIGNED


def test_a_departure_that_has_begun_is_made_though_its_day_is_taken_off(driven_fleet: FakeFleet) -> None:
    fleet = driven_fleet
    fleet.campus.clock.advance(-1200.0)
    (departure, *_) = fleet.campus.do(departures.plan_departures)
    shuttle = next(s for s in fleet.shuttles if s.vehicle_id == departure.vehicle_id)
    fleet.run_until(lambda: "under_way" in shuttle.states.values())
    holiday(fleet.campus, MONDAY)
    kept = fleet.campus.read(lambda uow: uow.departures.get(departure.departure_id))
    assert kept is not None
    assert (kept.state, kept.vehicle_id) == (DepartureState.ASSIGNED, departure.vehicle_id)


def test_a_departure_for_which_there_is_no_shuttle_yet_is_withdrawn_with_its_day(
    campus: CampusUnderTest,
) -> None:
    campus.clock.advance(-1200.0)
    assert campus.do(departures.plan_departures) == ()
    waiting = campus.read(lambda uow: uow.departures.unfinished())
    assert [made.state for made in waiting] == [DepartureState.PLANNED] * len(waiting)
    assert waiting
    holiday(campus, MONDAY)
    assert campus.read(lambda uow: uow.departures.unfinished()) == ()


def test_a_trip_past_midnight_is_entered_though_its_day_is_over() -> None:
    trip = TimetableTrip("night", (("NN7", 24 * 3600 + 600), ("NN20", 24 * 3600 + 900)), "late")
    changed = msgspec.structs.replace(shipped_map("snow-lion"), timetable=(trip,), map_version="")
    night = with_version(changed)
    campus = CampusUnderTest(night)
    campus.clock.advance(16 * 3600 - 1800.0)
    fleet = FakeFleet(campus, night, 2).start()
    assert [d.departure_id for d in campus.do(departures.plan_departures)] == ["night@2026-11-23"]
    fleet.campus.close()


def test_what_is_not_there_cannot_be_changed_and_what_is_used_not_removed(campus: CampusUnderTest) -> None:
    with pytest.raises(PatternUnknown):
        holiday(campus, MONDAY, "no-such")
    with pytest.raises(PatternUnknown):
        campus.do(lambda uow: service.remove_pattern(uow, "no-such", "ann"))
    with pytest.raises(PatternInUse, match="13 trips"):
        campus.do(lambda uow: service.remove_pattern(uow, "daily", "ann"))
    with pytest.raises(ExceptionUnknown):
        campus.do(lambda uow: service.remove_exception(uow, MONDAY, "", "ann"))


def test_a_removed_pattern_takes_its_exceptions_along(campus: CampusUnderTest) -> None:
    open_for(campus, 60)
    holiday(campus, MONDAY, "rides")
    campus.do(lambda uow: service.remove_pattern(uow, "rides", "ann"))
    assert campus.read(lambda uow: uow.service.exceptions()) == ()


def test_rides_booked_before_a_day_was_taken_off_are_kept_and_counted(fleet: FakeFleet) -> None:
    tomorrow = fleet.campus.clock.now() + timedelta(days=1)
    ride = fleet.book("NN20", "C6", earliest=tomorrow)
    assert ride.state is RideState.ASSIGNED
    holiday(fleet.campus, MONDAY + timedelta(days=1))
    assert fleet.campus.read(service.rides_outside) == 1
    assert fleet.ride(ride.ride_id).state is RideState.ASSIGNED
