"""Rides as operators and developers list, explain and change them."""

from typing import Annotated

from fastapi import APIRouter, Depends, Query

from server.api.commands import AdminCommand, DispatchCommand
from server.api.formats import NAME_PATTERN, Moment, RideId, StopId
from server.api.paging import LIMIT_MAX, Page, microseconds_of, moment_of, paged
from server.api.problems import problems
from server.api.rides.schemas import (
    CallerBooking,
    DecisionView,
    DestinationRequest,
    RideDelayView,
    RideEventView,
    RideRecord,
    RideRequest,
)
from server.api.rides.views import (
    alternative_view,
    booking,
    decision_view,
    feedback_view,
    ride_delay_view,
    ride_event_view,
    ride_record,
)
from server.api.security.access import (
    DRIVER_REFUSALS,
    OPERATOR_REFUSALS,
    READER_REFUSALS,
    Actor,
    Reader,
    changing,
)
from server.api.security.permissions import PREVIEW
from server.api.services import InjectedServices
from server.domain.errors import (
    BookingTooFarAhead,
    CampusUnknown,
    DestinationRefused,
    DomainError,
    NoService,
    PartyInvalid,
    PartyTooLarge,
    RideEnded,
    RideNotAssigned,
    RideNotEnded,
    RideUnknown,
    SameStop,
    StopUnknown,
    StopUnreachable,
)
from server.domain.planning.outlooks import RideOutlook
from server.domain.rides.feedback import Feedback
from server.domain.rides.rides import Ride, RideSource, RideState
from server.usecases.planning.outlooks import outlook_of, outlooks_of
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.rides import destinations, erasure, rides
from server.usecases.rides.delays import delays_by
from server.usecases.rides.tickets import secrets_of

router = APIRouter(prefix="/rides", tags=["rides"])


@router.get("", operation_id="list_rides", responses=paged(*READER_REFUSALS))
async def list_rides(
    services: InjectedServices,
    reader: Reader,
    page: Page,
    state: Annotated[list[RideState] | None, Query(description="Only these states.")] = None,
    vehicle_id: Annotated[str | None, Query(pattern=NAME_PATTERN)] = None,
    before: Annotated[Moment | None, Query(description="Requested before this moment.")] = None,
    since: Annotated[Moment | None, Query(description="Requested at this moment or later.")] = None,
    stop_id: Annotated[StopId | None, Query(description="From or to this stop.")] = None,
    code: Annotated[
        str | None,
        Query(max_length=16, pattern=r"^[A-Za-z0-9 -]+$", description="Case and spaces do not matter."),
    ] = None,
    limit: Annotated[int, Query(ge=1, le=LIMIT_MAX)] = 200,
) -> list[RideRecord]:
    """Newest request first."""

    ended = page.after(int, str)
    after = None if ended is None else (moment_of(ended[0]), str(ended[1]))

    def work(uow: UnitOfWork) -> list[RideRecord]:
        found = uow.views.rides(
            states=state,
            vehicle_id=vehicle_id,
            limit=limit + 1,
            before=before,
            after=after,
            since=since,
            stop_id=stop_id,
            ride_code=None if code is None else "".join(code.split()).upper(),
        )
        told = uow.rides.feedback_of([ride.ride_id for ride in found if ride.has_ended])
        outlooks = outlooks_of(uow, found)
        return [
            _record(uow, ride, reader.kind, told.get(ride.ride_id), outlooks[ride.ride_id]) for ride in found
        ]

    records = await services.transactions.read(work)
    return page.first(records, limit, lambda ride: (microseconds_of(ride.requested_at), ride.ride_id))


@router.get(
    "/id/{ride_id}", operation_id="get_ride_record", responses=problems(RideUnknown, *READER_REFUSALS)
)
async def get_ride_record(ride_id: RideId, services: InjectedServices, reader: Reader) -> RideRecord:
    def work(uow: UnitOfWork) -> RideRecord:
        ride = rides.ride_of(uow, ride_id)
        told = uow.rides.feedback_of([ride_id]).get(ride_id)
        return _record(uow, ride, reader.kind, told)

    return await services.transactions.read(work)


@router.get(
    "/id/{ride_id}/decisions",
    operation_id="explain_ride",
    responses=problems(RideUnknown, *READER_REFUSALS),
)
async def explain_ride(ride_id: RideId, services: InjectedServices, _: Reader) -> list[DecisionView]:
    """Why the ride got its shuttle, or none: each decision about it, oldest first."""

    def work(uow: UnitOfWork) -> list[DecisionView]:
        ride = rides.ride_of(uow, ride_id)
        return [decision_view(one) for one in uow.decisions.of_ride(ride.ride_id)]

    return await services.transactions.read(work)


@router.get(
    "/id/{ride_id}/history",
    operation_id="ride_history",
    responses=problems(RideUnknown, *READER_REFUSALS),
)
async def ride_history(ride_id: RideId, services: InjectedServices, reader: Reader) -> list[RideEventView]:
    """What has happened to the ride, oldest first. What passengers wrote is for operators only."""

    def work(uow: UnitOfWork) -> list[RideEventView]:
        ride = rides.ride_of(uow, ride_id)
        with_words = reader.kind == "operator"
        return [ride_event_view(event, with_words) for event in uow.views.events_about(ride.ride_id)]

    return await services.transactions.read(work)


@router.post(
    "/id/{ride_id}/delays",
    operation_id="preview_ride_delays",
    responses=problems(RideUnknown, RideNotAssigned, *DRIVER_REFUSALS),
)
async def preview_ride_delays(
    ride_id: RideId, services: InjectedServices, _: Annotated[Actor, Depends(changing(PREVIEW))]
) -> list[RideDelayView]:
    """Which other rides of its shuttle come later because of this one, and by how much. Nothing changes: the
    shuttle is planned without the ride, and that is taken back."""
    return [ride_delay_view(one) for one in await delays_by(services.transactions, ride_id)]


@router.post(
    "/for-caller",
    operation_id="book_for_caller",
    status_code=201,
    responses=problems(
        StopUnknown,
        CampusUnknown,
        SameStop,
        PartyInvalid,
        StopUnreachable,
        PartyTooLarge,
        NoService,
        BookingTooFarAhead,
        *DRIVER_REFUSALS,
    ),
)
async def book_for_caller(request: RideRequest, command: DispatchCommand) -> CallerBooking:
    """Book for somebody who calls. Answered like a passenger's booking: tell the caller codes and times, or
    an alternative."""

    def work(uow: UnitOfWork) -> CallerBooking:
        (answer,) = rides.book_all(uow, [booking(request, None, command.kind)])
        if isinstance(answer, DomainError):
            raise answer
        return CallerBooking(
            ride=_record(uow, answer.ride, command.kind, outlook=answer.outlook),
            alternatives=[alternative_view(one) for one in answer.alternatives],
        )

    return await command.transact(CallerBooking, work)


@router.post(
    "/id/{ride_id}/cancel",
    operation_id="cancel_ride_by_operator",
    responses=problems(RideUnknown, RideEnded, DestinationRefused, *DRIVER_REFUSALS),
)
async def cancel_ride_by_operator(ride_id: RideId, command: DispatchCommand) -> RideRecord:
    def work(uow: UnitOfWork) -> RideRecord:
        return _record(uow, rides.cancel(uow, ride_id, command.kind), command.kind)

    return await command.transact(RideRecord, work)


@router.post(
    "/id/{ride_id}/destination",
    operation_id="change_destination_by_operator",
    responses=problems(
        RideUnknown,
        StopUnknown,
        SameStop,
        StopUnreachable,
        RideEnded,
        NoService,
        DestinationRefused,
        *DRIVER_REFUSALS,
    ),
)
async def change_destination_by_operator(
    ride_id: RideId, request: DestinationRequest, command: DispatchCommand
) -> RideRecord:
    def work(uow: UnitOfWork) -> RideRecord:
        ride = rides.ride_of(uow, ride_id)
        changed = destinations.change_destination(uow, ride, request.to_stop, command.kind)
        return _record(uow, changed, command.kind)

    return await command.transact(RideRecord, work)


@router.post(
    "/id/{ride_id}/erase",
    operation_id="erase_ride",
    responses=problems(RideUnknown, RideNotEnded, *OPERATOR_REFUSALS),
)
async def erase_ride(ride_id: RideId, command: AdminCommand) -> RideRecord:
    """Take out of the record who rode: code, link, messages. Stops, times and party stay for statistics."""

    def work(uow: UnitOfWork) -> RideRecord:
        return _record(uow, erasure.erase_ride(uow, ride_id, command.by), command.kind)

    return await command.transact(RideRecord, work)


def _record(
    uow: UnitOfWork,
    ride: Ride,
    reader: RideSource,
    told: Feedback | None = None,
    outlook: RideOutlook | None = None,
) -> RideRecord:
    """A boarding code and a passenger's words stay with the passenger and the operators.

    outlook  where it is known already
    """
    code = secrets_of(uow, ride).boarding_code if reader == "operator" else ""
    feedback = None if told is None else feedback_view(told, with_words=reader == "operator")
    return ride_record(ride, code, outlook or outlook_of(uow, ride), feedback)
