"""Recurring bookings: which days, and at which moments whatever the clocks do."""

from datetime import UTC, date, datetime
from zoneinfo import ZoneInfo

import pytest

from server.domain.errors import OccurrenceEnded
from server.domain.rides.series import (
    FINAL,
    Occurrence,
    OccurrenceState,
    Series,
    not_taken,
    taken_out,
)

BERLIN = ZoneInfo("Europe/Berlin")


def a_series(**changes: object) -> Series:
    values: dict[str, object] = {
        "weekdays": (0, 1, 2, 3, 4),
        "leave_s": 8 * 3600 + 600,
        "starts_on": date(2026, 3, 26),
        "ends_on": date(2026, 3, 31),
        "made_at": datetime(2026, 3, 1, tzinfo=UTC),
    }
    return Series(
        "campus",
        "series-1",
        "secret",
        "a",
        "b",
        1,
        0,
        source="passenger",
        **(values | changes),  # type: ignore[arg-type]
    )


def test_its_days_are_its_weekdays_between_first_and_last_both_included() -> None:
    assert [day.day for day in a_series().days(BERLIN)] == [26, 27, 30, 31]


def test_the_local_time_stays_when_the_clocks_change() -> None:
    series = a_series()
    moments = [series.leaves_at(day, BERLIN) for day in series.days(BERLIN)]
    assert {moment.astimezone(BERLIN).strftime("%H:%M") for moment in moments} == {"08:10"}
    assert [moment.hour for moment in moments] == [7, 7, 6, 6]


def test_a_time_that_the_clocks_leave_out_comes_after_the_gap_and_one_shown_twice_is_the_first() -> None:
    spring = a_series(leave_s=9000).leaves_at(date(2026, 3, 29), BERLIN)
    autumn = a_series(leave_s=9000).leaves_at(date(2026, 10, 25), BERLIN)
    assert spring.astimezone(BERLIN).strftime("%H:%M") == "03:30"
    assert (autumn.hour, autumn.minute) == (0, 30)


def test_a_day_whose_time_had_passed_when_it_was_booked_is_none_of_its_days() -> None:
    at_nine = datetime(2026, 3, 26, 8, 0, tzinfo=UTC)
    assert [day.day for day in a_series(made_at=at_nine).days(BERLIN)] == [27, 30, 31]


@pytest.mark.parametrize("state", list(OccurrenceState))
def test_a_day_can_be_taken_out_unless_it_is_settled(state: OccurrenceState) -> None:
    day = Occurrence("campus", "series-1", date(2026, 3, 26), datetime(2026, 3, 26, 7, 10, tzinfo=UTC), state)
    if state in FINAL:
        with pytest.raises(OccurrenceEnded, match=str(state)):
            taken_out(day, "passenger")
    else:
        gone = taken_out(day, "passenger")
        assert (gone.state, gone.reason) == (OccurrenceState.CANCELLED, "cancelled_by_passenger")


def test_a_day_that_nobody_can_take_is_tried_until_its_time() -> None:
    leave_at = datetime(2026, 3, 26, 7, 10, tzinfo=UTC)
    day = Occurrence("campus", "series-1", date(2026, 3, 26), leave_at)
    early = not_taken(day, "seats", "full", datetime(2026, 3, 25, tzinfo=UTC))
    assert (early.state, early.reason) == (OccurrenceState.TRYING, "seats")
    assert not_taken(early, "seats", "full", leave_at).state is OccurrenceState.REFUSED
