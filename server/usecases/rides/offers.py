"""Whether a booking would get a shuttle now: for passengers who were refused and wait for one to be free."""

from dataclasses import dataclass, replace
from datetime import datetime

from server.dispatch.answer import answer_all
from server.dispatch.refusal import CLOSED
from server.dispatch.schedule.schedule import Schedule
from server.domain.rides.rides import BookRide, Ride, RideState
from server.usecases.planning.snapshot import moment, take_snapshot
from server.usecases.planning.unreachable_rides import is_cut_off_then
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.calendars import calendar_of
from server.usecases.rides.rides import closing_time

# No ride has it: nothing of an offer is stored.
_OFFER_ID = "offer"


@dataclass(frozen=True, slots=True)
class RideOffer:
    """What a booking would get now; nothing is reserved.

    rule        that would bind, "" where a shuttle is free; pickup_at, arrival_at: planned, None without one
    """

    rule: str
    pickup_at: datetime | None = None
    arrival_at: datetime | None = None

    @property
    def is_free(self) -> bool:
        return self.rule == ""


def offer_for(uow: UnitOfWork, request: BookRide) -> RideOffer:
    """Reads only. Raises what `rides.book` raises of a request that is not possible at all."""
    ride = _as_ride(uow, request, closing_time(uow, request, calendar_of(uow)))
    if uow.has_closures() and is_cut_off_then(uow, ride, uow.closures.standing()):
        return RideOffer(CLOSED)
    snapshot = take_snapshot(uow, wanted=[ride])
    schedule = Schedule(snapshot.problem)
    schedule.add(snapshot.problem.requests[ride.ride_id])
    # What would be possible instead was told with the refusal.
    terms = replace(uow.roads().promise_rules(uow.rules), later_s_max=0.0)
    (answer,) = answer_all(schedule, [ride.ride_id], terms)
    if answer.best is None:
        return RideOffer(answer.rule)
    return RideOffer("", moment(answer.best.pickup_s), moment(answer.best.arrival_s))


def _as_ride(uow: UnitOfWork, request: BookRide, closes: datetime | None) -> Ride:
    return Ride(
        campus_id=uow.campus_id,
        ride_id=_OFFER_ID,
        ride_code="",
        ticket_key_id="",
        state=RideState.REQUESTED,
        from_stop=request.from_stop,
        to_stop=request.to_stop,
        party=request.party,
        wheelchairs=request.wheelchairs,
        earliest=max(uow.now, request.earliest or uow.now),
        requested_at=uow.now,
        source=request.source,
        arrive_before=closes,
    )
