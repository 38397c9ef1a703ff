"""A road closes and cuts a timetable departure's calls off."""

from collections.abc import Iterator

import msgspec
import pytest

from contract.roads.load import with_version
from contract.roads.model import TimetableTrip
from server.domain.planning.plans import PlannedVisit
from server.domain.record.incidents import IncidentKind
from server.domain.service.timetable import DepartureState
from server.usecases.fleet import closures, departures
from server.usecases.fleet.closures import CloseRoad
from tests.server.usecases.campus_under_test import CampusUnderTest
from tests.server.usecases.fake_fleet import FakeFleet
from tests.server.usecases.shipped_maps import shipped_map

# The lane at which the last call, C6, lies.
AT_C6 = ("east-4",)
QUARTER_PAST_EIGHT_S = 8 * 3600 + 900


@pytest.fixture
def fleet() -> Iterator[FakeFleet]:
    """Two shuttles; one has the only trip of the day, which leaves in a quarter of an hour."""
    shipped = shipped_map("snow-lion")
    calls = tuple(
        (stop_id, QUARTER_PAST_EIGHT_S + after_s)
        for stop_id, after_s in (("NN7", 0), ("NN20", 300), ("C6", 900))
    )
    trip = TimetableTrip("round", calls, shipped.timetable[0].service_id)
    road_map = with_version(msgspec.structs.replace(shipped, timetable=(trip,), map_version=""))
    made = FakeFleet(CampusUnderTest(road_map), road_map, 2).start()
    made.campus.do(departures.plan_departures)
    yield made
    made.campus.close()


def close(fleet: FakeFleet) -> None:
    wish = CloseRoad(AT_C6, reason="water main")
    fleet.campus.do(lambda uow: closures.close(uow, wish, "ann"))
    fleet.campus.do(closures.update_closures)


def calls_planned(fleet: FakeFleet) -> list[PlannedVisit]:
    plans = fleet.campus.read(lambda uow: uow.plans.all())
    return [visit for plan in plans for visit in plan.visits if visit.departure_id]


def test_a_departure_that_has_not_begun_is_taken_from_its_shuttle_whole_and_planned_anew(
    fleet: FakeFleet,
) -> None:
    assert [visit.stop_id for visit in calls_planned(fleet)] == ["NN7", "NN20", "C6"]
    close(fleet)
    assert calls_planned(fleet) == []
    (departure,) = fleet.campus.read(lambda uow: uow.views.departures())
    assert (departure.state, departure.vehicle_id) == (DepartureState.PLANNED, None)
    (closure,) = fleet.campus.read(lambda uow: uow.closures.standing())
    fleet.campus.do(lambda uow: closures.lift(uow, closure.closure_id, "ann"))
    fleet.campus.do(departures.plan_departures)
    assert [visit.stop_id for visit in calls_planned(fleet)] == ["NN7", "NN20", "C6"]


def test_a_departure_that_has_begun_makes_the_calls_that_are_left_and_its_end_is_missed(
    fleet: FakeFleet,
) -> None:
    fleet.run_until(lambda: [visit.call for visit in calls_planned(fleet)] == [1, 2])
    close(fleet)
    assert [visit.stop_id for visit in calls_planned(fleet)] == ["NN20"]
    (departure,) = fleet.campus.read(lambda uow: uow.views.departures())
    assert departure.state is DepartureState.MISSED
    opened = fleet.campus.read(lambda uow: uow.incidents.all_open())
    (missed,) = (one for one in opened if one.kind is IncidentKind.DEPARTURE_MISSED)
    assert "its end is cut off: closure closure-1 (water main)" in missed.cause
