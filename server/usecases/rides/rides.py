"""What a passenger can do with a ride: book, cancel, tap aboard, call for help."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta

from server.domain.errors import (
    BookingTooFarAhead,
    DomainError,
    IdempotencyMismatch,
    NoRestingPlaceFree,
    NoService,
    PartyInvalid,
    PartyTooLarge,
    RideAlreadyAboard,
    RideEnded,
    RideNotAboard,
    RideNotAssigned,
    RideUnknown,
    SameStop,
    StopUnknown,
    StopUnreachable,
    VehicleNotConnected,
)
from server.domain.planning.decisions import Alternative
from server.domain.planning.outlooks import NO_OUTLOOK, RideOutlook
from server.domain.record.incidents import Incident, IncidentKind
from server.domain.rides.rides import (
    BookRide,
    Ride,
    RideState,
    Tap,
    TapKind,
    cancelled,
    ended,
)
from server.domain.rides.ticket_keys import RideSecrets
from server.domain.service.service import ServiceCalendar
from server.usecases.planning import plans, unreachable_rides
from server.usecases.planning.assign import AssignmentResult, assign_rides
from server.usecases.planning.outlooks import outlook_of
from server.usecases.ports import topics
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.calendars import calendar_of
from server.usecases.record.incidents import open_incident
from server.usecases.record.refusals import IN_TIME, REFUSAL_TEXTS, closing_text
from server.usecases.record.server_events import record_event
from server.usecases.rides import destinations
from server.usecases.rides.tickets import secrets_of


@dataclass(frozen=True, slots=True)
class BookingResult:
    """The answer to a booking; alternatives for a refused ride."""

    ride: Ride
    secrets: RideSecrets
    alternatives: tuple[Alternative, ...] = ()
    outlook: RideOutlook = NO_OUTLOOK


def book(uow: UnitOfWork, request: BookRide) -> Ride:
    """The ride with its vehicle and its promise; or the ride in state `refused` with the rule that binds.

    A repeated idempotency_key gives the earlier ride. A refused ride is stored, so that operators see it;
    its `reason` is one of `dispatch.refusal.RULES`, or no_service (it would end after closing). Raises, if
    the request is not possible at all: StopUnknown, SameStop, StopUnreachable, PartyInvalid, PartyTooLarge,
    NoService, BookingTooFarAhead, IdempotencyMismatch, CampusUnknown.
    """
    answer = book_all(uow, [request])[0]
    if isinstance(answer, DomainError):
        raise answer
    return answer.ride


def book_all(uow: UnitOfWork, requests: Sequence[BookRide]) -> list[BookingResult | DomainError]:
    """`book` for several requests on one snapshot of the fleet: a ride or an error for each."""
    answers: list[Ride | DomainError] = []
    calendar = calendar_of(uow)
    asked: dict[str, tuple[Ride, BookRide]] = {}
    for request in requests:
        try:
            ride = _earlier_booking(uow, request)
            if ride is None:
                ride = _new_ride(uow, request, closing_time(uow, request, calendar))
                uow.rides.add(ride)
                asked[ride.ride_id] = ride, request
            answers.append(ride)
        except DomainError as error:
            answers.append(error)
    decided: dict[str, BookingResult] = {}
    walking = frozenset(ride_id for ride_id, (_, request) in asked.items() if request.may_walk)
    assigned = _assign(uow, [ride for ride, _ in asked.values()], walking)
    for (ride, request), answer in zip(asked.values(), assigned, strict=True):
        booked = answer.ride
        if answer.rule:
            booked = _refused_ride(uow, ride, answer.rule)
            uow.rides.save(booked)
        detail = (
            f"{request.from_stop} to {request.to_stop}, party of {request.party} {booked.reason}".rstrip()
        )
        _record_and_publish(
            uow, booked, "ride.refused" if answer.rule else "ride.booked", request.source, detail
        )
        decided[ride.ride_id] = BookingResult(
            booked, secrets_of(uow, booked), answer.alternatives, outlook_of(uow, booked)
        )
    return [
        answer if isinstance(answer, DomainError) else decided.get(answer.ride_id) or _repeated(uow, answer)
        for answer in answers
    ]


def _repeated(uow: UnitOfWork, ride: Ride) -> BookingResult:
    return BookingResult(ride, secrets_of(uow, ride), alternatives_for(uow, ride), outlook_of(uow, ride))


def _assign(uow: UnitOfWork, rides: Sequence[Ride], walking: frozenset[str]) -> list[AssignmentResult]:
    def now(uow: UnitOfWork, rides: Sequence[Ride]) -> list[AssignmentResult]:
        return _assign_now(uow, rides, walking)

    if rides and uow.has_closures():
        return unreachable_rides.book_around_closures(uow, rides, now)
    return now(uow, rides)


def _assign_now(uow: UnitOfWork, rides: Sequence[Ride], walking: frozenset[str]) -> list[AssignmentResult]:
    try:
        return assign_rides(uow, rides, "booking", walking=walking)
    except NoRestingPlaceFree:
        if len(rides) > 1:
            raise
        return [AssignmentResult(rides[0], "no_vehicle_free")]


def alternatives_for(uow: UnitOfWork, ride: Ride) -> tuple[Alternative, ...]:
    """What would have been accepted when this ride was refused; empty for any other ride."""
    if ride.state is not RideState.REFUSED:
        return ()
    decided = uow.decisions.of_ride(ride.ride_id)
    return decided[-1].alternatives if decided else ()


def cancel(uow: UnitOfWork, ride_id: str, by: str, *, unless_aboard: bool = False) -> Ride:
    """Cancel the ride. A party aboard is let out as soon as possible, and the ride ends there.

    by             "passenger" | "operator" | "developer"
    unless_aboard  refuse it for a party aboard: it was asked for before they boarded

    Raises RideUnknown, RideEnded, RideAlreadyAboard, DestinationRefused (aboard a shuttle that cannot be
    given a way).
    """
    ride = ride_of(uow, ride_id)
    if ride.state is RideState.ABOARD:
        if unless_aboard:
            raise RideAlreadyAboard("you are aboard already; the ride was not cancelled")
        return ride if ride.let_out else destinations.let_out(uow, ride, by)
    gone = cancelled(ride, by, uow.now)
    uow.rides.save(gone)
    _record_and_publish(uow, gone, "ride.cancelled", by)
    if ride.vehicle_id is not None:
        plans.replan(uow, ride.vehicle_id)
    return gone


def tap(uow: UnitOfWork, ride_id: str, kind: TapKind) -> Tap:
    """Pass a tap on the phone to the ride's vehicle, which accepts it while it stands with doors open.

    Raises RideUnknown, RideEnded, RideNotAssigned, RideAlreadyAboard (board), RideNotAboard (alight),
    VehicleNotConnected.
    """
    ride = ride_of(uow, ride_id)
    vehicle_id = _tapped_vehicle(ride, kind)
    vehicle = uow.vehicles.get(vehicle_id)
    if vehicle is None or not vehicle.connected:
        raise VehicleNotConnected("the shuttle cannot be reached now; type your code on its screen")
    made = Tap(uow.campus_id, uow.ids.new_id("tap"), ride_id, vehicle_id, kind, uow.now)
    uow.rides.add_tap(made)
    uow.publish(topics.vehicle_outbox(uow.campus_id, vehicle_id))
    return made


def call_help(uow: UnitOfWork, ride_id: str, text: str) -> Incident:
    """Open an incident of the highest priority; an open call is kept. Raises RideUnknown."""
    ride = ride_of(uow, ride_id)
    said = text.strip() or "no message"
    incident = open_incident(
        uow,
        IncidentKind.HELP_CALL,
        ride_id,
        f"ride {ride.ride_code} ({ride.state}) calls for help: {said}",
        vehicle_id=ride.vehicle_id,
        ride_id=ride_id,
    )
    _record_and_publish(uow, ride, "ride.help_called", "passenger", said)
    return incident


def ride_of(uow: UnitOfWork, ride_id: str) -> Ride:
    """Raises RideUnknown."""
    return _require_found(uow.rides.get(ride_id), f"there is no ride {ride_id}")


def ride_by_code(uow: UnitOfWork, ride_code: str) -> Ride:
    """Case and spaces in the code do not matter. Raises RideUnknown."""
    code = "".join(ride_code.split()).upper()
    return _require_found(uow.rides.by_code(code), f"no ride has the code {code}; check it")


def _require_found(ride: Ride | None, detail: str) -> Ride:
    if ride is None:
        raise RideUnknown(detail)
    return ride


def _earlier_booking(uow: UnitOfWork, request: BookRide) -> Ride | None:
    if request.idempotency_key is None:
        return None
    ride = uow.rides.by_idempotency_key(request.idempotency_key)
    if ride is None:
        return None
    same_stops = (ride.from_stop, ride.to_stop) == (request.from_stop, request.to_stop)
    same_party = (ride.party, ride.wheelchairs) == (request.party, request.wheelchairs)
    if not same_party or not (same_stops or request.may_walk):
        raise IdempotencyMismatch("this Idempotency-Key belongs to another booking; use a new one")
    return ride


def _refused_ride(uow: UnitOfWork, ride: Ride, rule: str) -> Ride:
    if rule in IN_TIME and ride.arrive_before is not None:
        patience_s = uow.rules.wait_s_max + uow.roads().direct_s(ride.from_stop, ride.to_stop)
        if ride.arrive_before <= ride.earliest + timedelta(seconds=patience_s):
            detail = closing_text(calendar_of(uow), ride.arrive_before)
            return ended(ride, RideState.REFUSED, uow.now, NoService.code, detail)
    return ended(ride, RideState.REFUSED, uow.now, rule, REFUSAL_TEXTS[rule])


def require_bookable(uow: UnitOfWork, request: BookRide) -> None:
    """Raises, if the request is possible at no time: StopUnknown, SameStop, PartyInvalid, PartyTooLarge,
    StopUnreachable."""
    roads, rules = uow.roads(), uow.rules
    for stop_id in (request.from_stop, request.to_stop):
        if stop_id not in roads.stop_numbers:
            raise StopUnknown(f"the map has no stop {stop_id}")
    if request.from_stop == request.to_stop:
        raise SameStop("from and to are the same stop")
    if request.party < 1 or not 0 <= request.wheelchairs <= request.party:
        raise PartyInvalid("a party has at least one person, and no more wheelchairs than people")
    if request.party > rules.seats_max:
        raise PartyTooLarge(f"a shuttle seats {rules.seats_max}; split your party into several bookings")
    if math.isinf(roads.direct_s(request.from_stop, request.to_stop)):
        raise StopUnreachable("no road leads from the one stop to the other")


def closing_time(uow: UnitOfWork, request: BookRide, calendar: ServiceCalendar) -> datetime | None:
    """When the service closes after the ride; None when it does not.

    Raises NoService, BookingTooFarAhead and what require_bookable does.
    """
    require_bookable(uow, request)
    rules = uow.rules
    earliest = max(uow.now, request.earliest or uow.now)
    if (earliest - uow.now).total_seconds() > rules.booking_ahead_s_max:
        days = rules.booking_ahead_s_max / 86400.0
        raise BookingTooFarAhead(f"rides can be booked {days:.0f} days ahead at most")
    calendar.require_open(earliest)
    closes = calendar.closes_after(earliest)
    direct_s = uow.travel_time_factor_at(earliest) * uow.roads().direct_s(request.from_stop, request.to_stop)
    if closes is not None and earliest + timedelta(seconds=direct_s) > closes:
        raise NoService(closing_text(calendar, closes))
    return closes


def _new_ride(uow: UnitOfWork, request: BookRide, closes: datetime | None) -> Ride:
    code = uow.ids.ride_code()
    while uow.rides.code_in_use(code):
        code = uow.ids.ride_code()
    return Ride(
        campus_id=uow.campus_id,
        ride_id=uow.ids.new_id("ride"),
        ride_code=code,
        ticket_key_id=uow.tickets.newest_id,
        state=RideState.REQUESTED,
        from_stop=request.from_stop,
        to_stop=request.to_stop,
        party=request.party,
        wheelchairs=request.wheelchairs,
        earliest=max(uow.now, request.earliest or uow.now),
        requested_at=uow.now,
        source=request.source,
        idempotency_key=request.idempotency_key,
        arrive_before=closes,
        series_id=request.series_id,
    )


def _tapped_vehicle(ride: Ride, kind: TapKind) -> str:
    if ride.has_ended:
        raise RideEnded(f"ride {ride.ride_code} is {ride.state}")
    if ride.vehicle_id is None:
        raise RideNotAssigned("no shuttle has this ride yet")
    if kind == "board" and ride.state is RideState.ABOARD:
        raise RideAlreadyAboard("you are aboard already")
    if kind == "alight" and ride.state is not RideState.ABOARD:
        raise RideNotAboard("you are not aboard yet")
    return ride.vehicle_id


def _record_and_publish(uow: UnitOfWork, ride: Ride, name: str, by: str, detail: str = "") -> None:
    record_event(uow, name, ride.ride_id, by, detail)
    uow.publish(topics.ride(uow.campus_id, ride.ride_id), state=str(ride.state))
