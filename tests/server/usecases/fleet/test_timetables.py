"""Operators edit the timetable: by revision, in versions, and departures follow."""

import math
from collections.abc import Callable, Sequence

import msgspec
import pytest

from contract.roads.load import encode_map, with_version
from contract.roads.model import TimetableTrip
from server.domain.errors import TimetableChanged, TimetableInvalid, TimetableUnknown
from server.domain.service.timetable import DepartureState
from server.domain.service.trips import TripChanges, UnservedTrip
from server.usecases.fleet import campus as campuses
from server.usecases.fleet import departures, timetables
from server.usecases.fleet.timetables import TimetableEffect, version_of
from server.usecases.record import calendars, incidents
from server.usecases.record.calendars import timetable_of
from tests.server.usecases.campus_under_test import CampusUnderTest
from tests.server.usecases.fake_fleet import FakeFleet
from tests.server.usecases.fleet.test_departures import begin, known, trip

__all__ = ["begin"]

FIRST, SECOND = trip("first", 600, "NN20", "C6"), trip("second", 1_800, "NN20", "NN7", "C6")


def save(fleet: FakeFleet, trips: Sequence[TimetableTrip], revision: int, by: str = "ann") -> TimetableEffect:
    return fleet.campus.do(lambda uow: timetables.save_timetable(uow, trips, revision, "why", by))[1]


def shown(fleet: FakeFleet) -> list[tuple[str, int]]:
    """Today's trips, with the seconds after eight at which each leaves."""
    day = fleet.campus.read(calendars.service_day)
    begins = fleet.campus.clock.now().replace(minute=0, second=0, microsecond=0)
    return [(one.trip_id, round((one.calls[0].leave_at - begins).total_seconds())) for one in day.departures]


def test_a_saved_timetable_is_in_force_and_the_maps_own_can_be_had_back(
    begin: Callable[..., FakeFleet],
) -> None:
    fleet = begin(FIRST, shuttles=0)
    effect = save(fleet, [SECOND], 0)
    assert effect.changes == TripChanges(("second",), ("first",), ())
    assert shown(fleet) == [("second", 1_800)]
    own = fleet.campus.read(lambda uow: version_of(uow, 0))
    assert own.trips == (FIRST,)
    save(fleet, own.trips, 1)
    assert shown(fleet) == [("first", 600)]
    versions = fleet.campus.read(lambda uow: uow.service.timetable_versions(10))
    assert [(one.revision, one.trips, one.made_by, one.note) for one in versions] == [
        (2, 1, "ann", "why"),
        (1, 1, "ann", "why"),
    ]
    with pytest.raises(TimetableUnknown):
        fleet.campus.read(lambda uow: version_of(uow, 3))


def test_the_second_of_two_operators_is_told_and_neither_version_is_lost(
    begin: Callable[..., FakeFleet],
) -> None:
    fleet = begin(FIRST, shuttles=0)
    save(fleet, [FIRST, SECOND], 0, "ann")
    with pytest.raises(TimetableChanged, match="ann has changed"):
        save(fleet, [], 0, "ben")
    assert fleet.campus.read(timetable_of).trips == (FIRST, SECOND)
    save(fleet, [], 1, "ben")
    assert fleet.campus.read(lambda uow: version_of(uow, 1)).trips == (FIRST, SECOND)


def test_departures_follow_a_change_and_those_under_way_run_on(begin: Callable[..., FakeFleet]) -> None:
    fleet = begin(FIRST, SECOND, shuttles=2)
    assert known(fleet)["first"].state is DepartureState.ASSIGNED
    later = trip("first", 900, "NN20", "C6")
    effect = save(fleet, [later], 0)
    assert effect.changes == TripChanges((), ("second",), ("first",))
    assert sorted(one.trip_id for one in effect.withdrawn) == ["first", "second"]
    assert all(one.vehicle_id for one in effect.withdrawn)
    assert shown(fleet) == [("first", 900)]
    after = known(fleet)
    assert (after["first"].state, after["second"].state) == (
        DepartureState.ASSIGNED,
        DepartureState.WITHDRAWN,
    )
    leave_at = after["first"].calls[0].leave_at
    fleet.run_until(lambda: fleet.campus.clock.now() > leave_at)
    effect = save(fleet, [], 1)
    assert ([one.trip_id for one in effect.kept], effect.withdrawn) == (["first"], ())
    fleet.run_until_idle(3_600.0)
    assert known(fleet)["first"].state is DepartureState.DONE


@pytest.mark.parametrize(
    ("wrong", "why"),
    [
        ([FIRST, FIRST], "2 trips have this id"),
        ([TimetableTrip("t", (("NN20", 0),))], "2 to 60 stops"),
        ([TimetableTrip("t", (("NN20", 0), ("nowhere", 60)))], "no stop nowhere"),
        ([TimetableTrip("t", (("NN20", 60), ("C6", 60)))], "no later than NN20"),
        ([TimetableTrip("t", (("NN20", 0), ("NN20", 60)))], "twice in a row"),
        ([TimetableTrip("t", (("NN20", 0), ("C6", 60)), "night")], "no service night"),
        ([TimetableTrip("t", (("NN20", 0), ("C6", 36 * 3600 + 1)))], "36:00"),
    ],
)
def test_a_trip_that_cannot_run_is_refused_by_name(
    begin: Callable[..., FakeFleet], wrong: list[TimetableTrip], why: str
) -> None:
    fleet = begin(FIRST, shuttles=0)
    with pytest.raises(TimetableInvalid, match=why):
        save(fleet, wrong, 0)


def test_versions_are_stored_on_both_databases(campus: CampusUnderTest) -> None:
    before = campus.read(timetable_of)
    campus.do(lambda uow: timetables.save_timetable(uow, before.trips[:1], before.revision, "fewer", "ann"))
    after = campus.read(timetable_of)
    assert (after.revision, after.trips, after.note) == (before.revision + 1, before.trips[:1], "fewer")
    assert after.made_at == campus.clock.now()


def test_a_leg_that_cannot_be_driven_in_its_time_is_named_with_what_it_takes(
    begin: Callable[..., FakeFleet],
) -> None:
    fleet = begin(FIRST, shuttles=0)
    roads = fleet.campus.read(lambda uow: uow.roads())
    drive_s, dwell_s = roads.direct_s("NN20", "NN7"), fleet.campus.rules.dwell_s
    onward_s = roads.direct_s("NN7", "C6")

    def a_trip(first_s: int, second_s: int) -> TimetableTrip:
        return TimetableTrip(
            "timed", (("NN20", 36_000), ("NN7", 36_000 + first_s), ("C6", 36_000 + second_s))
        )

    ample = math.ceil(drive_s + dwell_s)
    assert save(fleet, [a_trip(ample, ample + math.ceil(onward_s))], 0).tight == ()
    (leg,) = save(fleet, [a_trip(ample - 2, ample + math.ceil(onward_s))], 1).tight
    assert (leg.trip_id, leg.from_stop, leg.to_stop, leg.given_s) == ("timed", "NN20", "NN7", ample - 2)
    assert leg.needed_s == pytest.approx(drive_s + dwell_s)
    (last,) = save(fleet, [a_trip(ample, ample + math.floor(onward_s) - 1)], 2).tight
    assert (last.from_stop, last.to_stop) == ("NN7", "C6")
    assert last.needed_s == pytest.approx(onward_s), "riders get off at the last stop: nothing waits for that"


def test_trips_whose_stops_the_map_lost_are_told_until_they_can_run_again(
    begin: Callable[..., FakeFleet],
) -> None:
    fleet = begin(FIRST, shuttles=0)
    campus = fleet.campus
    save(fleet, [FIRST, SECOND], 0)
    before = campus.road_map
    stops = tuple(stop for stop in before.stops if stop.stop_id != "NN7")
    without = with_version(msgspec.structs.replace(before, stops=stops, timetable=(), map_version=""))
    campus.do(lambda uow: campuses.load_map(uow, encode_map(without), "ann", activate=True))
    assert campus.read(calendars.unserved_of) == (UnservedTrip("second", ("NN7",)),)
    (incident,) = campus.read(lambda uow: uow.views.incidents())
    assert (incident.kind, incident.cause) == ("trips_unserved", "second: the map has no stop NN7")
    campus.do(lambda uow: incidents.close(uow, incident.incident_id, "ann"))
    campus.do(departures.plan_departures)
    assert len(campus.read(lambda uow: uow.views.incidents())) == 1, "as long as it lasts"
    save(fleet, [FIRST], 1)
    assert campus.read(lambda uow: uow.views.incidents()) == ()
