"""Recurring bookings: made and cancelled by passengers, and managed by operators."""

from typing import Annotated

from fastapi import APIRouter, Path, Query

from server.api.formats import NAME_PATTERN, TOKEN_PATTERN
from server.api.problems import CsrfMissing, problems
from server.api.rides.routes import IdempotencyKey
from server.api.security.access import (
    ChangingOperator,
    Client,
    ReadingOperator,
    now_ns,
)
from server.api.security.rate_limit import TooManyTries
from server.api.series.schemas import (
    SeriesDay,
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
    SameStop,
    SeriesEnded,
    SeriesInvalid,
    SeriesUnknown,
    SessionExpired,
    StopUnknown,
    StopUnreachable,
)
from server.domain.rides.series import Series, SeriesState
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.calendars import calendar_of
from server.usecases.rides import series

router = APIRouter(prefix="/series", tags=["series"])

SeriesToken = Annotated[
    str,
    Path(
        pattern=TOKEN_PATTERN,
        description="The secret of the booking's link, from its answer.",
        examples=["q3Jv0X2mQp7sT4uYb1cD9w"],
    ),
]
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
    ),
)
async def book_series(
    request: SeriesRequest, services: InjectedServices, client: Client, idempotency_key: IdempotencyKey = None
) -> SeriesTicket:
    """Each day becomes a ride one day ahead. A day that cannot be booked has a reason, and is tried again."""
    services.limits.bookings.take(client, now_ns(services))
    booking = series_request(request, idempotency_key)
    return await services.transactions.run(lambda uow: _ticket(uow, series.book_series(uow, booking)))


@router.get("", operation_id="list_series", responses=problems(SessionExpired, CampusUnknown))
async def list_series(
    services: InjectedServices,
    _: ReadingOperator,
    state: Annotated[list[SeriesState] | None, Query(description="Only these states.")] = None,
    limit: Annotated[int, Query(ge=1, le=500)] = 200,
) -> list[SeriesRecord]:
    """Newest first."""
    return await services.transactions.read(
        lambda uow: [_record(uow, found) for found in uow.series.listed(state, limit)]
    )


@router.get("/{token}", operation_id="get_series", responses=problems(SeriesUnknown, CampusUnknown))
async def get_series(token: SeriesToken, services: InjectedServices) -> SeriesTicket:
    """With each of its days: booked, still too far ahead, skipped, or the reason why it has no ride."""
    return await services.transactions.read(lambda uow: _ticket(uow, series.series_by_token(uow, token)))


@router.post(
    "/{token}/cancel",
    operation_id="cancel_series",
    responses=problems(SeriesUnknown, SeriesEnded, CampusUnknown),
)
async def cancel_series(token: SeriesToken, services: InjectedServices) -> SeriesTicket:
    """No further rides. Booked rides are cancelled, except one that is under way."""

    def work(uow: UnitOfWork) -> SeriesTicket:
        known = series.series_by_token(uow, token)
        return _ticket(uow, series.cancel_series(uow, known.series_id, "passenger"))

    return await services.transactions.run(work)


@router.post(
    "/{token}/days/{day}/cancel",
    operation_id="cancel_series_day",
    responses=problems(
        SeriesUnknown, SeriesEnded, OccurrenceEnded, RideEnded, DestinationRefused, CampusUnknown
    ),
)
async def cancel_series_day(
    token: SeriesToken, day: Annotated[SeriesDay, Path()], services: InjectedServices
) -> SeriesTicket:
    """Only this day."""

    def work(uow: UnitOfWork) -> SeriesTicket:
        known = series.series_by_token(uow, token)
        return _ticket(uow, series.cancel_occurrence(uow, known.series_id, day, "passenger"))

    return await services.transactions.run(work)


@router.post(
    "/id/{series_id}/cancel",
    operation_id="cancel_series_by_operator",
    responses=problems(SeriesUnknown, SeriesEnded, CampusUnknown, SessionExpired, CsrfMissing),
)
async def cancel_series_by_operator(
    series_id: SeriesId, services: InjectedServices, _: ChangingOperator
) -> SeriesRecord:
    return await services.transactions.run(
        lambda uow: _record(uow, series.cancel_series(uow, series_id, "operator"))
    )


def _ticket(uow: UnitOfWork, found: Series) -> SeriesTicket:
    return series_ticket(found, calendar_of(uow).timezone, series.occurrences_of(uow, found))


def _record(uow: UnitOfWork, found: Series) -> SeriesRecord:
    return series_record(found, uow.network().road_map.timezone)
