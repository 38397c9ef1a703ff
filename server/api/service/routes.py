"""The service's days and hours: the public timetable of a day, and the calendars for operators."""

from datetime import date
from typing import Annotated

from fastapi import APIRouter, Path, Query

from server.api.commands import ServiceCommand
from server.api.formats import NAME_PATTERN, Name
from server.api.problems import problems
from server.api.security.access import OPERATOR_REFUSALS, READER_REFUSALS, Reader
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
)
from server.domain.service.service import ServiceException
from server.usecases.fleet import service
from server.usecases.planning.outlooks import seats_left_of
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
        named = {trip.trip_id: trip.service_id for trip in calendars.trips_of(uow)}
        shown = calendars.service_day(uow, day)
        seats_left = {one.departure_id: seats_left_of(uow, one) for one in shown.departures}
        return timetable_day(shown, road_map.timezone, named, seats_left)

    return await services.transactions.read(work)


@router.get("/service", operation_id="get_service", responses=problems(CampusUnknown, *READER_REFUSALS))
async def get_service(services: InjectedServices, _: Reader) -> ServiceView:
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
    responses=problems(PatternInvalid, CampusUnknown, *OPERATOR_REFUSALS),
)
async def put_service_pattern(
    service_id: ServiceId, body: PatternBody, command: ServiceCommand
) -> PatternView:
    """Enter a service's days and hours, or change them. Departures on days without service are withdrawn."""

    def work(uow: UnitOfWork) -> PatternView:
        pattern = pattern_of(uow.campus_id, service_id, body)
        return pattern_view(service.save_pattern(uow, pattern, command.by), _trips(uow, service_id))

    return await command.transact(PatternView, work)


@router.delete(
    "/service/patterns/{service_id}",
    operation_id="delete_service_pattern",
    status_code=204,
    responses=problems(PatternUnknown, PatternInUse, CampusUnknown, *OPERATOR_REFUSALS),
)
async def delete_service_pattern(service_id: ServiceId, command: ServiceCommand) -> None:
    """Remove a calendar with its exceptions. Refused while the timetable has trips of it."""

    def work(uow: UnitOfWork) -> None:
        service.remove_pattern(uow, service_id, command.by)

    await command.transact(type(None), work)


@router.put(
    "/service/exceptions/{day}",
    operation_id="put_service_exception",
    responses=problems(PatternUnknown, CampusUnknown, *OPERATOR_REFUSALS),
)
async def put_service_exception(day: Day, body: ExceptionBody, command: ServiceCommand) -> ExceptionView:
    """A holiday of the whole campus, or a day on which one service runs or does not."""

    def work(uow: UnitOfWork) -> ExceptionView:
        exception = ServiceException(uow.campus_id, day, body.service_id, body.runs, body.note, command.by)
        return exception_view(service.save_exception(uow, exception))

    return await command.transact(ExceptionView, work)


@router.delete(
    "/service/exceptions/{day}",
    operation_id="delete_service_exception",
    status_code=204,
    responses=problems(ExceptionUnknown, CampusUnknown, *OPERATOR_REFUSALS),
)
async def delete_service_exception(
    day: Day,
    command: ServiceCommand,
    service_id: Annotated[
        str, Query(pattern=f"^$|{NAME_PATTERN}", description="Empty: the holiday of the whole campus.")
    ] = "",
) -> None:
    def work(uow: UnitOfWork) -> None:
        service.remove_exception(uow, day, service_id, command.by)

    await command.transact(type(None), work)


def _trips(uow: UnitOfWork, service_id: str) -> int:
    return sum(trip.service_id == service_id for trip in calendars.timetable_of(uow).trips)
