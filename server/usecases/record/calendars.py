"""On which days and at which hours the campus runs, as bookings, departures and pages read it."""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import date, datetime, timedelta

from contract.roads.model import TimetableTrip
from server.domain.service.service import ServiceCalendar, ServiceException, Span
from server.domain.service.timetable import Departure, DepartureState, departures_of
from server.domain.service.trips import MAPS_OWN_REVISION, Timetable, UnservedTrip, unserved_trips
from server.usecases.ports.unit_of_work import UnitOfWork


@dataclass(frozen=True, slots=True)
class ServiceDay:
    """What runs on one local day.

    departures   as the timetable has them, with what has become of those entered already, by first call
    last_calls   stop -> when the day's last trip leaves it; where trips only end, when it arrives
    """

    day: date
    holiday: ServiceException | None
    spans: tuple[Span, ...]
    departures: tuple[Departure, ...]
    last_calls: dict[str, datetime]

    @property
    def last_run(self) -> Departure | None:
        """The trip that is the last to be under way."""
        return max(self.departures, key=lambda d: (d.calls[-1].leave_at, d.departure_id), default=None)


def calendar_of(uow: UnitOfWork) -> ServiceCalendar:
    """From now on. Raises CampusUnknown."""
    # A night's service and a timetable past midnight began yesterday.
    return whole_calendar(uow, (uow.now - timedelta(days=2)).date())


def whole_calendar(uow: UnitOfWork, since: date | None = None) -> ServiceCalendar:
    """With the exceptions of past days, or of those since a day. Raises CampusUnknown."""
    timezone = uow.network().road_map.timezone
    return ServiceCalendar(timezone, uow.service.patterns(), uow.service.exceptions(since), uow.rules.hours)


def service_day(uow: UnitOfWork, day: date | None = None) -> ServiceDay:
    """What runs on a local day, today when none is named. Raises CampusUnknown."""
    road_map = uow.network().road_map
    calendar = whole_calendar(uow)
    shown = calendar.day_of(uow.now) if day is None else day
    made = [
        _as_entered(uow, departure)
        for departure in departures_of(
            uow.campus_id, trips_on(uow, calendar, shown), road_map.timezone, shown
        )
    ]
    return ServiceDay(shown, calendar.holiday(shown), calendar.spans(shown), tuple(made), _last_calls(made))


def timetable_of(uow: UnitOfWork) -> Timetable:
    """The version in force: the newest of the operators, or the map's own. Raises CampusUnknown."""
    edited = uow.service.timetable()
    own = uow.network().road_map.timetable
    return Timetable(uow.campus_id, MAPS_OWN_REVISION, own) if edited is None else edited


def trips_of(uow: UnitOfWork) -> tuple[TimetableTrip, ...]:
    """The trips in force whose stops the active map has. Raises CampusUnknown."""
    unserved = {one.trip_id for one in unserved_of(uow)}
    return tuple(trip for trip in timetable_of(uow).trips if trip.trip_id not in unserved)


def unserved_of(uow: UnitOfWork) -> tuple[UnservedTrip, ...]:
    """The trips in force that do not run, because the active map lacks a stop. Raises CampusUnknown."""
    return unserved_trips(timetable_of(uow).trips, uow.network().stops)


def trips_on(uow: UnitOfWork, calendar: ServiceCalendar, day: date) -> tuple[TimetableTrip, ...]:
    """The timetable's trips whose service runs on that day."""
    return tuple(trip for trip in trips_of(uow) if calendar.runs(trip.service_id, day))


def _as_entered(uow: UnitOfWork, departure: Departure) -> Departure:
    """With what has become of it. One that was withdrawn for new times is not entered with them yet."""
    known = uow.departures.get(departure.departure_id)
    is_outdated = (
        known is not None and known.state is DepartureState.WITHDRAWN and known.calls != departure.calls
    )
    return departure if known is None or is_outdated else known


def _last_calls(made: Sequence[Departure]) -> dict[str, datetime]:
    left: dict[str, datetime] = {}
    ended: dict[str, datetime] = {}
    for departure in made:
        for call in departure.calls[:-1]:
            left[call.stop_id] = max(left.get(call.stop_id, call.leave_at), call.leave_at)
        last = departure.calls[-1]
        ended[last.stop_id] = max(ended.get(last.stop_id, last.leave_at), last.leave_at)
    return ended | left
