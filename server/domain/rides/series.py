"""A recurring booking: the same ride on certain weekdays, at one local time, until a last day."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from datetime import date, datetime, timedelta
from enum import StrEnum
from zoneinfo import ZoneInfo

from server.domain.errors import OccurrenceEnded, SeriesEnded
from server.domain.rides.rides import RideSource
from server.domain.service.timetable import local_moment

# About a year and a term.
DAYS_MAX = 550


class SeriesState(StrEnum):
    ACTIVE = "active"
    CANCELLED = "cancelled"
    FINISHED = "finished"


class OccurrenceState(StrEnum):
    """planned: its day is too far ahead; trying: no vehicle could take it yet, and it is tried again."""

    PLANNED = "planned"
    TRYING = "trying"
    BOOKED = "booked"
    SKIPPED = "skipped"
    REFUSED = "refused"
    CANCELLED = "cancelled"


FINAL = frozenset({OccurrenceState.SKIPPED, OccurrenceState.REFUSED, OccurrenceState.CANCELLED})


@dataclass(frozen=True, slots=True)
class BookSeries:
    """A passenger's request. leave_s: seconds after local midnight; weekdays: 0 is Monday."""

    from_stop: str
    to_stop: str
    weekdays: tuple[int, ...]
    leave_s: int
    ends_on: date
    party: int
    wheelchairs: int
    starts_on: date | None = None
    idempotency_key: str | None = None
    source: RideSource = "passenger"


@dataclass(frozen=True, slots=True)
class Series:
    """ticket_key_id: what the link's token is derived from; starts_on and ends_on are both included."""

    campus_id: str
    series_id: str
    ticket_key_id: str
    from_stop: str
    to_stop: str
    party: int
    wheelchairs: int
    weekdays: tuple[int, ...]
    leave_s: int
    starts_on: date
    ends_on: date
    made_at: datetime
    source: RideSource
    state: SeriesState = SeriesState.ACTIVE
    ended_at: datetime | None = None
    idempotency_key: str | None = None

    def days(self, zone: ZoneInfo) -> Iterator[date]:
        """Its days in order, without one whose time had passed when the booking was made."""
        for offset in range((self.ends_on - self.starts_on).days + 1):
            day = self.starts_on + timedelta(days=offset)
            if self.has_day(day, zone):
                yield day

    def has_day(self, day: date, zone: ZoneInfo) -> bool:
        within = self.starts_on <= day <= self.ends_on and day.weekday() in self.weekdays
        return within and self.leaves_at(day, zone) >= self.made_at

    def leaves_at(self, day: date, zone: ZoneInfo) -> datetime:
        """The local time on that day, independent of clock changes."""
        return local_moment(day, self.leave_s, zone)


@dataclass(frozen=True, slots=True)
class Occurrence:
    """One day of a recurring booking. reason: why there is no ride, as a ride's or an error's code."""

    campus_id: str
    series_id: str
    day: date
    leave_at: datetime
    state: OccurrenceState = OccurrenceState.PLANNED
    ride_id: str | None = None
    reason: str = ""
    reason_detail: str = ""
    tried_at: datetime | None = None


def require_active(series: Series) -> None:
    """Raises SeriesEnded."""
    if series.state is not SeriesState.ACTIVE:
        raise SeriesEnded(f"this recurring booking is {series.state} already")


def taken_out(occurrence: Occurrence, by: str) -> Occurrence:
    """Raises OccurrenceEnded."""
    if occurrence.state in FINAL:
        raise OccurrenceEnded(f"the ride on {occurrence.day:%d %B} is {occurrence.state} already")
    return replace(occurrence, state=OccurrenceState.CANCELLED, reason=f"cancelled_by_{by}", reason_detail="")


def booked(occurrence: Occurrence, ride_id: str, at: datetime) -> Occurrence:
    return replace(
        occurrence,
        state=OccurrenceState.BOOKED,
        ride_id=ride_id,
        reason="",
        reason_detail="",
        tried_at=at,
    )


def not_taken(occurrence: Occurrence, reason: str, detail: str, at: datetime) -> Occurrence:
    """No vehicle can take it now: it is tried again until its time has come."""
    is_over = at >= occurrence.leave_at
    state = OccurrenceState.REFUSED if is_over else OccurrenceState.TRYING
    return replace(occurrence, state=state, reason=reason, reason_detail=detail, tried_at=at)


def skipped(occurrence: Occurrence, detail: str, at: datetime) -> Occurrence:
    return replace(
        occurrence, state=OccurrenceState.SKIPPED, reason="holiday", reason_detail=detail, tried_at=at
    )
