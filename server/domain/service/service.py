"""On which days and at which hours the campus runs: patterns of weekdays and dates, and the days that differ.

The meaning is GTFS's: a pattern is a row of calendar.txt, an exception a row of calendar_dates.txt, and times
past 24:00 belong to the day on which they began. A holiday is an exception of the whole campus.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from datetime import date, datetime, timedelta
from zoneinfo import ZoneInfo

from server.domain.errors import NoService, PatternInvalid
from server.domain.service.timetable import DAY_S, ServiceHours, local_moment

# The longest holidays and the booking horizon are shorter.
_DAYS_SEARCHED = 32
CLOSES_S_MAX = 36 * 3600
WHOLE_CAMPUS = ""

Span = tuple[datetime, datetime]


@dataclass(frozen=True, slots=True)
class Hours:
    """When rides can be booked: seconds after local midnight of the day on which it begins."""

    opens_s: int
    closes_s: int


@dataclass(frozen=True, slots=True)
class ServicePattern:
    """The days on which a service runs: its weekdays (0 is Monday) between two dates, both included.

    hours   when rides can be booked on its days; a pattern for timetable trips only has none
    """

    campus_id: str
    service_id: str
    name: str
    weekdays: tuple[int, ...]
    starts_on: date | None = None
    ends_on: date | None = None
    hours: tuple[Hours, ...] = ()

    def covers(self, day: date) -> bool:
        if self.starts_on is not None and day < self.starts_on:
            return False
        if self.ends_on is not None and day > self.ends_on:
            return False
        return day.weekday() in self.weekdays


@dataclass(frozen=True, slots=True)
class ServiceException:
    """One day on which a service runs against its pattern, or does not run although its pattern says so.

    service_id   WHOLE_CAMPUS for a holiday: no service runs without an exception of its own
    """

    campus_id: str
    day: date
    service_id: str
    runs: bool
    note: str = ""
    made_by: str = ""


@dataclass(frozen=True, slots=True)
class ServiceCalendar:
    """Everything that decides whether the campus runs at a moment.

    otherwise   the hours when no pattern has any
    """

    timezone: str = "UTC"
    patterns: tuple[ServicePattern, ...] = ()
    exceptions: tuple[ServiceException, ...] = ()
    otherwise: ServiceHours = field(default_factory=ServiceHours)

    @property
    def zone(self) -> ZoneInfo:
        return ZoneInfo(self.timezone)

    def runs(self, service_id: str, day: date) -> bool:
        """The service runs on this day. Without a pattern it runs every day except holidays."""
        own = self._exception(service_id, day) if service_id else None
        if own is not None:
            return own.runs
        if self.holiday(day) is not None:
            return False
        pattern = next((p for p in self.patterns if p.service_id == service_id), None)
        return pattern is None or pattern.covers(day)

    def holiday(self, day: date) -> ServiceException | None:
        return self._exception(WHOLE_CAMPUS, day)

    def spans(self, day: date) -> tuple[Span, ...]:
        """The times that begin on this day at which rides can be booked; in order, none touching another."""
        zone = self.zone
        return _joined(
            (local_moment(day, hours.opens_s, zone), local_moment(day, hours.closes_s, zone))
            for hours in self._hours(day)
        )

    def is_open(self, at: datetime) -> bool:
        return self._never_closes or any(opens <= at < closes for opens, closes in self._around(at, 1))

    def next_opening(self, at: datetime) -> datetime | None:
        """The first moment from `at` on at which rides can be booked; None if there is none for weeks."""
        spans = self._around(at, _DAYS_SEARCHED)
        return next((max(opens, at) for opens, closes in spans if closes > at), None)

    def closes_after(self, at: datetime) -> datetime | None:
        """The end of the opening that contains `at`; None if it does not end, and outside of all openings."""
        if self._never_closes:
            return None
        spans = self._around(at, 1)
        closing = next((closes for opens, closes in spans if opens <= at < closes), None)
        if closing is not None and closing < local_moment(self.day_of(at) + timedelta(days=1), 0, self.zone):
            return closing
        # It continues after midnight, perhaps without an end.
        spans = self._around(at, _DAYS_SEARCHED)
        closing = next((closes for opens, closes in spans if opens <= at < closes), None)
        last = local_moment(self.day_of(at) + timedelta(days=_DAYS_SEARCHED), 0, self.zone)
        return None if closing is None or closing >= last else closing

    @property
    def _never_closes(self) -> bool:
        has_hours = self.otherwise.openings or any(pattern.hours for pattern in self.patterns)
        return not has_hours and not any(e.service_id == WHOLE_CAMPUS for e in self.exceptions)

    def require_open(self, at: datetime) -> None:
        """Raises NoService, which names the next opening in local time."""
        if not self.is_open(at):
            raise NoService(f"no shuttle runs at that time{self._holiday_note(at)}; {self.advice(at)}")

    def advice(self, at: datetime) -> str:
        """What to book instead of `at`, which is outside of the service."""
        opens = self.next_opening(at)
        if opens is None:
            return "no service hours are set for the coming weeks"
        return f"book for {opens.astimezone(self.zone):%A %d %B %H:%M} ({self.timezone}) or later"

    def day_of(self, at: datetime) -> date:
        return at.astimezone(self.zone).date()

    def _hours(self, day: date) -> list[Hours]:
        if any(pattern.hours for pattern in self.patterns):
            running = [p for p in self.patterns if p.hours and self.runs(p.service_id, day)]
            return [hours for pattern in running for hours in pattern.hours]
        if self.holiday(day) is not None:
            return []
        if not self.otherwise.openings:
            return [Hours(0, DAY_S)]
        openings = self.otherwise.openings
        return [Hours(o.opens_s, o.closes_s) for o in openings if o.weekday == day.weekday()]

    def _around(self, at: datetime, days: int) -> tuple[Span, ...]:
        """Spans of so many days, and of the day before, whose night may last until now."""
        today = self.day_of(at)
        return _joined(
            span for offset in range(-1, days + 1) for span in self.spans(today + timedelta(days=offset))
        )

    def _exception(self, service_id: str, day: date) -> ServiceException | None:
        return next((e for e in self.exceptions if e.day == day and e.service_id == service_id), None)

    def _holiday_note(self, at: datetime) -> str:
        holiday = self.holiday(self.day_of(at))
        return "" if holiday is None else f" ({holiday.note or 'holiday'})"


def require_sound(pattern: ServicePattern) -> None:
    """Raises PatternInvalid."""
    if any(not 0 <= weekday <= 6 for weekday in pattern.weekdays):
        raise PatternInvalid("weekdays are 0 (Monday) to 6 (Sunday)")
    if pattern.starts_on is not None and pattern.ends_on is not None and pattern.ends_on < pattern.starts_on:
        raise PatternInvalid("the last day lies before the first")
    for hours in pattern.hours:
        if not 0 <= hours.opens_s < min(DAY_S, hours.closes_s) or hours.closes_s > CLOSES_S_MAX:
            raise PatternInvalid(
                "hours open before 24:00, close later than they open and by 36:00 at the latest"
            )


def _joined(spans: Iterator[Span]) -> tuple[Span, ...]:
    joined: list[Span] = []
    for opens, closes in sorted(spans):
        if joined and opens <= joined[-1][1]:
            joined[-1] = joined[-1][0], max(joined[-1][1], closes)
        else:
            joined.append((opens, closes))
    return tuple(joined)
