"""Recurring bookings: made and cancelled by passengers, and managed by operators."""

from typing import Annotated

from fastapi import APIRouter, Path, Query

from server.api.commands import AdminCommand, DispatchCommand, IdempotencyKey, PassengerCommand, booking_key
from server.api.formats import NAME_PATTERN, RideToken
from server.api.paging import LIMIT_MAX, Page, microseconds_of, moment_of, paged
from server.api.problems import problems
from server.api.security.access import (
    DRIVER_REFUSALS,
    OPERATOR_REFUSALS,
    READER_REFUSALS,
    Client,
    OptionalDeveloper,
    Reader,
    now_ns,
)
from server.api.security.rate_limit import TooManyTries
from server.api.series.schemas import (
    SeriesDay,
    SeriesErasure,
    SeriesRecord,
    SeriesRequest,
    SeriesTicket,
    series_record,
    series_request,
    series_ticket,
)
from server.api.services import InjectedServices
from server.domain.errors import (
    CampusUnknown,
    DestinationRefused,
    IdempotencyMismatch,
    NoService,
    OccurrenceEnded,
    PartyInvalid,
    PartyTooLarge,
    RideEnded,
    RideNotEnded,
    SameStop,
    ScopeMissing,
    SeriesEnded,
    SeriesInvalid,
    SeriesUnknown,
    StopUnknown,
    StopUnreachable,
    TokenInvalid,
)
from server.domain.rides.rides import RideSource
from server.domain.rides.series import Series, SeriesState
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.calendars import calendar_of
from server.usecases.rides import erasure, series
from server.usecases.rides.tickets import series_by_token, series_token

router = APIRouter(prefix="/series", tags=["series"])

SeriesId = Annotated[str, Path(pattern=NAME_PATTERN, examples=["series-7b21"])]


@router.post(
    "",
    operation_id="book_series",
    status_code=201,
    responses=problems(
        StopUnknown,
        CampusUnknown,
        SameStop,
        PartyInvalid,
        StopUnreachable,
        PartyTooLarge,
        SeriesInvalid,
        NoService,
        IdempotencyMismatch,
        TooManyTries,
        TokenInvalid,
        ScopeMissing,
    ),
)
async def book_series(
    request: SeriesRequest,
    services: InjectedServices,
    client: Client,
    developer: OptionalDeveloper,
    idempotency_key: IdempotencyKey = None,
) -> SeriesTicket:
    """Each day becomes a ride one day ahead. A day that cannot be booked has a reason, and is tried again."""
    services.limits.bookings.take(client if developer is None else developer.account, now_ns(services))
    source: RideSource = "passenger" if developer is None else "developer"
    booking = series_request(request, booking_key(developer, idempotency_key), source)
    return await services.transactions.run(lambda uow: _ticket(uow, series.book_series(uow, booking)))


@router.get("", operation_id="list_series", responses=paged(CampusUnknown, *READER_REFUSALS))
async def list_series(
    services: InjectedServices,
    _: Reader,
    page: Page,
    state: Annotated[list[SeriesState] | None, Query(description="Only these states.")] = None,
    limit: Annotated[int, Query(ge=1, le=LIMIT_MAX)] = 200,
) -> list[SeriesRecord]:
    """Newest first."""
    ended = page.after(int, str)
    after = None if ended is None else (moment_of(ended[0]), str(ended[1]))
    found = await services.transactions.read(
        lambda uow: [_record(uow, one) for one in uow.series.listed(state, limit + 1, after)]
    )
    return page.first(found, limit, lambda one: (microseconds_of(one.made_at), one.series_id))


@router.get("/{token}", operation_id="get_series", responses=problems(SeriesUnknown, CampusUnknown))
async def get_series(token: RideToken, services: InjectedServices) -> SeriesTicket:
    """With each of its days: booked, still too far ahead, skipped, or the reason why it has no ride."""
    return await services.transactions.read(lambda uow: _ticket(uow, series_by_token(uow, token)))


@router.post(
    "/{token}/cancel",
    operation_id="cancel_series",
    responses=problems(SeriesUnknown, SeriesEnded, CampusUnknown, IdempotencyMismatch, TooManyTries),
)
async def cancel_series(token: RideToken, command: PassengerCommand) -> SeriesTicket:
    """No further rides. Booked rides are cancelled, except one that is under way."""

    def work(uow: UnitOfWork) -> SeriesTicket:
        known = series_by_token(uow, token)
        return _ticket(uow, series.cancel_series(uow, known.series_id, command.kind))

    return await command.transact(SeriesTicket, work)


@router.post(
    "/{token}/days/{day}/cancel",
    operation_id="cancel_series_day",
    responses=problems(
        SeriesUnknown,
        SeriesEnded,
        OccurrenceEnded,
        RideEnded,
        DestinationRefused,
        CampusUnknown,
        IdempotencyMismatch,
        TooManyTries,
    ),
)
async def cancel_series_day(
    token: RideToken, day: Annotated[SeriesDay, Path()], command: PassengerCommand
) -> SeriesTicket:
    """Only this day."""

    def work(uow: UnitOfWork) -> SeriesTicket:
        known = series_by_token(uow, token)
        return _ticket(uow, series.cancel_occurrence(uow, known.series_id, day, command.kind))

    return await command.transact(SeriesTicket, work)


@router.post(
    "/id/{series_id}/cancel",
    operation_id="cancel_series_by_operator",
    responses=problems(SeriesUnknown, SeriesEnded, CampusUnknown, *DRIVER_REFUSALS),
)
async def cancel_series_by_operator(series_id: SeriesId, command: DispatchCommand) -> SeriesRecord:
    return await command.transact(
        SeriesRecord, lambda uow: _record(uow, series.cancel_series(uow, series_id, command.kind))
    )


@router.post(
    "/id/{series_id}/erase",
    operation_id="erase_series",
    responses=problems(SeriesUnknown, RideNotEnded, DestinationRefused, *OPERATOR_REFUSALS),
)
async def erase_series(series_id: SeriesId, command: AdminCommand) -> SeriesErasure:
    """Cancel it, drop it with its days, and take out of the record who rode on them."""
    return await command.transact(
        SeriesErasure, lambda uow: SeriesErasure(rides=erasure.erase_series(uow, series_id, command.by))
    )


def _ticket(uow: UnitOfWork, found: Series) -> SeriesTicket:
    days = series.occurrences_of(uow, found)
    return series_ticket(found, series_token(uow, found), calendar_of(uow).timezone, days)


def _record(uow: UnitOfWork, found: Series) -> SeriesRecord:
    return series_record(found, uow.network().road_map.timezone)
