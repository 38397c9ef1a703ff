"""Rides, booked and followed by passengers without an account."""

from typing import Annotated

from fastapi import APIRouter, Query, Request

from contract.tracing import BOOKING
from server.api.commands import IdempotencyKey, PassengerCommand, booking_key
from server.api.formats import RideToken, TapId
from server.api.problems import problems
from server.api.request_ids import current_request_id
from server.api.rides.schemas import (
    DestinationRequest,
    FeedbackRequest,
    FeedbackView,
    HelpAnswer,
    HelpRequest,
    OfferView,
    RideRequest,
    RideTicket,
    RideView,
    TapView,
)
from server.api.rides.views import booking, feedback_view, offer_view, ride_ticket, ride_view, tap_view
from server.api.security.access import (
    Client,
    OptionalDeveloper,
    now_ns,
)
from server.api.security.rate_limit import TooManyTries
from server.api.security.request_origin import address_of
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
    RideNotCompleted,
    RideUnknown,
    SameStop,
    ScopeMissing,
    StopUnknown,
    StopUnreachable,
    TokenInvalid,
    VehicleNotConnected,
)
from server.domain.record.audit import Caller
from server.domain.rides.rides import (
    Ride,
    RideSource,
    Tap,
    TapKind,
)
from server.usecases.planning.outlooks import outlook_of
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.rides import destinations, feedback, rides
from server.usecases.rides.offers import offer_for
from server.usecases.rides.tickets import ride_by_token, secrets_of

router = APIRouter(prefix="/rides", tags=["rides"])


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
        TokenInvalid,
        ScopeMissing,
    ),
)
async def book_ride(
    http: Request,
    request: RideRequest,
    services: InjectedServices,
    client: Client,
    developer: OptionalDeveloper,
    idempotency_key: IdempotencyKey = None,
) -> RideTicket:
    """Answered at once: with a vehicle and a promise, or as a ride in state `refused` whose `reason` names
    the rule that binds."""
    services.limits.bookings.take(client if developer is None else developer.account, now_ns(services))
    source: RideSource = "passenger" if developer is None else "developer"
    booking_request = booking(request, booking_key(developer, idempotency_key), source)
    begun_ns = now_ns(services)
    caller = None if developer is None else Caller(developer.kind, developer.name, address_of(http))
    booked = await services.bookings.book(booking_request, caller)
    if services.spans is not None:
        identified = {"request_id": current_request_id()}
        services.spans.add([booked.ride.ride_id], BOOKING, begun_ns, now_ns(services), **identified)
    return ride_ticket(booked.ride, booked.secrets, booked.outlook, booked.alternatives)


@router.post(
    "/offers",
    operation_id="look_for_ride",
    responses=problems(
        StopUnknown,
        CampusUnknown,
        SameStop,
        PartyInvalid,
        StopUnreachable,
        PartyTooLarge,
        NoService,
        BookingTooFarAhead,
        TooManyTries,
    ),
)
async def look_for_ride(request: RideRequest, services: InjectedServices, client: Client) -> OfferView:
    """Whether a booking would get a shuttle now, for a party that was refused and waits for one. Nothing is
    reserved or stored."""
    services.limits.offers.take(client, now_ns(services))
    wanted = booking(request, None, "passenger")
    return offer_view(await services.transactions.read(lambda uow: offer_for(uow, wanted)))


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

    def work(uow: UnitOfWork) -> RideView:
        ride = rides.ride_by_code(uow, code)
        return ride_view(ride, outlook_of(uow, ride))

    return await services.transactions.read(work)


@router.get("/{token}", operation_id="get_ride", responses=problems(RideUnknown))
async def get_ride(token: RideToken, services: InjectedServices) -> RideTicket:

    def work(uow: UnitOfWork) -> RideTicket:
        ride = ride_by_token(uow, token)
        told = uow.rides.feedback_of([ride.ride_id]).get(ride.ride_id) if ride.has_ended else None
        others = rides.alternatives_for(uow, ride)
        return ride_ticket(ride, secrets_of(uow, ride), outlook_of(uow, ride), others, told)

    return await services.transactions.read(work)


@router.post(
    "/{token}/cancel",
    operation_id="cancel_ride",
    responses=problems(
        RideUnknown, RideEnded, RideAlreadyAboard, DestinationRefused, IdempotencyMismatch, TooManyTries
    ),
)
async def cancel_ride(token: RideToken, command: PassengerCommand, unless_aboard: bool = False) -> RideTicket:
    """A party aboard is let out as soon as possible: the answer says at which stop, with `let_out` true.

    With `unless_aboard` a party aboard goes on, and the answer is 409 `ride_already_aboard`: for a
    cancellation that was asked for earlier, without a connection.
    """

    def work(uow: UnitOfWork) -> RideTicket:
        ride_id = ride_by_token(uow, token).ride_id
        return _ticket(uow, rides.cancel(uow, ride_id, command.kind, unless_aboard=unless_aboard))

    return await command.transact(RideTicket, work)


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
        IdempotencyMismatch,
        TooManyTries,
    ),
)
async def change_destination(
    token: RideToken, request: DestinationRequest, command: PassengerCommand
) -> RideTicket:
    """Another destination while the party waits or rides. The pickup promise stays, and the ride gets a new
    latest arrival. No other promise changes, so the change may be refused with the rule that binds."""

    def work(uow: UnitOfWork) -> RideTicket:
        ride = ride_by_token(uow, token)
        return _ticket(uow, destinations.change_destination(uow, ride, request.to_stop, command.kind))

    return await command.transact(RideTicket, work)


@router.post(
    "/{token}/board",
    operation_id="tap_aboard",
    status_code=202,
    responses=problems(
        RideUnknown,
        RideEnded,
        RideNotAssigned,
        RideAlreadyAboard,
        VehicleNotConnected,
        IdempotencyMismatch,
        TooManyTries,
    ),
)
async def tap_aboard(token: RideToken, command: PassengerCommand) -> TapView:
    """Tell the shuttle that the party has boarded; it answers by the tap's state and the ride's."""
    return await _tap(command, token, "board")


@router.post(
    "/{token}/alight",
    operation_id="tap_alighted",
    status_code=202,
    responses=problems(
        RideUnknown,
        RideEnded,
        RideNotAssigned,
        RideNotAboard,
        VehicleNotConnected,
        IdempotencyMismatch,
        TooManyTries,
    ),
)
async def tap_alighted(token: RideToken, command: PassengerCommand) -> TapView:
    """Tell the shuttle that the party has got off."""
    return await _tap(command, token, "alight")


@router.get("/{token}/taps/{tap_id}", operation_id="get_tap", responses=problems(RideUnknown, CommandUnknown))
async def get_tap(token: RideToken, tap_id: TapId, services: InjectedServices) -> TapView:
    """The shuttle's answer to a tap."""

    def work(uow: UnitOfWork) -> Tap:
        ride = ride_by_token(uow, token)
        tap = uow.rides.tap(tap_id)
        if tap is None or tap.ride_id != ride.ride_id:
            raise CommandUnknown(f"this ride has no tap {tap_id}")
        return tap

    return tap_view(await services.transactions.read(work))


@router.post(
    "/{token}/help",
    operation_id="call_help",
    status_code=201,
    responses=problems(RideUnknown, IdempotencyMismatch, TooManyTries),
)
async def call_help(token: RideToken, request: HelpRequest, command: PassengerCommand) -> HelpAnswer:
    """Put a call for help on top of the operators' incidents. A repeat keeps the open call."""

    def work(uow: UnitOfWork) -> HelpAnswer:
        ride = ride_by_token(uow, token)
        return HelpAnswer(incident_id=rides.call_help(uow, ride.ride_id, request.text).incident_id)

    return await command.transact(HelpAnswer, work)


@router.post(
    "/{token}/feedback",
    operation_id="give_feedback",
    responses=problems(RideUnknown, RideNotCompleted, IdempotencyMismatch, TooManyTries),
)
async def give_feedback(
    token: RideToken, request: FeedbackRequest, command: PassengerCommand
) -> FeedbackView:
    """A rating, and what was left in the shuttle, after a ride that was taken. Told again, it replaces what
    was told before."""

    def work(uow: UnitOfWork) -> FeedbackView:
        ride = ride_by_token(uow, token)
        return feedback_view(feedback.give_feedback(uow, ride, request.rating, request.lost_property))

    return await command.transact(FeedbackView, work)


async def _tap(command: PassengerCommand, token: str, kind: TapKind) -> TapView:
    def work(uow: UnitOfWork) -> TapView:
        return tap_view(rides.tap(uow, ride_by_token(uow, token).ride_id, kind))

    return await command.transact(TapView, work)


def _ticket(uow: UnitOfWork, ride: Ride) -> RideTicket:
    return ride_ticket(ride, secrets_of(uow, ride), outlook_of(uow, ride))
