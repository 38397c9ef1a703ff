"""Service hours and departures, in local time."""

from datetime import UTC, date, datetime, timedelta

import pytest

from contract.roads.model import TimetableTrip
from server.domain.errors import OutsideServiceHours
from server.domain.timetable import Opening, ServiceHours, departures_of

MONDAY_NOON = datetime(2026, 11, 23, 4, 0, tzinfo=UTC)  # 12:00 in Shanghai
WEEKDAYS = tuple(Opening(day, 7 * 3600, 19 * 3600) for day in range(5))
HOURS = ServiceHours("Asia/Shanghai", WEEKDAYS)


def test_without_openings_the_campus_always_runs() -> None:
    ServiceHours().require_open(MONDAY_NOON)


def test_opening_is_included_and_closing_is_not() -> None:
    opens = datetime(2026, 11, 22, 23, 0, tzinfo=UTC)
    closes = datetime(2026, 11, 23, 11, 0, tzinfo=UTC)
    assert HOURS.is_open(opens)
    assert not HOURS.is_open(opens - timedelta(seconds=1))
    assert HOURS.is_open(closes - timedelta(seconds=1))
    assert not HOURS.is_open(closes)


def test_a_refusal_names_when_it_opens_again() -> None:
    friday_night = datetime(2026, 11, 27, 14, 0, tzinfo=UTC)
    with pytest.raises(OutsideServiceHours, match="Monday 30 November 07:00"):
        HOURS.require_open(friday_night)


def test_the_next_opening_can_be_later_today() -> None:
    before = datetime(2026, 11, 22, 20, 0, tzinfo=UTC)  # Monday 04:00 there
    assert HOURS.next_opening(before) == datetime(2026, 11, 22, 23, 0, tzinfo=UTC)
    assert HOURS.next_opening(MONDAY_NOON) == MONDAY_NOON


def test_hours_that_never_come_are_said_so() -> None:
    never = ServiceHours("UTC", (Opening(9, 0, 10),))
    with pytest.raises(OutsideServiceHours, match="no service hours"):
        never.require_open(MONDAY_NOON)


def test_departures_are_local_times_and_sorted_by_their_first_call() -> None:
    trips = [
        TimetableTrip("late", (("A", 9 * 3600), ("B", 9 * 3600 + 180))),
        TimetableTrip("early", (("A", 8 * 3600), ("B", 8 * 3600 + 180))),
    ]
    first, second = departures_of("campus", trips, "Asia/Shanghai", date(2026, 11, 23))
    assert first.departure_id == "early@2026-11-23"
    assert first.calls[0].leave_at == datetime(2026, 11, 23, 0, 0, tzinfo=UTC)
    assert second.calls[1].leave_at == datetime(2026, 11, 23, 1, 3, tzinfo=UTC)
