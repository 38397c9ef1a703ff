"""Rides: booked and followed by passengers without an account, and managed by operators."""

from typing import Annotated

from fastapi import APIRouter, Header, Query

from server.api.formats import NAME_PATTERN, Moment, RideId, RideToken, TapId
from server.api.problems import CsrfMissing, problems
from server.api.rides.schemas import (
    DecisionView,
    DestinationRequest,
    HelpAnswer,
    HelpRequest,
    RideRecord,
    RideRequest,
    RideTicket,
    RideView,
    TapView,
    booking,
    decision_view,
    ride_record,
    ride_ticket,
    ride_view,
    tap_view,
)
from server.api.security.access import (
    ChangingOperator,
    Client,
    ReadingOperator,
    now_ns,
)
from server.api.security.rate_limit import TooManyTries
from server.api.services import InjectedServices
from server.domain.errors import (
    BookingTooFarAhead,
    CampusUnknown,
    CommandUnknown,
    DestinationRefused,
    IdempotencyMismatch,
    NoService,
    PartyInvalid,
    PartyTooLarge,
    RideAlreadyAboard,
    RideEnded,
    RideNotAboard,
    RideNotAssigned,
    RideUnknown,
    SameStop,
    SessionExpired,
    StopUnknown,
    StopUnreachable,
    VehicleNotConnected,
)
from server.domain.record.incidents import Incident
from server.domain.rides.rides import (
    Ride,
    RideState,
    Tap,
    TapKind,
)
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.rides import destinations, rides

router = APIRouter(prefix="/rides", tags=["rides"])

IdempotencyKey = Annotated[
    str | None,
    Header(
        min_length=8,
        max_length=128,
        pattern=r"^[\x21-\x7e]+$",
        description="Made by the client for each booking; a repeat with it gives the same answer.",
        examples=["6f1d0c1e-2b7a-4f0e-9a34-0d5c2f7be801"],
    ),
]


@router.post(
    "",
    operation_id="book_ride",
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
        IdempotencyMismatch,
        TooManyTries,
    ),
)
async def book_ride(
    request: RideRequest,
    services: InjectedServices,
    client: Client,
    idempotency_key: IdempotencyKey = None,
) -> RideTicket:
    """Answered at once: with a vehicle and a promise, or as a ride in state `refused` whose `reason` names
    the rule that binds."""
    services.limits.bookings.take(client, now_ns(services))
    booking_request = booking(request, idempotency_key)
    booked = await services.bookings.book(booking_request)
    return ride_ticket(booked.ride, booked.alternatives)


@router.get("", operation_id="list_rides", responses=problems(SessionExpired))
async def list_rides(
    services: InjectedServices,
    _: ReadingOperator,
    state: Annotated[list[RideState] | None, Query(description="Only these states.")] = None,
    vehicle_id: Annotated[str | None, Query(pattern=NAME_PATTERN)] = None,
    before: Annotated[Moment | None, Query(description="Requested before this moment: pages on.")] = None,
    limit: Annotated[int, Query(ge=1, le=500)] = 200,
) -> list[RideRecord]:
    """Newest request first."""

    found = await services.transactions.read(
        lambda uow: uow.views.rides(states=state, vehicle_id=vehicle_id, limit=limit, before=before)
    )
    return [ride_record(ride) for ride in found]


@router.get("/lookup", operation_id="find_ride", responses=problems(RideUnknown, TooManyTries))
async def find_ride(
    services: InjectedServices,
    client: Client,
    code: Annotated[
        str, Query(min_length=6, max_length=16, pattern=r"^[A-Za-z0-9 -]+$", examples=["K7MQ2X"])
    ],
) -> RideView:
    """A ride by its code, which a passenger can say aloud. Case and spaces do not matter."""
    services.limits.lookups.take(client, now_ns(services))
    return ride_view(await services.transactions.read(lambda uow: rides.ride_by_code(uow, code)))


@router.get("/{token}", operation_id="get_ride", responses=problems(RideUnknown))
async def get_ride(token: RideToken, services: InjectedServices) -> RideTicket:

    def work(uow: UnitOfWork) -> RideTicket:
        ride = rides.ride_by_token(uow, token)
        return ride_ticket(ride, rides.alternatives_for(uow, ride))

    return await services.transactions.read(work)


@router.post(
    "/{token}/cancel",
    operation_id="cancel_ride",
    responses=problems(RideUnknown, RideEnded, DestinationRefused),
)
async def cancel_ride(token: RideToken, services: InjectedServices) -> RideTicket:
    """A party aboard is let out as soon as possible: the answer says at which stop, with `let_out` true."""

    def work(uow: UnitOfWork) -> Ride:
        return rides.cancel(uow, rides.ride_by_token(uow, token).ride_id, "passenger")

    return ride_ticket(await services.transactions.run(work))


@router.post(
    "/{token}/destination",
    operation_id="change_destination",
    responses=problems(
        RideUnknown,
        StopUnknown,
        SameStop,
        StopUnreachable,
        RideEnded,
        NoService,
        DestinationRefused,
    ),
)
async def change_destination(
    token: RideToken, request: DestinationRequest, services: InjectedServices
) -> RideTicket:
    """Another destination while the party waits or rides. The pickup promise stays, and the ride gets a new
    latest arrival. No other promise changes, so the change may be refused with the rule that binds."""

    def work(uow: UnitOfWork) -> Ride:
        ride = rides.ride_by_token(uow, token)
        return destinations.change_destination(uow, ride, request.to_stop, "passenger")

    return ride_ticket(await services.transactions.run(work))


@router.post(
    "/{token}/board",
    operation_id="tap_aboard",
    status_code=202,
    responses=problems(RideUnknown, RideEnded, RideNotAssigned, RideAlreadyAboard, VehicleNotConnected),
)
async def tap_aboard(token: RideToken, services: InjectedServices) -> TapView:
    """Tell the shuttle that the party has boarded; it answers by the tap's state and the ride's."""
    return await _tap(services, token, "board")


@router.post(
    "/{token}/alight",
    operation_id="tap_alighted",
    status_code=202,
    responses=problems(RideUnknown, RideEnded, RideNotAssigned, RideNotAboard, VehicleNotConnected),
)
async def tap_alighted(token: RideToken, services: InjectedServices) -> TapView:
    """Tell the shuttle that the party has got off."""
    return await _tap(services, token, "alight")


@router.get("/{token}/taps/{tap_id}", operation_id="get_tap", responses=problems(RideUnknown, CommandUnknown))
async def get_tap(token: RideToken, tap_id: TapId, services: InjectedServices) -> TapView:
    """The shuttle's answer to a tap."""

    def work(uow: UnitOfWork) -> Tap:
        ride = rides.ride_by_token(uow, token)
        tap = uow.rides.tap(tap_id)
        if tap is None or tap.ride_id != ride.ride_id:
            raise CommandUnknown(f"this ride has no tap {tap_id}")
        return tap

    return tap_view(await services.transactions.read(work))


@router.post("/{token}/help", operation_id="call_help", status_code=201, responses=problems(RideUnknown))
async def call_help(token: RideToken, request: HelpRequest, services: InjectedServices) -> HelpAnswer:
    """Put a call for help on top of the operators' incidents. A repeat keeps the open call."""

    def work(uow: UnitOfWork) -> Incident:
        return rides.call_help(uow, rides.ride_by_token(uow, token).ride_id, request.text)

    return HelpAnswer(incident_id=(await services.transactions.run(work)).incident_id)


@router.get("/id/{ride_id}", operation_id="get_ride_record", responses=problems(RideUnknown, SessionExpired))
async def get_ride_record(ride_id: RideId, services: InjectedServices, _: ReadingOperator) -> RideRecord:
    return ride_record(await services.transactions.read(lambda uow: rides.ride_of(uow, ride_id)))


@router.get(
    "/id/{ride_id}/decisions",
    operation_id="explain_ride",
    responses=problems(RideUnknown, SessionExpired),
)
async def explain_ride(ride_id: RideId, services: InjectedServices, _: ReadingOperator) -> list[DecisionView]:
    """Why the ride got its shuttle, or none: each decision about it, oldest first."""

    def work(uow: UnitOfWork) -> list[DecisionView]:
        ride = rides.ride_of(uow, ride_id)
        return [decision_view(one) for one in uow.decisions.of_ride(ride.ride_id)]

    return await services.transactions.read(work)


@router.post(
    "/id/{ride_id}/cancel",
    operation_id="cancel_ride_by_operator",
    responses=problems(RideUnknown, RideEnded, DestinationRefused, SessionExpired, CsrfMissing),
)
async def cancel_ride_by_operator(
    ride_id: RideId, services: InjectedServices, _: ChangingOperator
) -> RideRecord:
    return ride_record(await services.transactions.run(lambda uow: rides.cancel(uow, ride_id, "operator")))


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
        SessionExpired,
        CsrfMissing,
    ),
)
async def change_destination_by_operator(
    ride_id: RideId, request: DestinationRequest, services: InjectedServices, _: ChangingOperator
) -> RideRecord:
    def work(uow: UnitOfWork) -> Ride:
        ride = rides.ride_of(uow, ride_id)
        return destinations.change_destination(uow, ride, request.to_stop, "operator")

    return ride_record(await services.transactions.run(work))


async def _tap(services: InjectedServices, token: str, kind: TapKind) -> TapView:
    def work(uow: UnitOfWork) -> Tap:
        return rides.tap(uow, rides.ride_by_token(uow, token).ride_id, kind)

    return tap_view(await services.transactions.run(work))
