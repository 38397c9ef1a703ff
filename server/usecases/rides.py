"""What a passenger can do with a ride: book, cancel, tap aboard, call for help."""

from server.domain.incidents import Incident
from server.domain.rides import BookRide, Ride, Tap, TapKind
from server.usecases.ports import UnitOfWork


def book(uow: UnitOfWork, request: BookRide) -> Ride:
    """The ride with its vehicle and its promise; or the ride in state `refused` with the rule that binds.

    A repeated idempotency_key gives the earlier ride. A refused ride is kept, so that operators see what
    was asked for in vain; its `reason` is no_vehicle_free | seats | wheelchair | pickup_window |
    ride_time. Raises what cannot even be asked: StopUnknown, SameStop, StopUnreachable, PartyInvalid,
    PartyTooLarge, OutsideServiceHours, BookingTooFarAhead, IdempotencyMismatch, CampusUnknown.
    """
    raise NotImplementedError


def cancel(uow: UnitOfWork, ride_id: str, by: str) -> Ride:
    """by: "passenger" | "operator" | "developer". Raises RideUnknown, RideAlreadyAboard, RideEnded."""
    raise NotImplementedError


def tap(uow: UnitOfWork, ride_id: str, kind: TapKind) -> Tap:
    """Pass a tap on the phone to the ride's vehicle, which accepts it while it stands with doors open.

    Raises RideUnknown, RideEnded, RideNotAssigned, RideAlreadyAboard (board), RideNotAboard (alight),
    VehicleNotConnected.
    """
    raise NotImplementedError


def call_help(uow: UnitOfWork, ride_id: str, text: str) -> Incident:
    """Put the passenger's call on top of the incidents; an open call is kept. Raises RideUnknown."""
    raise NotImplementedError


def ride_of(uow: UnitOfWork, ride_id: str) -> Ride:
    """Raises RideUnknown."""
    raise NotImplementedError


def ride_by_code(uow: UnitOfWork, ride_code: str) -> Ride:
    """Codes are read without regard to case and spaces. Raises RideUnknown."""
    raise NotImplementedError


def ride_by_token(uow: UnitOfWork, token: str) -> Ride:
    """Raises RideUnknown."""
    raise NotImplementedError
