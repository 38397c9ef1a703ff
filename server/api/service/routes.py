"""The service's days and hours: the public timetable of a day, and the calendars for operators."""

from datetime import date
from typing import Annotated

from fastapi import APIRouter, Path, Query

from server.api.formats import NAME_PATTERN, Name
from server.api.problems import CsrfMissing, problems
from server.api.security.access import ChangingOperator, ReadingOperator
from server.api.service.schemas import (
    ExceptionBody,
    ExceptionView,
    PatternBody,
    PatternView,
    ServiceView,
    TimetableDay,
    exception_view,
    pattern_of,
    pattern_view,
    timetable_day,
)
from server.api.services import InjectedServices
from server.domain.errors import (
    CampusUnknown,
    ExceptionUnknown,
    PatternInUse,
    PatternInvalid,
    PatternUnknown,
    SessionExpired,
)
from server.domain.service.service import ServiceException
from server.usecases.fleet import service
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record import calendars

router = APIRouter(tags=["service"])

ServiceId = Annotated[Name, Path(pattern=NAME_PATTERN, examples=["term"])]
# Beyond these a calendar's arithmetic would leave the range of dates.
Day = Annotated[date, Path(ge=date(2000, 1, 1), le=date(2100, 1, 1), examples=["2026-10-01"])]
AskedDay = Annotated[
    date | None,
    Query(ge=date(2000, 1, 1), le=date(2100, 1, 1), description="Campus local; today if left out."),
]


@router.get("/timetable", operation_id="get_timetable", responses=problems(CampusUnknown))
async def get_timetable(services: InjectedServices, day: AskedDay = None) -> TimetableDay:
    """What runs on one day: hours for rides, timetable trips, and which run is the last."""

    def work(uow: UnitOfWork) -> TimetableDay:
        road_map = uow.network().road_map
        named = {trip.trip_id: trip.service_id for trip in road_map.timetable}
        return timetable_day(calendars.service_day(uow, day), road_map.timezone, named)

    return await services.transactions.read(work)


@router.get("/service", operation_id="get_service", responses=problems(SessionExpired, CampusUnknown))
async def get_service(services: InjectedServices, _: ReadingOperator) -> ServiceView:
    """Calendars and their exceptions."""

    def work(uow: UnitOfWork) -> ServiceView:
        calendar = calendars.calendar_of(uow)
        return ServiceView(
            timezone=calendar.timezone,
            patterns=[
                pattern_view(pattern, _trips(uow, pattern.service_id)) for pattern in calendar.patterns
            ],
            exceptions=[exception_view(exception) for exception in calendar.exceptions],
            rides_outside=service.rides_outside(uow),
        )

    return await services.transactions.read(work)


@router.put(
    "/service/patterns/{service_id}",
    operation_id="put_service_pattern",
    responses=problems(PatternInvalid, CampusUnknown, SessionExpired, CsrfMissing),
)
async def put_service_pattern(
    service_id: ServiceId, body: PatternBody, services: InjectedServices, operator: ChangingOperator
) -> PatternView:
    """Enter a service's days and hours, or change them. Departures on days without service are withdrawn."""

    def work(uow: UnitOfWork) -> PatternView:
        pattern = pattern_of(uow.campus_id, service_id, body)
        return pattern_view(service.save_pattern(uow, pattern, operator.name), _trips(uow, service_id))

    return await services.transactions.run(work)


@router.delete(
    "/service/patterns/{service_id}",
    operation_id="delete_service_pattern",
    status_code=204,
    responses=problems(PatternUnknown, PatternInUse, CampusUnknown, SessionExpired, CsrfMissing),
)
async def delete_service_pattern(
    service_id: ServiceId, services: InjectedServices, operator: ChangingOperator
) -> None:
    """Remove a calendar with its exceptions. Refused while the timetable has trips of it."""
    await services.transactions.run(lambda uow: service.remove_pattern(uow, service_id, operator.name))


@router.put(
    "/service/exceptions/{day}",
    operation_id="put_service_exception",
    responses=problems(PatternUnknown, CampusUnknown, SessionExpired, CsrfMissing),
)
async def put_service_exception(
    day: Day, body: ExceptionBody, services: InjectedServices, operator: ChangingOperator
) -> ExceptionView:
    """A holiday of the whole campus, or a day on which one service runs or does not."""

    def work(uow: UnitOfWork) -> ServiceException:
        exception = ServiceException(uow.campus_id, day, body.service_id, body.runs, body.note, operator.name)
        return service.save_exception(uow, exception)

    return exception_view(await services.transactions.run(work))


@router.delete(
    "/service/exceptions/{day}",
    operation_id="delete_service_exception",
    status_code=204,
    responses=problems(ExceptionUnknown, CampusUnknown, SessionExpired, CsrfMissing),
)
async def delete_service_exception(
    day: Day,
    services: InjectedServices,
    operator: ChangingOperator,
    service_id: Annotated[
        str, Query(pattern=f"^$|{NAME_PATTERN}", description="Empty: the holiday of the whole campus.")
    ] = "",
) -> None:
    await services.transactions.run(lambda uow: service.remove_exception(uow, day, service_id, operator.name))


def _trips(uow: UnitOfWork, service_id: str) -> int:
    return sum(trip.service_id == service_id for trip in uow.network().road_map.timetable)
