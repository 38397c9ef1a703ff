"""The timetable as operators edit it: versions of all trips, what is wrong with one, and what differs."""

from collections import Counter
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass
from datetime import datetime
from itertools import pairwise

from contract.roads.model import TimetableTrip
from server.domain.errors import TimetableInvalid
from server.domain.service.service import CLOSES_S_MAX

TRIPS_MAX = 500
CALLS_MAX = 60
# Of the map that is in force, before any operator has changed it.
MAPS_OWN_REVISION = 0


@dataclass(frozen=True, slots=True)
class Timetable:
    """One version of the timetable; the newest one is in force.

    revision  counts its versions: a change names the revision that it was made of, so that none is lost
    note      why it was changed
    """

    campus_id: str
    revision: int
    trips: tuple[TimetableTrip, ...]
    made_by: str = ""
    made_at: datetime | None = None
    note: str = ""


@dataclass(frozen=True, slots=True)
class TimetableVersion:
    """A version without its trips."""

    revision: int
    trips: int
    made_by: str
    made_at: datetime
    note: str


@dataclass(frozen=True, slots=True)
class TripChanges:
    """Ids of trips, sorted."""

    added: tuple[str, ...]
    removed: tuple[str, ...]
    changed: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class UnservedTrip:
    """A trip that does not run: the map in force has not all of its stops. missing_stops: each once."""

    trip_id: str
    missing_stops: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class TightLeg:
    """A leg of a trip that takes longer than the trip gives it.

    leaves_s   at the first of the two stops, in seconds after local midnight
    given_s    between the two times of the trip
    needed_s   driving on an empty campus at that hour, infinite where no road leads there, and the stop at
               the second one unless the trip ends there
    """

    trip_id: str
    from_stop: str
    to_stop: str
    leaves_s: int
    given_s: int
    needed_s: float


def unserved_trips(trips: Sequence[TimetableTrip], stops: Collection[str]) -> tuple[UnservedTrip, ...]:
    """In the order of the timetable. stops: ids of the stops of the map in force"""
    found = []
    for trip in trips:
        missing = dict.fromkeys(stop_id for stop_id, _ in trip.calls if stop_id not in stops)
        if missing:
            found.append(UnservedTrip(trip.trip_id, tuple(missing)))
    return tuple(found)


def tight_legs(
    trips: Sequence[TimetableTrip], driving_s: Callable[[str, str, int], float], dwell_s: float
) -> tuple[TightLeg, ...]:
    """The legs that cannot be driven in their times, in the order of the timetable.

    driving_s  of a leg: from stop, to stop, and the second of the day at which it leaves
    """
    found = []
    for trip in trips:
        for number, ((here, leaves_s), (there, next_s)) in enumerate(pairwise(trip.calls), 2):
            needed_s = driving_s(here, there, leaves_s)
            if number < len(trip.calls):
                needed_s += dwell_s
            if needed_s > next_s - leaves_s:
                found.append(TightLeg(trip.trip_id, here, there, leaves_s, next_s - leaves_s, needed_s))
    return tuple(found)


def trip_changes(before: Sequence[TimetableTrip], after: Sequence[TimetableTrip]) -> TripChanges:
    old, new = ({trip.trip_id: trip for trip in trips} for trips in (before, after))
    return TripChanges(
        tuple(sorted(new.keys() - old.keys())),
        tuple(sorted(old.keys() - new.keys())),
        tuple(sorted(name for name in old.keys() & new.keys() if old[name] != new[name])),
    )


def require_sound_trips(
    trips: Sequence[TimetableTrip], stops: Collection[str], services: Collection[str]
) -> None:
    """Raises TimetableInvalid, which names the first trip that cannot run.

    stops, services  ids of the stops of the map, and of the services that have a calendar
    """
    if len(trips) > TRIPS_MAX:
        raise TimetableInvalid(f"a timetable has {TRIPS_MAX} trips at most")
    for name, count in Counter(trip.trip_id for trip in trips).items():
        if count > 1:
            raise TimetableInvalid(f"trip {name}: {count} trips have this id")
    for trip in trips:
        for fault in _faults(trip, stops, services):
            raise TimetableInvalid(f"trip {trip.trip_id}: {fault}")


def _faults(trip: TimetableTrip, stops: Collection[str], services: Collection[str]) -> Iterator[str]:
    if not 2 <= len(trip.calls) <= CALLS_MAX:
        yield f"it needs 2 to {CALLS_MAX} stops"
    if trip.service_id and trip.service_id not in services:
        yield f"no service {trip.service_id} has a calendar"
    for stop_id, second in trip.calls:
        if stop_id not in stops:
            yield f"the map has no stop {stop_id}"
        if not 0 <= second <= CLOSES_S_MAX:
            yield "its times lie between 00:00 and 36:00"
    for (stop_id, second), (next_stop_id, next_second) in pairwise(trip.calls):
        if next_second <= second:
            yield f"it leaves {next_stop_id} no later than {stop_id}"
        if next_stop_id == stop_id:
            yield f"it calls twice in a row at {stop_id}"
