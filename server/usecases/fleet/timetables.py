"""The timetable, edited by operators: saved by revision, kept in versions, tried before it is saved."""

from collections.abc import Sequence
from dataclasses import dataclass
from zoneinfo import ZoneInfo

from contract.roads.model import TimetableTrip
from server.domain.errors import TimetableChanged, TimetableUnknown
from server.domain.service.timetable import Departure, local_moment
from server.domain.service.trips import (
    MAPS_OWN_REVISION,
    TightLeg,
    Timetable,
    TripChanges,
    require_sound_trips,
    tight_legs,
    trip_changes,
)
from server.usecases.fleet import departures
from server.usecases.ports import topics
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.calendars import calendar_of, timetable_of
from server.usecases.record.server_events import record_event


@dataclass(frozen=True, slots=True)
class TimetableEffect:
    """What a version changes.

    withdrawn  departures of the coming hour that are taken back, with the shuttle that each had; one whose
               trip only changes is entered again with its new times
    kept       departures that have begun: they run as they were
    tight      legs that take longer than their trips give them: the shuttle would be late there every day
    """

    changes: TripChanges
    withdrawn: tuple[Departure, ...]
    kept: tuple[Departure, ...]
    tight: tuple[TightLeg, ...] = ()


def save_timetable(
    uow: UnitOfWork, trips: Sequence[TimetableTrip], revision: int, note: str, by: str
) -> tuple[Timetable, TimetableEffect]:
    """Put a new version in force. revision: of the version that it was made of.

    Raises TimetableChanged (another operator was first), TimetableInvalid, CampusUnknown.
    """
    before = timetable_of(uow)
    if before.revision != revision:
        raise TimetableChanged(
            f"{before.made_by} has changed the timetable since (revision {before.revision}, yours is "
            f"{revision}); load it, or save yours as a version after it"
        )
    stops = {stop.stop_id for stop in uow.network().road_map.stops}
    services = {pattern.service_id for pattern in uow.service.patterns()}
    require_sound_trips(trips, stops, services)
    after = Timetable(uow.campus_id, revision + 1, tuple(trips), by, uow.now, note)
    uow.service.add_timetable(after)
    withdrawn, kept = departures.withdraw_changed(uow)
    departures.withdraw_unserved(uow, calendar_of(uow))
    departures.note_unserved(uow)
    record_event(uow, "timetable.changed", str(after.revision), by, note)
    uow.publish(topics.service(uow.campus_id))
    changes = trip_changes(before.trips, after.trips)
    return after, TimetableEffect(changes, withdrawn, kept, tight_legs_of(uow, trips))


def tight_legs_of(uow: UnitOfWork, trips: Sequence[TimetableTrip]) -> tuple[TightLeg, ...]:
    """By planned driving on the open roads, at the hours of today. Legs between stops that the map lacks are
    left out. Raises CampusUnknown.
    """
    roads = uow.roads().every_road
    today = calendar_of(uow).day_of(uow.now)
    zone = ZoneInfo(roads.network.road_map.timezone)

    def driving_s(from_stop: str, to_stop: str, second: int) -> float:
        if from_stop not in roads.network.stops or to_stop not in roads.network.stops:
            return 0.0
        factor = uow.travel_time_factor_at(local_moment(today, second, zone))
        return factor * roads.direct_s(from_stop, to_stop)

    return tight_legs(trips, driving_s, uow.rules.dwell_s)


def version_of(uow: UnitOfWork, revision: int) -> Timetable:
    """An earlier version, or the map's own. Raises TimetableUnknown, CampusUnknown."""
    if revision == MAPS_OWN_REVISION:
        return Timetable(uow.campus_id, MAPS_OWN_REVISION, uow.network().road_map.timetable)
    found = uow.service.timetable(revision)
    if found is None:
        raise TimetableUnknown(f"the timetable has no version {revision}")
    return found
