"""When a shuttle is on duty, across midnight, days off and the change of the clocks."""

from datetime import UTC, date, datetime, timedelta
from zoneinfo import ZoneInfo

import pytest

from server.domain.errors import ShiftsInvalid
from server.domain.fleet.shifts import DutyException, Shift, Shifts, require_sound

HOUR_S = 3600
SHANGHAI, BERLIN = ZoneInfo("Asia/Shanghai"), ZoneInfo("Europe/Berlin")
MONDAY = date(2026, 11, 23)


def shifts(*hours: tuple[int, int], exceptions: tuple[DutyException, ...] = ()) -> Shifts:
    return Shifts((tuple(Shift(a * HOUR_S, b * HOUR_S) for a, b in hours),) * 7, exceptions)


def at(hour: float, day: date = MONDAY, zone: ZoneInfo = SHANGHAI) -> datetime:
    """That hour of the local clock."""
    return datetime(day.year, day.month, day.day, tzinfo=zone) + timedelta(hours=hour)


def on_duty(
    made: Shifts, since: datetime, until: datetime, zone: ZoneInfo = SHANGHAI
) -> list[tuple[str, str]]:
    return [
        (f"{begins.astimezone(zone):%d %H:%M}", f"{ends.astimezone(zone):%d %H:%M}")
        for begins, ends in made.spans(zone, since, until)
    ]


def test_a_day_has_its_shifts_in_order() -> None:
    assert on_duty(shifts((14, 18), (8, 12)), at(0), at(23)) == [
        ("23 08:00", "23 12:00"),
        ("23 14:00", "23 18:00"),
    ]


def test_shifts_that_touch_are_one() -> None:
    assert on_duty(shifts((8, 12), (12, 14), (13, 13)), at(9), at(10)) == [("23 08:00", "23 14:00")]
    assert on_duty(shifts((8, 18), (9, 12)), at(9), at(10)) == [("23 08:00", "23 18:00")]


def test_shifts_that_touch_at_midnight_are_one_also_when_only_the_evening_is_asked_for() -> None:
    assert on_duty(shifts((0, 8), (16, 24)), at(17), at(23)) == [("23 16:00", "24 08:00")]
    assert on_duty(shifts((22, 30), (6, 7)), at(7), at(23)) == [("23 22:00", "24 07:00")]


def test_a_span_counts_until_it_ends_and_from_when_it_begins() -> None:
    made = shifts((8, 12))
    assert on_duty(made, at(12), at(13)) == []
    assert on_duty(made, at(11.99), at(13)) == [("23 08:00", "23 12:00")]
    assert on_duty(made, at(7), at(8)) == [("23 08:00", "23 12:00")]
    assert on_duty(made, at(7), at(7.99)) == []


def test_a_night_shift_is_on_duty_the_morning_after() -> None:
    assert on_duty(shifts((22, 36)), at(1), at(2)) == [("22 22:00", "23 12:00")]


def test_a_day_off_has_no_shifts_and_leaves_the_night_before_it() -> None:
    off = shifts((22, 30), exceptions=(DutyException(MONDAY),))
    assert on_duty(off, at(0), at(24)) == [("22 22:00", "23 06:00")]


def test_a_day_that_differs_has_its_own_shifts() -> None:
    made = shifts((8, 12), exceptions=(DutyException(MONDAY, (Shift(10 * HOUR_S, 11 * HOUR_S),)),))
    assert on_duty(made, at(0), at(23)) == [("23 10:00", "23 11:00")]


def test_a_weekday_without_shifts_is_a_day_off() -> None:
    only_tuesday = Shifts(((), (Shift(8 * HOUR_S, 9 * HOUR_S),), (), (), (), (), ()))
    assert on_duty(only_tuesday, at(0), at(7 * 24 - 1)) == [("24 08:00", "24 09:00")]


def test_on_the_day_when_the_clocks_change_shifts_follow_the_clock_on_the_wall() -> None:
    sunday = date(2026, 10, 25)
    ((begins, ends),) = shifts((1, 4)).spans(BERLIN, at(0, sunday, BERLIN), at(2, sunday, BERLIN))
    assert begins.astimezone(UTC).hour == 23
    assert ends - begins == timedelta(hours=4)


@pytest.mark.parametrize("hours", [(0, 1), (0, 36), (23, 24), (23, 36)])
def test_a_shift_may_last_until_noon_of_the_next_day(hours: tuple[int, int]) -> None:
    require_sound(shifts(hours))


@pytest.mark.parametrize("hours", [(-1, 4), (9, 9), (9, 8), (24, 25), (23, 37)])
def test_a_shift_of_no_time_or_of_another_day_is_refused(hours: tuple[int, int]) -> None:
    for made in (
        shifts(hours),
        shifts(exceptions=(DutyException(MONDAY, (Shift(hours[0] * HOUR_S, hours[1] * HOUR_S),)),)),
    ):
        with pytest.raises(ShiftsInvalid):
            require_sound(made)


def test_a_week_has_seven_days_and_a_day_one_exception() -> None:
    for weekly in (((),) * 6, ((),) * 8):
        with pytest.raises(ShiftsInvalid, match="seven"):
            require_sound(Shifts(weekly))
    with pytest.raises(ShiftsInvalid, match="two exceptions"):
        require_sound(shifts(exceptions=(DutyException(MONDAY), DutyException(MONDAY))))
