"""A stop board: what leaves next, which shuttles come, and nothing of who rides."""

from collections.abc import Callable, Iterator
from datetime import timedelta
from typing import Any

import pytest

from server.domain.errors import StopUnknown
from server.domain.rides.rides import RideState
from server.domain.service.timetable import DepartureState
from server.usecases.fleet import closures
from server.usecases.fleet.closures import CloseRoad
from server.usecases.fleet.departures import plan_departures
from server.usecases.fleet.stop_boards import CLOSURES_AHEAD_S, MISSED_FOR_S, StopBoard, stop_board
from tests.server.usecases.campus_under_test import CampusUnderTest
from tests.server.usecases.fake_fleet import FakeFleet
from tests.server.usecases.fleet.test_departures import begin, trip
from tests.server.usecases.shipped_maps import shipped_map

__all__ = ["begin"]


@pytest.fixture
def fleet() -> Iterator[FakeFleet]:
    campus = CampusUnderTest(shipped_map("snow-lion"))
    yield FakeFleet(campus, shipped_map("snow-lion"), 2).start()
    campus.close()


def board(fleet: FakeFleet, stop_id: str) -> StopBoard:
    return fleet.campus.read(lambda uow: stop_board(uow, stop_id))


def test_a_shuttle_that_comes_for_a_rider_is_shown_with_its_range_and_then_as_here(fleet: FakeFleet) -> None:
    assert board(fleet, "NN20").shuttles == ()
    ride = fleet.book("NN20", "C6", party=2)
    (coming,) = board(fleet, "NN20").shuttles
    outlook = fleet.campus.read(lambda uow: uow.vehicles.get(ride.vehicle_id or ""))
    assert outlook is not None
    assert coming.vehicle_name == outlook.name
    assert coming.expected is not None
    assert coming.expected.earliest <= (ride.pickup_eta or ride.earliest) <= coming.expected.latest
    assert coming.seats_left == outlook.seats - 2
    fleet.run_until(lambda: fleet.ride(ride.ride_id).state is RideState.BOARDING)
    (here,) = board(fleet, "NN20").shuttles
    assert (here.is_here, here.expected) == (True, None)
    fleet.run_until(lambda: fleet.ride(ride.ride_id).state is RideState.ABOARD)
    fleet.run_until(lambda: board(fleet, "NN20").shuttles == (), limit_s=120.0)


def test_no_time_is_told_of_a_shuttle_that_is_out_of_reach(fleet: FakeFleet) -> None:
    ride = fleet.book("NN20", "C6")
    next(s for s in fleet.shuttles if s.vehicle_id == ride.vehicle_id).disconnect()
    (coming,) = board(fleet, "NN20").shuttles
    assert (coming.expected, coming.is_here) == (None, False)


def test_departures_are_those_of_the_timetable_from_now_on_with_the_last_one_marked(
    begin: Callable[..., FakeFleet],
) -> None:
    fleet = begin(
        trip("later", 1_800, "NN20", "NN7", "C6"),
        trip("sooner", 600, "NN20", "C6"),
        trip("past", -7_200, "NN20", "C6"),
        trip("elsewhere", 900, "NN7", "C6"),
        shuttles=0,
    )
    shown = board(fleet, "NN20").departures
    assert [(row.trip_id, row.to_stop, row.is_last) for row in shown] == [
        ("sooner", "C6", False),
        ("later", "C6", True),
    ]
    assert board(fleet, "C6").departures == (), "trips end there"
    assert [row.expected for row in shown] == [None, None]


def test_a_departure_with_a_shuttle_is_expected_not_before_its_time_and_goes_when_it_has_left(
    begin: Callable[..., FakeFleet],
) -> None:
    fleet = begin(trip("morning", 600, "NN20", "C6"))
    fleet.campus.do(plan_departures)
    (row,) = board(fleet, "NN20").departures
    leave_at = row.leave_at
    assert row.vehicle_name
    assert row.expected is not None
    assert row.expected.earliest >= leave_at
    assert board(fleet, "NN20").shuttles == (), "it is shown once"
    fleet.run_until(lambda: board(fleet, "NN20").departures == (), 3_600.0)
    assert leave_at <= fleet.campus.clock.now() < leave_at + timedelta(minutes=2)


def test_a_departure_that_was_missed_is_shown_as_such_for_a_while(begin: Callable[..., FakeFleet]) -> None:
    fleet = begin(trip("morning", 60, "NN20", "C6"), shuttles=0)
    fleet.campus.do(plan_departures)
    fleet.campus.clock.advance(300.0)
    fleet.campus.do(plan_departures)
    assert [row.state for row in board(fleet, "NN20").departures] == [DepartureState.MISSED]
    fleet.campus.clock.advance(MISSED_FOR_S)
    assert board(fleet, "NN20").departures == ()


def test_a_stop_that_the_map_does_not_have_is_refused(fleet: FakeFleet) -> None:
    with pytest.raises(StopUnknown):
        board(fleet, "nowhere")


def test_closures_that_concern_the_stop_are_told_before_they_begin_and_others_are_not(
    fleet: FakeFleet,
) -> None:
    now = fleet.campus.clock.now()
    stop = fleet.network.stops["C6"]
    later = now + timedelta(seconds=CLOSURES_AHEAD_S / 2)
    far = now + timedelta(seconds=2 * CLOSURES_AHEAD_S)

    def close(**wish: Any) -> None:
        fleet.campus.do(lambda uow: closures.close(uow, CloseRoad((stop.lane_id,), **wish), "ann"))

    close(reason="Marathon", starts_at=far)
    assert board(fleet, "C6").closures == ()
    close(reason="Road works", starts_at=later, ends_at=far)
    (told,) = board(fleet, "C6").closures
    assert (told.reason, told.starts_at, told.ends_at) == ("Road works", later, far)
    assert told.is_served is False
    assert board(fleet, "NN20").closures == ()
