"""When a timetable departure is entered, given a shuttle, missed, and taken back."""

from collections.abc import Callable, Iterator

import msgspec
import pytest

from contract.roads.load import with_version
from contract.roads.model import TimetableTrip
from server.domain.record.incidents import IncidentKind
from server.domain.service.service import ServiceException
from server.domain.service.timetable import Departure, DepartureState
from server.usecases.fleet import departures, service
from server.usecases.planning.outlooks import seats_left_of
from server.usecases.ports.unit_of_work import UnitOfWork
from tests.server.usecases.campus_under_test import CampusUnderTest
from tests.server.usecases.fake_fleet import FakeFleet
from tests.server.usecases.shipped_maps import shipped_map

# The clock of the tests begins at 08:00.
EIGHT_S = 8 * 3600


def trip(trip_id: str, leaves_after_s: int, *stops: str) -> TimetableTrip:
    """Its calls are five minutes apart."""
    calls = tuple((stop_id, EIGHT_S + leaves_after_s + 300 * n) for n, stop_id in enumerate(stops))
    return TimetableTrip(trip_id, calls, "daily")


@pytest.fixture
def begin() -> Iterator[Callable[..., FakeFleet]]:
    """Makes a campus with a timetable and some shuttles."""
    made: list[FakeFleet] = []

    def _begin(*trips: TimetableTrip, shuttles: int = 1) -> FakeFleet:
        shipped = shipped_map("snow-lion")
        road_map = with_version(msgspec.structs.replace(shipped, timetable=trips, map_version=""))
        fleet = FakeFleet(CampusUnderTest(road_map), road_map, shuttles).start()
        made.append(fleet)
        return fleet

    yield _begin
    for fleet in made:
        fleet.campus.close()


def known(fleet: FakeFleet) -> dict[str, Departure]:
    """By trip, after the departures were planned once more."""
    fleet.campus.do(departures.plan_departures)
    return {one.trip_id: one for one in fleet.campus.read(lambda uow: uow.views.departures())}


def take_off(fleet: FakeFleet) -> None:
    """Nothing runs on the day of the tests."""
    day = fleet.campus.clock.now().date()
    exception = ServiceException("snow-lion", day, "", False, "Founding Day", "ann")
    fleet.campus.do(lambda uow: service.save_exception(uow, exception))


def test_a_departure_gets_its_shuttle_an_hour_before_it_leaves(begin: Callable[..., FakeFleet]) -> None:
    fleet = begin(trip("noon", 2 * 3600, "NN7", "NN20"))
    fleet.campus.clock.advance(3599.0)
    assert known(fleet) == {}
    fleet.campus.clock.advance(1.0)
    assert known(fleet)["noon"].state is DepartureState.ASSIGNED


@pytest.mark.parametrize(("late_s", "entered"), [(0.0, True), (1.0, False)])
def test_a_departure_whose_time_was_over_before_it_was_entered_is_left_out(
    begin: Callable[..., FakeFleet], late_s: float, entered: bool
) -> None:
    fleet = begin(trip("soon", 60, "NN7", "NN20"), shuttles=0)
    fleet.campus.clock.advance(60.0 + late_s)
    assert ("soon" in known(fleet)) is entered


def test_without_a_shuttle_a_departure_is_missed_when_its_tolerance_is_over(
    begin: Callable[..., FakeFleet],
) -> None:
    fleet = begin(trip("soon", 60, "NN7", "NN20"), shuttles=0)
    known(fleet)
    fleet.campus.clock.advance(60.0 + fleet.campus.rules.departure_tolerance_s)
    assert known(fleet)["soon"].state is DepartureState.PLANNED
    fleet.campus.clock.advance(1.0)
    assert known(fleet)["soon"].state is DepartureState.MISSED
    opened = fleet.campus.read(lambda uow: uow.incidents.all_open())
    assert [(one.kind, one.subject) for one in opened] == [
        (IncidentKind.DEPARTURE_MISSED, known(fleet)["soon"].departure_id)
    ]


def test_a_departure_that_comes_up_later_gets_a_shuttle_beside_one_that_has_its_own(
    begin: Callable[..., FakeFleet],
) -> None:
    fleet = begin(trip("first", 1800, "NN7", "NN20"), trip("second", 5000, "NN7", "NN20"))
    assert list(known(fleet)) == ["first"]
    fleet.campus.clock.advance(1400.0)
    assert {one.state for one in known(fleet).values()} == {DepartureState.ASSIGNED}
    assert set(known(fleet)) == {"first", "second"}


def test_past_midnight_a_trip_of_the_day_before_is_still_entered(begin: Callable[..., FakeFleet]) -> None:
    fleet = begin(TimetableTrip("night", (("NN7", 25 * 3600), ("NN20", 25 * 3600 + 300)), "daily"))
    fleet.campus.clock.advance(16.5 * 3600)
    assert known(fleet)["night"].departure_id == "night@2026-11-23"


def test_a_departure_whose_first_call_is_made_goes_on_when_its_day_is_taken_off_and_others_do_not(
    begin: Callable[..., FakeFleet],
) -> None:
    fleet = begin(trip("first", 1500, "NN7", "NN20"), trip("second", 3000, "NN7", "NN20"))
    first = known(fleet)["first"]
    assert first.state is DepartureState.ASSIGNED

    def planned() -> set[tuple[str, int]]:
        (plan,) = fleet.campus.read(lambda uow: uow.plans.all())
        return {(visit.departure_id, visit.call) for visit in plan.visits if visit.departure_id}

    fleet.run_until(lambda: (first.departure_id, 0) not in planned())
    take_off(fleet)
    assert known(fleet)["first"].state is DepartureState.ASSIGNED
    assert known(fleet)["second"].state is DepartureState.WITHDRAWN
    assert planned() == {(first.departure_id, 1)}


def test_a_departure_whose_shuttle_would_have_nowhere_to_rest_waits_for_another_one(
    begin: Callable[..., FakeFleet],
) -> None:
    fleet = begin(trip("first", 1500, "NN7", "NN20"))
    fleet.leave_homeless("shuttle-1")
    assert fleet.campus.do(departures.plan_departures) == ()
    assert known(fleet)["first"].state is DepartureState.PLANNED


def test_the_seats_that_are_left_are_told_for_each_call_that_is_still_to_come(
    begin: Callable[..., FakeFleet],
) -> None:
    fleet = begin(trip("first", 1500, "NN7", "NN20"), trip("second", 90_000, "NN7", "NN20"))
    first = known(fleet)["first"]

    def left() -> tuple[int | None, ...]:
        return fleet.campus.read(lambda uow: seats_left_of(uow, known_departure(uow, first.departure_id)))

    assert left() == (6, 6)
    unassigned = Departure("snow-lion", "second@2026-11-24", "second", first.calls)
    assert fleet.campus.read(lambda uow: seats_left_of(uow, unassigned)) == (None, None)


def known_departure(uow: UnitOfWork, departure_id: str) -> Departure:
    found = uow.departures.get(departure_id)
    assert found is not None
    return found
