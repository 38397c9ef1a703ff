"""Recurring bookings: each day becomes a ride once, and whoever cannot be taken is told why."""

from dataclasses import replace
from datetime import UTC, date, datetime, timedelta

import pytest

from server.domain.errors import (
    IdempotencyMismatch,
    NoService,
    OccurrenceEnded,
    SeriesEnded,
    SeriesInvalid,
    SeriesUnknown,
    StopUnknown,
)
from server.domain.rides.rides import RideState
from server.domain.rides.series import (
    DAYS_MAX,
    BookSeries,
    Occurrence,
    Series,
    SeriesState,
)
from server.domain.rides.series import OccurrenceState as State
from server.domain.service.service import Hours, ServiceException, ServicePattern
from server.loops.series import SeriesScheduler
from server.usecases.fleet import service
from server.usecases.rides import rides, series
from server.usecases.rides.tickets import series_by_token, series_token
from tests.server.usecases.campus_under_test import CampusUnderTest
from tests.server.usecases.fake_fleet import FakeFleet

MONDAY = date(2026, 11, 23)
TUESDAY = date(2026, 11, 24)
WORKDAYS = (0, 1, 2, 3, 4)
AT_TEN_PAST_EIGHT = 8 * 3600 + 600
WISH = BookSeries("NN20", "C6", WORKDAYS, AT_TEN_PAST_EIGHT, date(2026, 12, 4), party=1, wheelchairs=0)


def book(campus: CampusUnderTest, **changes: object) -> Series:
    wish = replace(WISH, **changes)  # type: ignore[arg-type]
    return campus.do(lambda uow: series.book_series(uow, wish))


def run_scheduler(campus: CampusUnderTest) -> None:
    campus.wait_for(SeriesScheduler(campus.transactions, "clerk").run_once())


def days(campus: CampusUnderTest, made: Series) -> dict[date, Occurrence]:
    views = campus.read(lambda uow: series.occurrences_of(uow, series.series_of(uow, made.series_id)))
    return {view.occurrence.day: view.occurrence for view in views}


def states(campus: CampusUnderTest, made: Series) -> list[State]:
    return [occurrence.state for occurrence in days(campus, made).values()]


def test_each_day_becomes_a_ride_when_the_horizon_reaches_it_and_only_once(fleet: FakeFleet) -> None:
    campus = fleet.campus
    made = book(campus)
    assert campus.read(lambda uow: series_by_token(uow, series_token(uow, made))) == made
    run_scheduler(campus)
    run_scheduler(campus)
    assert states(campus, made)[:3] == [
        State.BOOKED,
        State.PLANNED,
        State.PLANNED,
    ]
    campus.clock.advance(1200.0)
    run_scheduler(campus)
    (today, tomorrow) = sorted(fleet.rides(), key=lambda ride: ride.earliest)
    assert (tomorrow.earliest - today.earliest) == timedelta(days=1)
    assert today.earliest == datetime(2026, 11, 23, 0, 10, tzinfo=UTC)
    assert {ride.series_id for ride in (today, tomorrow)} == {made.series_id}
    assert today.promise is not None
    assert today.promise.pickup_from >= today.earliest


def test_two_clerks_at_once_book_one_ride(fleet: FakeFleet) -> None:
    campus = fleet.campus
    book(campus)
    (due,) = campus.read(series.due_rides)
    for _ in range(2):
        campus.do(lambda uow: series.book_occurrence(uow, due))
    assert len(fleet.rides()) == 1


def test_a_day_that_nobody_can_take_says_why_leaves_nothing_and_is_tried_again(
    campus: CampusUnderTest,
) -> None:
    made = book(campus)
    run_scheduler(campus)
    first = days(campus, made)[date(2026, 11, 23)]
    assert (first.state, first.reason) == (State.TRYING, "no_vehicle_free")
    assert "no shuttle is in service" in first.reason_detail
    assert campus.read(lambda uow: uow.views.rides()) == ()
    campus.clock.advance(60.0)
    assert campus.read(series.due_rides) == ()
    campus.clock.advance(600.0)
    run_scheduler(campus)
    assert days(campus, made)[date(2026, 11, 23)].state is State.REFUSED
    campus.clock.advance(5 * 86_400.0)
    run_scheduler(campus)
    assert days(campus, made)[date(2026, 11, 23)].state is State.REFUSED


def test_a_day_is_taken_as_soon_as_somebody_can(fleet: FakeFleet) -> None:
    campus = fleet.campus
    for shuttle in fleet.shuttles:
        shuttle.hold()
    made = book(campus, leave_s=9 * 3600)
    run_scheduler(campus)
    assert states(campus, made)[0] is State.TRYING
    for shuttle in fleet.shuttles:
        shuttle.resume()
    campus.clock.advance(campus.rules.series_retry_s)
    run_scheduler(campus)
    taken = days(campus, made)[date(2026, 11, 23)]
    assert (taken.state, taken.reason) == (State.BOOKED, "")


def test_holidays_are_left_out_and_shown_beforehand(fleet: FakeFleet) -> None:
    campus = fleet.campus
    made = book(campus)
    off = ServiceException("snow-lion", TUESDAY, "", False, "Founding Day", "ann")
    campus.do(lambda uow: service.save_exception(uow, off))
    shown = days(campus, made)[TUESDAY]
    assert (shown.state, shown.reason, shown.reason_detail) == (
        State.SKIPPED,
        "holiday",
        "Founding Day",
    )
    campus.clock.advance(86_400.0 - 60.0)
    run_scheduler(campus)
    assert days(campus, made)[TUESDAY].state is State.SKIPPED
    assert not any(ride.earliest.date() == TUESDAY for ride in fleet.rides())


def test_one_day_can_be_cancelled_before_and_after_it_has_its_ride(fleet: FakeFleet) -> None:
    campus = fleet.campus
    made = book(campus)
    run_scheduler(campus)
    monday = date(2026, 11, 23)
    for day in (monday, TUESDAY):
        campus.do(lambda uow, day=day: series.cancel_occurrence(uow, made.series_id, day, "passenger"))
    assert states(campus, made)[:3] == [
        State.CANCELLED,
        State.CANCELLED,
        State.PLANNED,
    ]
    assert [ride.state for ride in fleet.rides()] == [RideState.CANCELLED]
    with pytest.raises(OccurrenceEnded):
        campus.do(lambda uow: series.cancel_occurrence(uow, made.series_id, monday, "passenger"))
    with pytest.raises(SeriesUnknown, match="Saturday"):
        campus.do(lambda uow: series.cancel_occurrence(uow, made.series_id, date(2026, 11, 28), "passenger"))
    campus.clock.advance(1200.0)
    run_scheduler(campus)
    assert len(fleet.rides()) == 1


def test_a_cancelled_series_cancels_its_rides_and_makes_no_more(fleet: FakeFleet) -> None:
    campus = fleet.campus
    made = book(campus)
    run_scheduler(campus)
    gone = campus.do(lambda uow: series.cancel_series(uow, made.series_id, "passenger"))
    assert gone.state is SeriesState.CANCELLED
    assert [ride.state for ride in fleet.rides()] == [RideState.CANCELLED]
    campus.clock.advance(1200.0)
    run_scheduler(campus)
    assert len(fleet.rides()) == 1
    with pytest.raises(SeriesEnded):
        campus.do(lambda uow: series.cancel_series(uow, made.series_id, "passenger"))


@pytest.mark.parametrize("state", [RideState.ABOARD, RideState.COMPLETED])
def test_a_cancelled_series_leaves_the_day_whose_ride_is_under_way_or_over_as_it_was(
    fleet: FakeFleet, state: RideState
) -> None:
    campus = fleet.campus
    made = book(campus)
    run_scheduler(campus)
    (ride,) = fleet.rides()
    campus.do(lambda uow: uow.rides.save(replace(ride, state=state)))
    campus.do(lambda uow: series.cancel_series(uow, made.series_id, "passenger"))
    assert fleet.ride(ride.ride_id).state is state
    assert State.CANCELLED not in states(campus, made)[:1]


def test_a_ride_that_was_cancelled_by_its_own_link_is_not_booked_again(fleet: FakeFleet) -> None:
    campus = fleet.campus
    made = book(campus)
    run_scheduler(campus)
    (ride,) = fleet.rides()
    campus.do(lambda uow: rides.cancel(uow, ride.ride_id, "passenger"))
    run_scheduler(campus)
    assert len(fleet.rides()) == 1
    (view, *_) = campus.read(lambda uow: series.occurrences_of(uow, made))
    assert view.ride is not None
    assert view.ride.state is RideState.CANCELLED


def test_a_series_ends_by_itself(fleet: FakeFleet) -> None:
    campus = fleet.campus
    made = book(campus, ends_on=date(2026, 11, 23))
    run_scheduler(campus)
    campus.clock.advance(2 * 86_400.0)
    run_scheduler(campus)
    assert campus.read(lambda uow: series.series_of(uow, made.series_id)).state is SeriesState.FINISHED


def test_a_repeat_with_the_same_key_is_the_same_series(campus: CampusUnderTest) -> None:
    first = book(campus, idempotency_key="k")
    assert book(campus, idempotency_key="k") == first
    with pytest.raises(IdempotencyMismatch):
        book(campus, idempotency_key="k", leave_s=3600)


@pytest.mark.parametrize(
    ("changes", "error"),
    [
        ({"to_stop": "NOWHERE"}, StopUnknown),
        ({"ends_on": date(2026, 11, 22)}, SeriesInvalid),
        ({"ends_on": date(2026, 11, 24), "weekdays": (6,)}, SeriesInvalid),
        ({"ends_on": date(2029, 1, 1)}, SeriesInvalid),
    ],
)
def test_what_can_never_be_a_ride_is_an_error(
    campus: CampusUnderTest, changes: dict[str, object], error: type[Exception]
) -> None:
    with pytest.raises(error):
        book(campus, **changes)
    assert campus.read(lambda uow: uow.series.listed()) == ()


def test_a_time_at_which_nothing_ever_runs_is_an_error_that_names_the_opening(
    campus: CampusUnderTest,
) -> None:
    hours = ServicePattern("snow-lion", "rides", "rides", WORKDAYS, hours=(Hours(9 * 3600, 10 * 3600),))
    campus.do(lambda uow: service.save_pattern(uow, hours, "ann"))
    with pytest.raises(NoService, match="Monday 23 November 09:00"):
        book(campus)


def test_a_clock_that_jumps_over_days_leaves_none_of_them_open(fleet: FakeFleet) -> None:
    campus = fleet.campus
    made = book(campus)
    campus.clock.advance(86_400.0 + 7200.0)
    run_scheduler(campus)
    now = campus.clock.now()
    shown = days(campus, made)
    assert shown[TUESDAY].state is State.REFUSED
    assert all(
        occurrence.state is not State.TRYING for occurrence in shown.values() if occurrence.leave_at < now
    )


def test_the_record_tells_of_each_turn_once_and_holds_no_secret(campus: CampusUnderTest) -> None:
    made = book(campus)
    run_scheduler(campus)
    found = campus.read(lambda uow: uow.views.server_events())
    told = [f"{event.name} {event.detail}" for event in found if event.name.startswith("series.")]
    assert told == ["series.day_trying 2026-11-23 no_vehicle_free", "series.booked "]
    assert campus.read(lambda uow: series_token(uow, made)) not in repr(found)


def test_a_day_that_nobody_could_take_is_closed_after_midnight_with_its_reason(
    campus: CampusUnderTest,
) -> None:
    made = book(campus)
    run_scheduler(campus)
    campus.clock.advance(17 * 3600.0)
    run_scheduler(campus)
    closed = days(campus, made)[MONDAY]
    assert (closed.state, closed.reason) == (State.REFUSED, "no_vehicle_free")


def test_a_day_that_was_never_tried_in_time_says_so(fleet: FakeFleet) -> None:
    campus = fleet.campus
    made = book(campus)
    campus.clock.advance(601.0)
    shown = days(campus, made)[MONDAY]
    run_scheduler(campus)
    closed = days(campus, made)[MONDAY]
    assert (closed.state, closed.reason) == (shown.state, shown.reason) == (State.REFUSED, "no_vehicle_free")
    assert "came before a shuttle" in closed.reason_detail


def test_the_ride_of_this_very_moment_is_still_booked(fleet: FakeFleet) -> None:
    campus = fleet.campus
    made = book(campus)
    campus.clock.advance(600.0)
    assert days(campus, made)[MONDAY].state is State.PLANNED
    run_scheduler(campus)
    assert days(campus, made)[MONDAY].state is State.BOOKED


def test_a_day_is_booked_as_soon_as_its_ride_begins_within_the_horizon(fleet: FakeFleet) -> None:
    campus = fleet.campus
    made = book(campus, weekdays=(1,))
    campus.clock.advance(600.0 + 86_400.0 - campus.rules.series_ahead_s - 1.0)
    assert campus.read(series.due_rides) == ()
    campus.clock.advance(1.0)
    assert [due.day for due in campus.read(series.due_rides)] == [TUESDAY]
    assert states(campus, made)[0] is State.PLANNED


def test_what_was_cancelled_while_it_was_being_booked_gets_no_ride(fleet: FakeFleet) -> None:
    campus = fleet.campus
    one_day, whole = book(campus), book(campus)
    due = campus.read(series.due_rides)
    campus.do(lambda uow: series.cancel_occurrence(uow, one_day.series_id, MONDAY, "passenger"))
    campus.do(lambda uow: series.cancel_series(uow, whole.series_id, "passenger"))
    assert len(due) == 2
    for one in due:
        campus.do(lambda uow, one=one: series.book_occurrence(uow, one))  # type: ignore[misc]
        campus.do(lambda uow, one=one: series.record_failed_attempt(uow, one, "arrival", ""))  # type: ignore[misc]
    assert fleet.rides() == ()
    assert days(campus, one_day)[MONDAY].state is State.CANCELLED
    assert days(campus, whole) == {}


def test_a_cancelled_series_takes_back_the_days_that_had_a_ride_and_those_that_were_tried(
    fleet: FakeFleet,
) -> None:
    campus = fleet.campus
    booked = book(campus)
    run_scheduler(campus)
    for shuttle in fleet.shuttles:
        shuttle.hold()
    tried = book(campus)
    run_scheduler(campus)
    assert [states(campus, made)[0] for made in (booked, tried)] == [State.BOOKED, State.TRYING]
    for made in (booked, tried):
        campus.do(lambda uow, made=made: series.cancel_series(uow, made.series_id, "passenger"))  # type: ignore[misc]
        assert states(campus, made) == [State.CANCELLED]


def test_a_series_is_over_on_the_second_day_after_its_last_one(campus: CampusUnderTest) -> None:
    """Its last ride may end after midnight."""
    made = book(campus, ends_on=MONDAY)
    for expected in (SeriesState.ACTIVE, SeriesState.ACTIVE, SeriesState.FINISHED):
        run_scheduler(campus)
        assert campus.read(lambda uow: series.series_of(uow, made.series_id)).state is expected
        campus.clock.advance(86_400.0)


def test_the_longest_series_is_taken_and_one_of_a_day_more_is_not(campus: CampusUnderTest) -> None:
    book(campus, ends_on=MONDAY + timedelta(days=DAYS_MAX))
    with pytest.raises(SeriesInvalid, match=f"lasts {DAYS_MAX} days"):
        book(campus, ends_on=MONDAY + timedelta(days=DAYS_MAX + 1))
