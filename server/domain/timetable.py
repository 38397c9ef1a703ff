"""When the campus runs: service hours, and the departures that the timetable fixes for a day."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from datetime import UTC, date, datetime, time, timedelta
from enum import StrEnum
from zoneinfo import ZoneInfo

from contract.roads.model import TimetableTrip
from server.domain.errors import OutsideServiceHours

_DAYS_SEARCHED = 8


class DepartureState(StrEnum):
    PLANNED = "planned"
    ASSIGNED = "assigned"
    DONE = "done"
    MISSED = "missed"


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
    """When rides can be had. Without openings the campus runs always."""

    timezone: str = "UTC"
    openings: tuple[Opening, ...] = ()

    def is_open(self, at: datetime) -> bool:
        if not self.openings:
            return True
        local = at.astimezone(ZoneInfo(self.timezone))
        second = local.hour * 3600 + local.minute * 60 + local.second
        return any(
            opening.weekday == local.weekday() and opening.opens_s <= second < opening.closes_s
            for opening in self.openings
        )

    def next_opening(self, at: datetime) -> datetime | None:
        """The first moment at or after `at` when rides can be had, UTC; None when there is none."""
        if self.is_open(at):
            return at
        zone = ZoneInfo(self.timezone)
        today = at.astimezone(zone).date()
        for offset in range(_DAYS_SEARCHED):
            day = today + timedelta(days=offset)
            starts = [
                local_moment(day, opening.opens_s, zone)
                for opening in self.openings
                if opening.weekday == day.weekday()
            ]
            later = [start for start in starts if start >= at]
            if later:
                return min(later)
        return None

    def require_open(self, at: datetime) -> None:
        """Raises OutsideServiceHours, naming in local time when rides can be had next."""
        if self.is_open(at):
            return
        opens = self.next_opening(at)
        if opens is None:
            raise OutsideServiceHours("no service hours are set for the coming week")
        local = opens.astimezone(ZoneInfo(self.timezone))
        raise OutsideServiceHours(
            f"no shuttle runs at that time; book for {local:%A %d %B %H:%M} ({self.timezone}) or later"
        )


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


def missed(departure: Departure, reason: str) -> Departure:
    return replace(departure, state=DepartureState.MISSED, vehicle_id=None, reason=reason)
