"""When a shuttle is on duty: hours of each weekday, and the days that differ."""

from collections.abc import Iterable
from dataclasses import dataclass
from datetime import date, datetime, timedelta
from zoneinfo import ZoneInfo

from server.domain.errors import ShiftsInvalid
from server.domain.service.timetable import DAY_S, local_moment

ENDS_S_MAX = 36 * 3600
WEEK = 7

Span = tuple[datetime, datetime]


@dataclass(frozen=True, slots=True)
class Shift:
    """Seconds after local midnight of the day on which it begins; one past midnight ends after 24:00."""

    begins_s: int
    ends_s: int


@dataclass(frozen=True, slots=True)
class DutyException:
    """One day on which other shifts hold than those of its weekday; none at all for a day off."""

    day: date
    shifts: tuple[Shift, ...] = ()


@dataclass(frozen=True, slots=True)
class Shifts:
    """weekly: for each weekday, Monday first; a weekday without shifts is a day off."""

    weekly: tuple[tuple[Shift, ...], ...]
    exceptions: tuple[DutyException, ...] = ()

    def spans(self, zone: ZoneInfo, since: datetime, until: datetime) -> tuple[Span, ...]:
        """On duty: the spans that end after `since` and begin by `until`, in order, none touching another."""
        first = since.astimezone(zone).date() - timedelta(days=2)
        # A shift of the last day may go on in one of the next day.
        last = until.astimezone(zone).date() + timedelta(days=1)
        found: list[Span] = []
        for offset in range((last - first).days + 1):
            day = first + timedelta(days=offset)
            for shift in self._of(day):
                found.append((local_moment(day, shift.begins_s, zone), local_moment(day, shift.ends_s, zone)))
        return tuple((begins, ends) for begins, ends in _joined(found) if ends > since and begins <= until)

    def _of(self, day: date) -> tuple[Shift, ...]:
        for exception in self.exceptions:
            if exception.day == day:
                return exception.shifts
        return self.weekly[day.weekday()]


def require_sound(shifts: Shifts) -> None:
    """Raises ShiftsInvalid."""
    if len(shifts.weekly) != WEEK:
        raise ShiftsInvalid("name the shifts of all seven weekdays, Monday first")
    days = [exception.day for exception in shifts.exceptions]
    if len(set(days)) != len(days):
        raise ShiftsInvalid("a day has two exceptions; put its shifts into one")
    for shift in (*_flat(shifts.weekly), *_flat(e.shifts for e in shifts.exceptions)):
        if not 0 <= shift.begins_s < min(DAY_S, shift.ends_s) or shift.ends_s > ENDS_S_MAX:
            raise ShiftsInvalid("a shift begins before 24:00, and ends later than that and by 36:00")


def _flat(days: Iterable[tuple[Shift, ...]]) -> list[Shift]:
    return [shift for day in days for shift in day]


def _joined(spans: Iterable[Span]) -> list[Span]:
    joined: list[Span] = []
    for begins, ends in sorted(spans):
        if joined and begins <= joined[-1][1]:
            joined[-1] = joined[-1][0], max(joined[-1][1], ends)
        else:
            joined.append((begins, ends))
    return joined
