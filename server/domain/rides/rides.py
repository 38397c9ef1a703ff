"""A ride: a party's request to go from stop to stop, its state, and the promise that answered it."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from datetime import datetime
from enum import StrEnum
from typing import Literal

from contract.wire.messages import BoardedHow
from server.domain.errors import IllegalTransition, RideAlreadyAboard, RideEnded, RideNotEnded


class RideState(StrEnum):
    REQUESTED = "requested"
    ASSIGNED = "assigned"
    BOARDING = "boarding"
    ABOARD = "aboard"
    COMPLETED = "completed"
    REFUSED = "refused"
    CANCELLED = "cancelled"
    NO_SHOW = "no_show"
    FAILED = "failed"


S = RideState

# What the server may decide, and what a vehicle may report about its own rides.
TRANSITIONS: Mapping[RideState, frozenset[RideState]] = {
    S.REQUESTED: frozenset({S.ASSIGNED, S.ABOARD, S.REFUSED, S.CANCELLED, S.FAILED}),
    S.ASSIGNED: frozenset({S.REQUESTED, S.BOARDING, S.ABOARD, S.CANCELLED, S.NO_SHOW, S.FAILED}),
    S.BOARDING: frozenset({S.REQUESTED, S.ABOARD, S.CANCELLED, S.NO_SHOW, S.FAILED}),
    # Back to waiting where the shuttle cannot go on.
    S.ABOARD: frozenset({S.REQUESTED, S.COMPLETED, S.FAILED}),
    S.COMPLETED: frozenset(),
    S.REFUSED: frozenset(),
    # A cancellation or a no-show can cross a boarding on a vehicle that was out of reach.
    S.CANCELLED: frozenset({S.ABOARD}),
    S.NO_SHOW: frozenset({S.ABOARD}),
    S.FAILED: frozenset(),
}
ENDED = frozenset({S.COMPLETED, S.REFUSED, S.CANCELLED, S.NO_SHOW, S.FAILED})
WAITING = frozenset({S.ASSIGNED, S.BOARDING})

# Instead of the id of a ticket key: no link leads to the ride any more.
ERASED = "erased"

RideSource = Literal["passenger", "operator", "developer"]
TapKind = Literal["board", "alight"]


@dataclass(frozen=True, slots=True)
class BookRide:
    """A passenger's request. earliest None means now.

    idempotency_key   a repeated booking with the same key gives the same ride
    series_id         the recurring booking that it is a day of
    may_walk          other stops within walking distance will do, at either end
    """

    from_stop: str
    to_stop: str
    party: int
    wheelchairs: int = 0
    earliest: datetime | None = None
    idempotency_key: str | None = None
    source: RideSource = "passenger"
    series_id: str | None = None
    may_walk: bool = False


@dataclass(frozen=True, slots=True)
class Promise:
    """The party will be picked up within [pickup_from, pickup_to] and be there by arrive_by."""

    pickup_from: datetime
    pickup_to: datetime
    arrive_by: datetime


@dataclass(frozen=True, slots=True)
class Ride:
    """One party's ride.

    ride_code     six unambiguous characters, to be said aloud
    ticket_key_id the key that the link's token and the boarding code are derived from, see TicketKeys
    reason        stable code of a refusal, cancellation or failure, "" otherwise; reason_detail as a sentence
    pickup_eta, arrival_eta  the times of the present plan; the promise changes only with the destination
    arrive_before  no promise is made beyond this moment: the service closes then
    first_to_stop  the destination it was booked to, None while that is the present one
    let_out       the party wants to get off as soon as possible; to_stop is where
    series_id     the recurring booking that it is a day of
    stranded_by   the shuttle that carried the party and cannot go on; another one comes to from_stop
    pinned        an operator chose its vehicle: no improvement moves it to another one
    """

    campus_id: str
    ride_id: str
    ride_code: str
    ticket_key_id: str
    state: RideState
    from_stop: str
    to_stop: str
    party: int
    wheelchairs: int
    earliest: datetime
    requested_at: datetime
    source: RideSource
    promise: Promise | None = None
    vehicle_id: str | None = None
    pickup_eta: datetime | None = None
    arrival_eta: datetime | None = None
    boarded_at: datetime | None = None
    boarded_how: BoardedHow | None = None
    ended_at: datetime | None = None
    reason: str = ""
    reason_detail: str = ""
    promise_broken: bool = False
    first_promise: Promise | None = None
    left_early: bool = False
    idempotency_key: str | None = None
    arrive_before: datetime | None = None
    first_to_stop: str | None = None
    let_out: bool = False
    series_id: str | None = None
    stranded_by: str | None = None
    pinned: bool = False

    @property
    def has_ended(self) -> bool:
        return self.state in ENDED


@dataclass(frozen=True, slots=True)
class Tap:
    """A tap on the phone on its way to the vehicle, which accepts or refuses it."""

    campus_id: str
    tap_id: str
    ride_id: str
    vehicle_id: str
    kind: TapKind
    made_at: datetime
    state: Literal["pending", "accepted", "refused"] = "pending"
    reason: str = ""


def moved(ride: Ride, state: RideState) -> Ride:
    """The ride in its next state. Raises IllegalTransition where TRANSITIONS does not allow it."""
    if state not in TRANSITIONS[ride.state]:
        raise IllegalTransition(f"ride {ride.ride_code} is {ride.state} and cannot become {state}")
    return replace(ride, state=state)


def assigned(ride: Ride, vehicle_id: str, pickup_eta: datetime, arrival_eta: datetime) -> Ride:
    return replace(
        moved(ride, S.ASSIGNED), vehicle_id=vehicle_id, pickup_eta=pickup_eta, arrival_eta=arrival_eta
    )


def unassigned(ride: Ride) -> Ride:
    """The ride without its vehicle; the promise stays."""
    return replace(moved(ride, S.REQUESTED), vehicle_id=None, pickup_eta=None, arrival_eta=None, pinned=False)


def stranded(ride: Ride, from_stop: str, earliest: datetime, at: datetime) -> Ride:
    """The party has to leave a shuttle that cannot go on, and waits at this stop for another one."""
    return replace(
        moved(ride, S.REQUESTED),
        from_stop=from_stop,
        earliest=earliest,
        requested_at=at,
        arrive_before=None,
        promise=None,
        first_promise=ride.first_promise or ride.promise,
        promise_broken=True,
        vehicle_id=None,
        pickup_eta=None,
        arrival_eta=None,
        boarded_at=None,
        boarded_how=None,
        let_out=False,
        stranded_by=ride.vehicle_id,
    )


def promised_anew(ride: Ride, promise: Promise) -> Ride:
    """The ride with a new promise, because the old one cannot be kept. The first one is kept."""
    return replace(
        ride, promise=promise, first_promise=ride.first_promise or ride.promise, promise_broken=True
    )


def boarded(ride: Ride, how: BoardedHow, at: datetime) -> Ride:
    return replace(
        moved(ride, S.ABOARD), boarded_at=at, boarded_how=how, ended_at=None, reason="", reason_detail=""
    )


def ended(ride: Ride, state: RideState, at: datetime, reason: str = "", detail: str = "") -> Ride:
    return replace(moved(ride, state), ended_at=at, reason=reason, reason_detail=detail)


def erased(ride: Ride) -> Ride:
    """The ride without what names its rider. Raises RideNotEnded."""
    if not ride.has_ended:
        raise RideNotEnded(f"ride {ride.ride_code} is {ride.state}; cancel it, or erase it when it has ended")
    return replace(
        ride, ride_code="", ticket_key_id=ERASED, idempotency_key=None, series_id=None, reason_detail=""
    )


def redirected(ride: Ride, to_stop: str) -> Ride:
    """The ride to another stop. A change back to the first stop leaves no trace."""
    first = ride.to_stop if ride.first_to_stop is None else ride.first_to_stop
    return replace(ride, to_stop=to_stop, first_to_stop=None if to_stop == first else first, let_out=False)


def cancelled(ride: Ride, by: str, at: datetime) -> Ride:
    """Raises RideAlreadyAboard, RideEnded."""
    if ride.state is S.ABOARD:
        raise RideAlreadyAboard("you are in the shuttle; press the seat button to get off early")
    if ride.has_ended:
        raise RideEnded(f"ride {ride.ride_code} is {ride.state} already")
    return ended(ride, S.CANCELLED, at, f"cancelled_by_{by}")
