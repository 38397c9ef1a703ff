"""Rides as operators and developers list, explain and change them."""

from typing import Annotated

from fastapi import APIRouter, Query

from server.api.commands import AdminCommand, DispatchCommand
from server.api.formats import NAME_PATTERN, Moment, RideId
from server.api.paging import LIMIT_MAX, Page, microseconds_of, moment_of, paged
from server.api.problems import problems
from server.api.rides.schemas import (
    DecisionView,
    DestinationRequest,
    RideRecord,
    decision_view,
    feedback_view,
    ride_record,
)
from server.api.security.access import DRIVER_REFUSALS, OPERATOR_REFUSALS, READER_REFUSALS, Reader
from server.api.services import InjectedServices
from server.domain.errors import (
    DestinationRefused,
    NoService,
    RideEnded,
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
    limit: Annotated[int, Query(ge=1, le=LIMIT_MAX)] = 200,
) -> list[RideRecord]:
    """Newest request first."""

    ended = page.after(int, str)
    after = None if ended is None else (moment_of(ended[0]), str(ended[1]))

    def work(uow: UnitOfWork) -> list[RideRecord]:
        found = uow.views.rides(
            states=state, vehicle_id=vehicle_id, limit=limit + 1, before=before, after=after
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
