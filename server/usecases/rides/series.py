"""Recurring bookings: made, listed and cancelled by passengers, turned into rides as their days come near."""

from dataclasses import dataclass, replace
from datetime import date, datetime, timedelta

from server.domain.errors import IdempotencyMismatch, NoService, RideRefused, SeriesInvalid, SeriesUnknown
from server.domain.planning.outlooks import NO_OUTLOOK, RideOutlook
from server.domain.rides import series as domain
from server.domain.rides.rides import BookRide, Ride, RideState
from server.domain.rides.series import (
    DAYS_MAX,
    FINAL,
    BookSeries,
    Occurrence,
    OccurrenceState,
    Series,
    SeriesState,
    require_active,
)
from server.domain.rides.ticket_keys import RideSecrets
from server.domain.service.service import ServiceCalendar
from server.usecases.planning.outlooks import outlook_of
from server.usecases.ports import topics
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.calendars import calendar_of
from server.usecases.record.server_events import THE_SERVER, record_event
from server.usecases.rides import rides
from server.usecases.rides.tickets import secrets_of

_TOO_LATE = ("no_vehicle_free", "its time came before a shuttle could be found")


@dataclass(frozen=True, slots=True)
class OccurrenceView:
    """ride is None while there is none, and when there will be none; secrets and outlook are the ride's."""

    occurrence: Occurrence
    ride: Ride | None
    secrets: RideSecrets
    outlook: RideOutlook


@dataclass(frozen=True, slots=True)
class DueRide:
    """One day of a recurring booking that needs its ride now."""

    series_id: str
    day: date


def book_series(uow: UnitOfWork, request: BookSeries) -> Series:
    """A repeated idempotency_key gives the earlier one.

    Raises SeriesInvalid, IdempotencyMismatch, and if a ride is never possible: StopUnknown, SameStop,
    StopUnreachable, PartyInvalid, PartyTooLarge.
    """
    known = _earlier_booking(uow, request)
    if known is not None:
        return known
    rides.require_bookable(uow, _ride_request(request, None))
    calendar = calendar_of(uow)
    made = Series(
        campus_id=uow.campus_id,
        series_id=uow.ids.new_id("series"),
        ticket_key_id=uow.tickets.newest_id,
        from_stop=request.from_stop,
        to_stop=request.to_stop,
        party=request.party,
        wheelchairs=request.wheelchairs,
        weekdays=tuple(sorted(set(request.weekdays))),
        leave_s=request.leave_s,
        starts_on=max(request.starts_on or calendar.day_of(uow.now), calendar.day_of(uow.now)),
        ends_on=request.ends_on,
        made_at=uow.now,
        source=request.source,
        idempotency_key=request.idempotency_key,
    )
    _require_days(made, calendar)
    uow.series.add(made)
    _record_and_publish(uow, made, "series.booked", request.source)
    return made


def series_of(uow: UnitOfWork, series_id: str) -> Series:
    """Raises SeriesUnknown."""
    found = uow.series.get(series_id)
    if found is None:
        raise SeriesUnknown(f"there is no recurring booking {series_id}")
    return found


def occurrences_of(uow: UnitOfWork, series: Series) -> tuple[OccurrenceView, ...]:
    """Every day of it, with its ride once there is one; days to come that nothing has happened to yet too."""
    calendar = calendar_of(uow)
    known = {occurrence.day: occurrence for occurrence in uow.series.occurrences(series.series_id)}
    views = []
    for day in series.days(calendar.zone):
        occurrence = known.get(day)
        if occurrence is None and series.state is SeriesState.ACTIVE:
            occurrence = _expected(uow, calendar, series, day)
        if occurrence is not None:
            ride = None if occurrence.ride_id is None else uow.rides.get(occurrence.ride_id)
            secrets = RideSecrets("", "") if ride is None else secrets_of(uow, ride)
            outlook = NO_OUTLOOK if ride is None else outlook_of(uow, ride)
            views.append(OccurrenceView(occurrence, ride, secrets, outlook))
    return tuple(views)


def cancel_series(uow: UnitOfWork, series_id: str, by: str) -> Series:
    """No further rides. Booked rides are cancelled, except one that is under way.

    Raises SeriesUnknown, SeriesEnded.
    """
    series = series_of(uow, series_id)
    require_active(series)
    for occurrence in uow.series.occurrences(series_id):
        if occurrence.state not in FINAL and _cancel_ride(uow, occurrence, by):
            uow.series.save_occurrence(domain.taken_out(occurrence, by))
    gone = replace(series, state=SeriesState.CANCELLED, ended_at=uow.now)
    uow.series.save(gone)
    _record_and_publish(uow, gone, "series.cancelled", by)
    return gone


def cancel_occurrence(uow: UnitOfWork, series_id: str, day: date, by: str) -> Series:
    """Only this day. Raises SeriesUnknown (also: none of its days), SeriesEnded, OccurrenceEnded."""
    series, zone = series_of(uow, series_id), calendar_of(uow).zone
    require_active(series)
    if not series.has_day(day, zone):
        raise SeriesUnknown(f"this recurring booking has no ride on {day:%A %d %B %Y}")
    present = uow.series.occurrence(series_id, day) or _new_occurrence(
        series, day, _local_leave_at(uow, series, day)
    )
    gone = domain.taken_out(present, by)
    if present.ride_id is not None:
        rides.cancel(uow, present.ride_id, by)
    uow.series.save_occurrence(gone)
    _record_and_publish(uow, series, "series.day_cancelled", by, day.isoformat())
    return series


# ---------------------------------------------------------------- as the days come near


def due_rides(uow: UnitOfWork) -> tuple[DueRide, ...]:
    """The days that need a ride now: within the horizon, or due for another attempt."""
    calendar = calendar_of(uow)
    horizon = uow.now + timedelta(seconds=uow.rules.series_ahead_s)
    first, last = calendar.day_of(uow.now) - timedelta(days=1), calendar.day_of(horizon)
    known = {(made.series_id, made.day): made for made in uow.series.occurrences_between(first, last)}
    due = []
    for series in uow.series.listed([SeriesState.ACTIVE]):
        for offset in range((last - first).days + 1):
            day = first + timedelta(days=offset)
            leave_at = series.leaves_at(day, calendar.zone)
            within = series.has_day(day, calendar.zone) and leave_at <= horizon
            if within and _needs_attempt(uow, leave_at, known.get((series.series_id, day))):
                due.append(DueRide(series.series_id, day))
    return tuple(due)


def book_occurrence(uow: UnitOfWork, due: DueRide) -> Occurrence:
    """Book the day's ride once; a repeat returns its present state.

    Raises RideRefused and what a booking raises; then `note_not_taken` keeps the reason.
    """
    series, calendar = series_of(uow, due.series_id), calendar_of(uow)
    present = _occurrence(uow, series, due.day)
    if series.state is not SeriesState.ACTIVE or not _is_open(present):
        return present
    holiday = calendar.holiday(due.day)
    if holiday is not None:
        done = domain.skipped(present, holiday.note, uow.now)
    elif present.leave_at < uow.now:
        reason = (present.reason, present.reason_detail) if present.reason else _TOO_LATE
        done = domain.not_taken(present, *reason, uow.now)
    else:
        ride = rides.book(uow, _ride_request(series, present))
        if ride.state is RideState.REFUSED:
            raise RideRefused(ride.reason_detail, ride.reason)
        done = domain.booked(present, ride.ride_id, uow.now)
    uow.series.save_occurrence(done)
    _record_and_publish(
        uow, series, f"series.day_{done.state}", THE_SERVER, f"{due.day.isoformat()} {done.reason}".rstrip()
    )
    return done


def record_failed_attempt(uow: UnitOfWork, due: DueRide, reason: str, detail: str) -> Occurrence:
    """Store why a day has no ride yet, and when it was tried, for the booking's page."""
    series = series_of(uow, due.series_id)
    present = _occurrence(uow, series, due.day)
    if series.state is not SeriesState.ACTIVE or not _is_open(present):
        return present
    done = domain.not_taken(present, reason, detail, uow.now)
    uow.series.save_occurrence(done)
    if (present.state, present.reason) != (done.state, done.reason):
        _record_and_publish(
            uow, series, f"series.day_{done.state}", THE_SERVER, f"{due.day.isoformat()} {reason}"
        )
    return done


def finish_past(uow: UnitOfWork) -> None:
    """Close the recurring bookings whose last day is over."""
    yesterday = calendar_of(uow).day_of(uow.now) - timedelta(days=1)
    for series in uow.series.listed([SeriesState.ACTIVE]):
        if series.ends_on < yesterday:
            done = replace(series, state=SeriesState.FINISHED, ended_at=uow.now)
            uow.series.save(done)
            _record_and_publish(uow, done, "series.finished", THE_SERVER)


# ---------------------------------------------------------------- parts


def _local_leave_at(uow: UnitOfWork, series: Series, day: date) -> datetime:
    return series.leaves_at(day, calendar_of(uow).zone)


def _earlier_booking(uow: UnitOfWork, request: BookSeries) -> Series | None:
    key = request.idempotency_key
    known = None if key is None else uow.series.by_idempotency_key(key)
    if known is None:
        return None
    asked = (request.from_stop, request.to_stop, request.leave_s, request.ends_on)
    if asked != (known.from_stop, known.to_stop, known.leave_s, known.ends_on):
        raise IdempotencyMismatch("this Idempotency-Key belongs to another booking; use a new one")
    return known


def _require_days(series: Series, calendar: ServiceCalendar) -> None:
    if (series.ends_on - series.starts_on).days > DAYS_MAX:
        raise SeriesInvalid(f"a recurring booking lasts {DAYS_MAX} days at most; end it earlier")
    days = list(series.days(calendar.zone))
    if not days:
        raise SeriesInvalid("no such weekday lies between the first and the last day")
    if all(calendar.holiday(day) is not None for day in days):
        raise SeriesInvalid("every day of it is a holiday")
    moments = [series.leaves_at(day, calendar.zone) for day in days]
    if not any(calendar.is_open(moment) for moment in moments):
        raise NoService(f"no shuttle runs at that time on any of its days; {calendar.advice(moments[0])}")


def _ride_request(series: Series | BookSeries, occurrence: Occurrence | None) -> BookRide:
    return BookRide(
        from_stop=series.from_stop,
        to_stop=series.to_stop,
        party=series.party,
        wheelchairs=series.wheelchairs,
        earliest=None if occurrence is None else occurrence.leave_at,
        idempotency_key=(
            None if occurrence is None else f"series/{occurrence.series_id}/{occurrence.day.isoformat()}"
        ),
        source=series.source,
        series_id=None if occurrence is None else occurrence.series_id,
    )


def _expected(uow: UnitOfWork, calendar: ServiceCalendar, series: Series, day: date) -> Occurrence:
    """The occurrence of a day that is too far ahead, as far as it is known."""
    fresh = _new_occurrence(series, day, series.leaves_at(day, calendar.zone))
    holiday = calendar.holiday(day)
    if holiday is not None:
        return domain.skipped(fresh, holiday.note, uow.now)
    return fresh if fresh.leave_at >= uow.now else domain.not_taken(fresh, *_TOO_LATE, uow.now)


def _occurrence(uow: UnitOfWork, series: Series, day: date) -> Occurrence:
    known = uow.series.occurrence(series.series_id, day)
    return known or _new_occurrence(series, day, _local_leave_at(uow, series, day))


def _new_occurrence(series: Series, day: date, leave_at: datetime) -> Occurrence:
    return Occurrence(series.campus_id, series.series_id, day, leave_at)


def _is_open(occurrence: Occurrence) -> bool:
    return occurrence.state in (OccurrenceState.PLANNED, OccurrenceState.TRYING)


def _needs_attempt(uow: UnitOfWork, leave_at: datetime, known: Occurrence | None) -> bool:
    if known is None or known.tried_at is None:
        return known is None or _is_open(known)
    waited_s = (uow.now - known.tried_at).total_seconds()
    return _is_open(known) and (waited_s >= uow.rules.series_retry_s or uow.now > leave_at)


def _cancel_ride(uow: UnitOfWork, occurrence: Occurrence, by: str) -> bool:
    """Cancel the ride; False if it is under way or over, and stays unchanged."""
    ride = None if occurrence.ride_id is None else uow.rides.get(occurrence.ride_id)
    if ride is None:
        return True
    if ride.has_ended or ride.state is RideState.ABOARD:
        return False
    rides.cancel(uow, ride.ride_id, by)
    return True


def _record_and_publish(uow: UnitOfWork, series: Series, name: str, by: str, detail: str = "") -> None:
    record_event(uow, name, series.series_id, by, detail)
    uow.publish(topics.series(uow.campus_id, series.series_id))
