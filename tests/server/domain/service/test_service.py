"""Calendars: weekdays and dates, exceptions, holidays, nights, and the changes of the clocks."""

from datetime import UTC, date, datetime, timedelta

import pytest
from hypothesis import given
from hypothesis import strategies as st

from server.domain.errors import NoService, PatternInvalid
from server.domain.service.service import (
    Hours,
    ServiceCalendar,
    ServiceException,
    ServicePattern,
    require_sound,
)
from server.domain.service.timetable import Opening, ServiceHours

SHANGHAI = "Asia/Shanghai"
MONDAY = date(2026, 11, 23)
MONDAY_NOON = datetime(2026, 11, 23, 4, 0, tzinfo=UTC)
WORKDAYS = (0, 1, 2, 3, 4)
DAY = (Hours(7 * 3600, 19 * 3600),)


def a_pattern(service_id: str = "term", **more: object) -> ServicePattern:
    values: dict[str, object] = {"weekdays": WORKDAYS, "hours": DAY} | more
    return ServicePattern("campus", service_id, service_id, **values)  # type: ignore[arg-type]


def an_exception(day: date, service_id: str = "", runs: bool = False, note: str = "") -> ServiceException:
    return ServiceException("campus", day, service_id, runs, note)


def a_calendar(*patterns: ServicePattern, exceptions: tuple[ServiceException, ...] = ()) -> ServiceCalendar:
    return ServiceCalendar(SHANGHAI, patterns, exceptions)


def test_a_pattern_runs_on_its_weekdays_between_its_dates() -> None:
    calendar = a_calendar(a_pattern(starts_on=MONDAY, ends_on=MONDAY + timedelta(days=7)))
    ran = [offset for offset in range(-3, 12) if calendar.runs("term", MONDAY + timedelta(days=offset))]
    assert ran == [0, 1, 2, 3, 4, 7]


def test_a_service_without_a_pattern_runs_on_every_day_that_is_no_holiday() -> None:
    calendar = a_calendar(exceptions=(an_exception(MONDAY),))
    assert not calendar.runs("", MONDAY)
    assert calendar.runs("", MONDAY + timedelta(days=6))


def test_an_exception_of_a_service_wins_over_a_holiday_and_over_the_pattern() -> None:
    sunday = MONDAY + timedelta(days=6)
    exceptions = (
        an_exception(MONDAY, note="Founding Day"),
        an_exception(MONDAY, "exam", runs=True),
        an_exception(sunday, "term", runs=True),
    )
    calendar = a_calendar(a_pattern(), a_pattern("exam"), exceptions=exceptions)
    assert (calendar.runs("term", MONDAY), calendar.runs("exam", MONDAY)) == (False, True)
    assert (calendar.runs("term", sunday), calendar.runs("exam", sunday)) == (True, False)


def test_without_openings_the_campus_always_runs_save_on_holidays() -> None:
    calendar = ServiceCalendar(SHANGHAI)
    calendar.require_open(MONDAY_NOON)
    assert calendar.closes_after(MONDAY_NOON) is None
    closed = ServiceCalendar(SHANGHAI, exceptions=(an_exception(MONDAY, note="New Year"),))
    with pytest.raises(NoService, match=r"New Year.*Tuesday 24 November 00:00"):
        closed.require_open(MONDAY_NOON)


def test_the_settings_hours_count_only_while_no_pattern_has_any() -> None:
    settings = ServiceHours(SHANGHAI, tuple(Opening(day, 9 * 3600, 10 * 3600) for day in range(7)))
    trips_alone = ServiceCalendar(SHANGHAI, (a_pattern(hours=()),), otherwise=settings)
    assert not trips_alone.is_open(MONDAY_NOON)
    with_hours = ServiceCalendar(SHANGHAI, (a_pattern(),), otherwise=settings)
    assert with_hours.is_open(MONDAY_NOON)


def test_opening_is_included_and_closing_is_not() -> None:
    calendar = a_calendar(a_pattern())
    opens, closes = datetime(2026, 11, 22, 23, 0, tzinfo=UTC), datetime(2026, 11, 23, 11, 0, tzinfo=UTC)
    assert calendar.is_open(opens)
    assert not calendar.is_open(opens - timedelta(seconds=1))
    assert calendar.is_open(closes - timedelta(seconds=1))
    assert not calendar.is_open(closes)
    assert calendar.closes_after(MONDAY_NOON) == closes


def test_a_refusal_names_when_it_opens_again_even_after_long_holidays() -> None:
    golden_week = tuple(an_exception(MONDAY + timedelta(days=n)) for n in range(5, 15))
    calendar = a_calendar(a_pattern(), exceptions=golden_week)
    with pytest.raises(NoService, match="Tuesday 08 December 07:00"):
        calendar.require_open(datetime(2026, 11, 27, 14, 0, tzinfo=UTC))


def test_hours_that_never_come_are_said_so() -> None:
    over = a_calendar(a_pattern(ends_on=MONDAY - timedelta(days=1)))
    with pytest.raises(NoService, match="no service hours"):
        over.require_open(MONDAY_NOON)


def test_a_night_s_service_belongs_to_the_day_on_which_it_began() -> None:
    calendar = a_calendar(a_pattern(weekdays=(4,), hours=(Hours(20 * 3600, 26 * 3600),)))
    saturday_half_past_one = datetime(2026, 11, 27, 17, 30, tzinfo=UTC)
    assert calendar.is_open(saturday_half_past_one)
    assert calendar.closes_after(saturday_half_past_one) == datetime(2026, 11, 27, 18, 0, tzinfo=UTC)
    off = a_calendar(*calendar.patterns, exceptions=(an_exception(date(2026, 11, 28)),))
    assert off.is_open(saturday_half_past_one)


def test_openings_that_touch_are_one() -> None:
    calendar = a_calendar(a_pattern(weekdays=tuple(range(7)), hours=(Hours(0, 86_400),)))
    assert calendar.closes_after(MONDAY_NOON) is None
    split = a_calendar(a_pattern(hours=(Hours(7 * 3600, 12 * 3600), Hours(12 * 3600, 18 * 3600))))
    assert split.closes_after(MONDAY_NOON) == datetime(2026, 11, 23, 10, 0, tzinfo=UTC)


@pytest.mark.parametrize("day", [date(2026, 3, 29), date(2026, 10, 25)])
def test_on_days_when_the_clocks_change_the_hours_are_those_on_the_wall(day: date) -> None:
    calendar = ServiceCalendar("Europe/Berlin", (a_pattern(weekdays=(6,)),))
    ((opens, closes),) = calendar.spans(day)
    assert [moment.astimezone(calendar.zone).hour for moment in (opens, closes)] == [7, 19]


@pytest.mark.parametrize(
    "changes",
    [
        {"weekdays": (7,)},
        {"starts_on": MONDAY, "ends_on": MONDAY - timedelta(days=1)},
        {"hours": (Hours(3600, 3600),)},
        {"hours": (Hours(86_400, 90_000),)},
        {"hours": (Hours(0, 37 * 3600),)},
    ],
)
def test_a_pattern_that_contradicts_itself_is_refused(changes: dict[str, object]) -> None:
    with pytest.raises(PatternInvalid):
        require_sound(a_pattern(**changes))


@given(
    opens=st.integers(0, 86_399),
    lasts=st.integers(1, 36 * 3600),
    weekdays=st.sets(st.integers(0, 6)),
    closed=st.sets(st.integers(0, 20), max_size=6),
    second=st.integers(0, 14 * 86_400),
    zone=st.sampled_from([SHANGHAI, "Europe/Berlin", "America/New_York"]),
)
def test_the_next_opening_is_open_and_nothing_before_it_is(
    opens: int, lasts: int, weekdays: set[int], closed: set[int], second: int, zone: str
) -> None:
    pattern = a_pattern(weekdays=tuple(weekdays), hours=(Hours(opens, min(opens + lasts, 36 * 3600)),))
    start = date(2026, 10, 20)
    holidays = tuple(an_exception(start + timedelta(days=offset)) for offset in sorted(closed))
    calendar = ServiceCalendar(zone, (pattern,), holidays)
    at = datetime(2026, 10, 20, tzinfo=UTC) + timedelta(seconds=second)
    following = calendar.next_opening(at)
    if following is None:
        assert not weekdays
        return
    assert following >= at
    assert calendar.is_open(following)
    assert (following == at) == calendar.is_open(at)
    closes = calendar.closes_after(following)
    assert closes is None or (closes > following and not calendar.is_open(closes))


def test_hours_within_others_or_touching_them_close_when_the_last_of_them_close() -> None:
    morning = datetime(2026, 11, 23, 1, 0, tzinfo=UTC)
    for hours in (
        ((7, 19), (8, 10)),
        ((7, 12), (12, 19)),
        ((7, 12), (11, 19)),
        ((11, 19), (7, 11)),
        ((0, 2), (9, 12), (12, 15), (15, 19)),
    ):
        calendar = a_calendar(a_pattern(hours=tuple(Hours(a * 3600, b * 3600) for a, b in hours)))
        closes = calendar.closes_after(morning)
        assert closes is not None
        assert closes.astimezone(calendar.zone).hour == 19, hours


@pytest.mark.parametrize("hours", [(0, 36), (23, 24), (23, 36), (0, 1)])
def test_hours_may_last_until_noon_of_the_next_day(hours: tuple[int, int]) -> None:
    require_sound(a_pattern(hours=(Hours(hours[0] * 3600, hours[1] * 3600),)))


@pytest.mark.parametrize("hours", [(24, 25), (9, 9), (9, 8), (-1, 5), (0, 37)])
def test_hours_of_no_time_or_of_another_day_are_refused(hours: tuple[int, int]) -> None:
    with pytest.raises(PatternInvalid):
        require_sound(a_pattern(hours=(Hours(hours[0] * 3600, hours[1] * 3600),)))


def test_the_end_of_an_opening_is_known_from_its_first_moment_to_its_last() -> None:
    morning, afternoon = Hours(8 * 3600, 12 * 3600), Hours(13 * 3600, 18 * 3600)
    calendar = a_calendar(a_pattern(hours=(morning, afternoon)))
    noon, second = MONDAY_NOON, timedelta(seconds=1)
    evening = noon + timedelta(hours=6)
    ends = {
        noon - timedelta(hours=4) - second: None,
        noon - timedelta(hours=4): noon,
        noon - second: noon,
        noon: None,
        noon + timedelta(hours=1) - second: None,
        noon + timedelta(hours=1): evening,
        evening - second: evening,
        evening: None,
    }
    assert {at: calendar.closes_after(at) for at in ends} == ends


def test_a_campus_that_is_open_save_on_holidays_closes_at_the_midnight_before_the_next_one() -> None:
    holiday = MONDAY + timedelta(days=2)
    calendar = ServiceCalendar(SHANGHAI, exceptions=(an_exception(holiday),))
    midnight = MONDAY_NOON - timedelta(hours=12)
    assert calendar.spans(MONDAY) == ((midnight, midnight + timedelta(days=1)),)
    assert calendar.closes_after(MONDAY_NOON) == midnight + timedelta(days=2)
    assert calendar.next_opening(midnight + timedelta(days=2)) == midnight + timedelta(days=3)


def test_on_a_saturday_evening_the_next_opening_is_on_monday_morning() -> None:
    saturday = MONDAY_NOON - timedelta(days=2) + timedelta(hours=8)
    assert a_calendar(a_pattern()).next_opening(saturday) == MONDAY_NOON - timedelta(hours=5)


def test_a_campus_without_hours_or_holidays_never_closes() -> None:
    calendar = ServiceCalendar(SHANGHAI)
    assert calendar.is_open(MONDAY_NOON)
    assert calendar.closes_after(MONDAY_NOON) is None
    assert not a_calendar(a_pattern(), exceptions=(an_exception(MONDAY),)).is_open(MONDAY_NOON)
