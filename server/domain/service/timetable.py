"""When the campus runs: service hours, and the departures that the timetable fixes for a day."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from datetime import UTC, date, datetime, time, timedelta
from enum import StrEnum
from zoneinfo import ZoneInfo

from contract.roads.model import TimetableTrip

DAY_S = 86_400


class DepartureState(StrEnum):
    PLANNED = "planned"
    ASSIGNED = "assigned"
    DONE = "done"
    MISSED = "missed"
    WITHDRAWN = "withdrawn"


@dataclass(frozen=True, slots=True)
class Call:
    """The shuttle leaves this stop at this time: never earlier, later only if it is late itself."""

    stop_id: str
    leave_at: datetime


@dataclass(frozen=True, slots=True)
class Departure:
    """One timetable trip on one day."""

    campus_id: str
    departure_id: str
    trip_id: str
    calls: tuple[Call, ...]
    state: DepartureState = DepartureState.PLANNED
    vehicle_id: str | None = None
    reason: str = ""

    @property
    def day(self) -> date:
        """The local day on which it runs; its calls may be after midnight."""
        return date.fromisoformat(self.departure_id.rpartition("@")[2])


@dataclass(frozen=True, slots=True)
class Opening:
    """The service runs on a weekday (0 is Monday) from one local time to another; to midnight as 24:00.

    opens_s, closes_s   seconds after local midnight, 0 <= opens_s < closes_s <= 86400
    """

    weekday: int
    opens_s: int
    closes_s: int


@dataclass(frozen=True, slots=True)
class ServiceHours:
    """When rides can be booked by the settings; without openings always. See `service.ServiceCalendar`."""

    timezone: str = "UTC"
    openings: tuple[Opening, ...] = ()


def local_moment(day: date, second: int, zone: ZoneInfo) -> datetime:
    """Seconds after local midnight as UTC; 86400 and more fall on the next day."""
    midnight = datetime.combine(day, time(0), zone)
    return (midnight + timedelta(seconds=second)).astimezone(UTC)


def departures_of(
    campus_id: str, trips: Iterable[TimetableTrip], timezone: str, day: date
) -> tuple[Departure, ...]:
    """The timetable's departures on a local day, in order of their first call."""
    zone = ZoneInfo(timezone)
    departures = [
        Departure(
            campus_id=campus_id,
            departure_id=f"{trip.trip_id}@{day.isoformat()}",
            trip_id=trip.trip_id,
            calls=tuple(Call(stop_id, local_moment(day, second, zone)) for stop_id, second in trip.calls),
        )
        for trip in trips
    ]
    return tuple(sorted(departures, key=lambda departure: (departure.calls[0].leave_at, departure.trip_id)))


def given_to(departure: Departure, vehicle_id: str) -> Departure:
    return replace(departure, state=DepartureState.ASSIGNED, vehicle_id=vehicle_id)


def without_vehicle(departure: Departure) -> Departure:
    return replace(departure, state=DepartureState.PLANNED, vehicle_id=None)


def withdrawn(departure: Departure, reason: str) -> Departure:
    """The operators took its service off this day."""
    return replace(departure, state=DepartureState.WITHDRAWN, vehicle_id=None, reason=reason)


def missed(departure: Departure, reason: str) -> Departure:
    return replace(departure, state=DepartureState.MISSED, vehicle_id=None, reason=reason)
