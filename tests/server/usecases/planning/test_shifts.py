"""Shuttles that are on duty at some hours only: nothing new outside of them, and everybody home first."""

from collections.abc import Iterator
from datetime import date, timedelta

import pytest

from server.domain.errors import ShiftsInvalid
from server.domain.fleet.shifts import DutyException, Shift, Shifts
from server.domain.rides.rides import RideState
from server.usecases.fleet import vehicles
from server.usecases.planning import plans
from server.usecases.planning.snapshot import seconds, take_snapshot
from server.usecases.rides import rides
from tests.server.usecases.campus_under_test import MORNING, CampusUnderTest
from tests.server.usecases.fake_fleet import FakeFleet
from tests.server.usecases.shipped_maps import shipped_map

HOUR_S = 3600
# The clock of the tests begins on Monday 23 November 2026 at 08:00 in Shanghai.
MONDAY = date(2026, 11, 23)


def daily(*hours: tuple[float, float], exceptions: tuple[DutyException, ...] = ()) -> Shifts:
    day = tuple(Shift(int(begins * HOUR_S), int(ends * HOUR_S)) for begins, ends in hours)
    return Shifts((day,) * 7, exceptions)


def set_shifts(fleet: FakeFleet, shifts: Shifts | None) -> None:
    for shuttle in fleet.shuttles:
        fleet.campus.do(
            lambda uow, name=shuttle.vehicle_id: vehicles.set_shifts(uow, name, shifts, "ann")  # type: ignore[misc]
        )


@pytest.fixture
def one_shuttle() -> Iterator[FakeFleet]:
    made = CampusUnderTest(shipped_map("snow-lion"))
    fleet = FakeFleet(made, shipped_map("snow-lion"), 1).start()
    fleet.shuttles[0].speed_mps = 6.0
    yield fleet
    made.close()


def test_shifts_that_contradict_the_clock_are_refused(fleet: FakeFleet) -> None:
    twice = DutyException(MONDAY), DutyException(MONDAY)
    for shifts in (
        daily((9, 8)),
        daily((25, 26)),
        daily((8, 37)),
        Shifts(((),) * 6),
        daily((8, 9), exceptions=twice),
    ):
        with pytest.raises(ShiftsInvalid):
            set_shifts(fleet, shifts)


def test_on_duty_a_ride_is_taken_as_ever(fleet: FakeFleet) -> None:
    plain = fleet.book("NN20", "C6")
    assert plain.state is RideState.ASSIGNED
    set_shifts(fleet, daily((7, 20)))
    assert fleet.book("NN20", "C6").state is RideState.ASSIGNED


def test_a_ride_that_would_end_after_the_shift_is_refused_and_one_in_the_next_shift_taken(
    fleet: FakeFleet,
) -> None:
    set_shifts(fleet, daily((7, 8.2)))
    refused = fleet.book("NN20", "C1")
    assert (refused.state, refused.reason) == (RideState.REFUSED, "no_vehicle_free")
    for days in (1, 3):
        tomorrow = fleet.campus.clock.now() + timedelta(days=days)
        taken = fleet.book("NN20", "C6", earliest=tomorrow - timedelta(minutes=30))
        assert taken.state is RideState.ASSIGNED
        assert taken.arrival_eta is not None
        assert taken.arrival_eta <= tomorrow + timedelta(minutes=12)
    between = fleet.book("NN20", "C6", earliest=fleet.campus.clock.now() + timedelta(hours=6))
    assert (between.state, between.reason) == (RideState.REFUSED, "no_vehicle_free")
    made = [v for plan in fleet.campus.read(lambda uow: uow.plans.all()) for v in plan.visits]
    assert sum(len(visit.board) for visit in made) == 2


@pytest.mark.parametrize(("spare", "taken"), [(0.5, False), (1.3, True)])
def test_a_shift_s_last_ride_leaves_time_for_the_way_home(
    one_shuttle: FakeFleet, spare: float, taken: bool
) -> None:
    fleet = one_shuttle
    probe = fleet.book("NN20", "C6")
    assert probe.arrival_eta is not None
    fleet.campus.do(lambda uow: rides.cancel(uow, probe.ride_id, "passenger"))
    home_s = fleet.campus.read(
        lambda uow: uow.roads().way_home_s() * uow.travel_time_factor_at(uow.now) + uow.rules.dwell_s
    )
    begun = MORNING - timedelta(hours=8)
    ends_s = (probe.arrival_eta - begun).total_seconds() + spare * home_s
    set_shifts(fleet, daily((7, ends_s / HOUR_S)))
    assert (fleet.book("NN20", "C6").state is RideState.ASSIGNED) is taken


def test_off_duty_a_shuttle_takes_rides_for_its_next_shift_only(fleet: FakeFleet) -> None:
    set_shifts(fleet, daily((10, 18)))
    now = fleet.book("NN20", "C6")
    assert (now.state, now.reason) == (RideState.REFUSED, "no_vehicle_free")
    begins = fleet.campus.clock.now() + timedelta(hours=2)
    early = fleet.book("NN20", "C6", earliest=begins - timedelta(minutes=5))
    assert early.state is RideState.ASSIGNED
    assert early.pickup_eta is not None
    assert early.pickup_eta >= begins


def test_off_duty_with_a_visit_still_to_make_a_shuttle_takes_no_ride_of_its_next_shift(
    one_shuttle: FakeFleet,
) -> None:
    """It is on its way to the pickup, and has no rider aboard."""
    fleet = one_shuttle
    assert fleet.book("NN20", "C6").state is RideState.ASSIGNED
    fleet.step()
    set_shifts(fleet, daily((10, 18)))
    later = fleet.book("C6", "NN20", earliest=fleet.campus.clock.now() + timedelta(hours=3))
    assert (later.state, later.reason) == (RideState.REFUSED, "no_vehicle_free")


def test_between_two_shifts_a_shuttle_stays_where_its_last_call_was_until_the_next_one_begins(
    one_shuttle: FakeFleet,
) -> None:
    fleet = one_shuttle
    fleet.book("NN20", "C6")
    set_shifts(fleet, daily((7, 9), (10, 18)))
    again_at = fleet.campus.clock.now() + timedelta(hours=2)
    later = fleet.book("C6", "NN20", earliest=again_at)
    assert later.state is RideState.ASSIGNED
    assert later.pickup_eta is not None
    assert later.pickup_eta - again_at < timedelta(minutes=1), "it is at C6 already"
    calls = fleet.campus.read(take_snapshot).problem.vehicles[0].calls
    number, off = next((n, call) for n, call in enumerate(calls) if call.off_duty)
    assert number == 2
    assert off.place == calls[1].place == calls[3].place
    assert off.leave_from_s == seconds(again_at)
    home_s = fleet.campus.read(lambda uow: uow.roads().way_home_s() * uow.travel_time_factor_at(uow.now))
    assert off.leave_from_s - off.dwell_s == pytest.approx(off.arrive_by_s)
    assert off.arrive_by_s == pytest.approx(seconds(again_at) - HOUR_S - home_s)


def test_a_day_off_and_a_day_with_other_hours(fleet: FakeFleet) -> None:
    tuesday = DutyException(MONDAY + timedelta(days=1), (Shift(12 * HOUR_S, 13 * HOUR_S),))
    set_shifts(fleet, daily((7, 20), exceptions=(DutyException(MONDAY), tuesday)))
    assert fleet.book("NN20", "C6").reason == "no_vehicle_free"
    morning = fleet.campus.clock.now() + timedelta(days=1)
    assert fleet.book("NN20", "C6", earliest=morning).reason == "no_vehicle_free"
    noon = morning + timedelta(hours=4)
    assert fleet.book("NN20", "C6", earliest=noon).state is RideState.ASSIGNED
    set_shifts(fleet, None)
    assert fleet.book("NN20", "C6").state is RideState.ASSIGNED


def test_who_is_aboard_is_brought_home_after_the_shift_and_the_shuttle_rests(
    one_shuttle: FakeFleet,
) -> None:
    fleet = one_shuttle
    ride = fleet.book("NN7", "C6")
    fleet.run_until(lambda: fleet.ride(ride.ride_id).state is RideState.ABOARD)
    set_shifts(fleet, daily((4, 8)))
    assert fleet.book("NN20", "C1").reason == "no_vehicle_free"
    tomorrow = fleet.campus.clock.now() + timedelta(hours=21)
    for _ in range(3600):
        if fleet.ride(ride.ride_id).has_ended:
            break
        fleet.campus.do(plans.refresh_expected)
        fleet.step()
    assert fleet.ride(ride.ride_id).state is RideState.COMPLETED
    fleet.run_until_idle(3600.0)
    plan = fleet.campus.read(lambda uow: uow.plans.all())[0]
    assert not [visit for visit in plan.visits if visit.kind == "stop"]
    assert fleet.book("NN20", "C6").reason == "no_vehicle_free"
    assert fleet.book("NN20", "C6", earliest=tomorrow).state is RideState.ASSIGNED


def test_a_ride_of_the_next_shift_is_made_in_it(one_shuttle: FakeFleet) -> None:
    fleet = one_shuttle
    set_shifts(fleet, daily((7, 9), (10, 18)))
    earliest = fleet.campus.clock.now() + timedelta(hours=2, minutes=20)
    ride = fleet.book("NN20", "C6", earliest=earliest)
    assert ride.state is RideState.ASSIGNED
    for _ in range(30):
        fleet.step()
        fleet.campus.do(plans.refresh_expected)
    assert fleet.ride(ride.ride_id).state is RideState.ASSIGNED
    fleet.campus.clock.advance((earliest - fleet.campus.clock.now()).total_seconds() - 900.0)
    fleet.run_until(lambda: fleet.ride(ride.ride_id).has_ended)
    done = fleet.ride(ride.ride_id)
    assert done.state is RideState.COMPLETED
    assert not done.promise_broken
    assert done.promise == ride.promise
