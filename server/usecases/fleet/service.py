"""The days and hours of the service, edited by operators."""

from datetime import date

from contract.roads.model import RoadMap
from server.domain.errors import ExceptionUnknown, PatternInUse, PatternUnknown
from server.domain.rides.rides import RideState
from server.domain.service.service import (
    WHOLE_CAMPUS,
    ServiceException,
    ServicePattern,
    require_sound,
)
from server.usecases.fleet import departures
from server.usecases.ports import topics
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.calendars import calendar_of, timetable_of
from server.usecases.record.server_events import record_event

EVERY_DAY = tuple(range(7))


def enter_services(uow: UnitOfWork, road_map: RoadMap) -> None:
    """Give every service of the map's timetable without a pattern a pattern of all days."""
    for service_id in dict.fromkeys(trip.service_id for trip in road_map.timetable):
        if service_id and uow.service.pattern(service_id) is None:
            uow.service.save_pattern(ServicePattern(uow.campus_id, service_id, service_id, EVERY_DAY))


def save_pattern(uow: UnitOfWork, pattern: ServicePattern, by: str) -> ServicePattern:
    """New, or in place of the one of this service. Raises PatternInvalid."""
    require_sound(pattern)
    uow.service.save_pattern(pattern)
    _changed(uow, "service.pattern_saved", pattern.service_id, by)
    return pattern


def remove_pattern(uow: UnitOfWork, service_id: str, by: str) -> None:
    """With its exceptions. Raises PatternUnknown, PatternInUse."""
    if uow.service.pattern(service_id) is None:
        raise PatternUnknown(f"no service {service_id} has a calendar")
    trips = [trip.trip_id for trip in timetable_of(uow).trips if trip.service_id == service_id]
    if trips:
        raise PatternInUse(
            f"{len(trips)} trips of the timetable run by {service_id}; change its days instead of removing it"
        )
    uow.service.remove_pattern(service_id)
    _changed(uow, "service.pattern_removed", service_id, by)


def save_exception(uow: UnitOfWork, exception: ServiceException) -> ServiceException:
    """New, or in place of the one of this day and service. Raises PatternUnknown."""
    service_id = exception.service_id
    if service_id != WHOLE_CAMPUS and uow.service.pattern(service_id) is None:
        raise PatternUnknown(
            f"no service {service_id} has a calendar; leave it out for a holiday of the campus"
        )
    uow.service.save_exception(exception)
    _changed(uow, "service.exception_saved", _name_of(exception.day, service_id), exception.made_by)
    return exception


def remove_exception(uow: UnitOfWork, day: date, service_id: str, by: str) -> None:
    """Raises ExceptionUnknown."""
    if not uow.service.remove_exception(day, service_id):
        raise ExceptionUnknown(
            f"nothing is different on {day:%d %B %Y} for {service_id or 'the whole campus'}"
        )
    _changed(uow, "service.exception_removed", _name_of(day, service_id), by)


def rides_outside(uow: UnitOfWork) -> int:
    """How many promised rides begin outside of the service. They are kept unless they are cancelled."""
    calendar = calendar_of(uow)
    waiting = uow.rides.in_states([RideState.REQUESTED, RideState.ASSIGNED])
    return sum(not calendar.is_open(max(ride.earliest, uow.now)) for ride in waiting)


def _changed(uow: UnitOfWork, name: str, subject: str, by: str) -> None:
    record_event(uow, name, subject, by)
    uow.publish(topics.service(uow.campus_id))
    departures.withdraw_unserved(uow, calendar_of(uow))


def _name_of(day: date, service_id: str) -> str:
    return f"{day.isoformat()} {service_id}".rstrip()
