"""The effects of an operator's intervention or road closure on waiting rides, rides aboard and departures."""

from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Literal

from server.domain.rides.rides import Ride, RideState

InterventionKind = Literal["hold", "recall", "reassign"]
# Times that move by less count as unchanged.
_NEWS_S = 1.0


@dataclass(frozen=True, slots=True)
class Intervention:
    """An operator's intervention with a vehicle.

    for_s      how long a hold lasts, None until resumed
    ride_id, to_vehicle_id  one ride to be given to that vehicle; "" for all waiting ones, to any others
    """

    kind: InterventionKind
    for_s: float | None = None
    ride_id: str = ""
    to_vehicle_id: str = ""


@dataclass(frozen=True, slots=True)
class RideEffect:
    """A ride that the intervention changes. pickup_before and pickup_after are None for a party aboard.

    vehicle_after   None: the ride is left without a vehicle
    breaks          its promise cannot be kept any more
    waits           its vehicle stands until an operator resumes it, so that no times are known
    ends            the ride is over: no vehicle can serve it
    to_stop_after   where the party gets off now
    postponed_to    the new promised pickup, at a time when the road is open again
    """

    ride_id: str
    ride_code: str
    state: RideState
    from_stop: str
    to_stop: str
    party: int
    vehicle_before: str | None
    vehicle_after: str | None
    pickup_before: datetime | None
    pickup_after: datetime | None
    arrival_before: datetime | None
    arrival_after: datetime | None
    breaks: bool
    waits: bool
    ends: bool = False
    to_stop_after: str = ""
    postponed_to: datetime | None = None

    @property
    def pickup_later_s(self) -> float | None:
        return _later_s(self.pickup_before, self.pickup_after)

    @property
    def arrival_later_s(self) -> float | None:
        return _later_s(self.arrival_before, self.arrival_after)


@dataclass(frozen=True, slots=True)
class DepartureEffect:
    """A timetable departure that changes its vehicle or its lateness at the next call, in seconds."""

    departure_id: str
    vehicle_before: str | None
    vehicle_after: str | None
    late_before_s: float
    late_after_s: float
    waits: bool

    @property
    def is_news(self) -> bool:
        moved = abs(self.late_after_s - self.late_before_s) >= _NEWS_S
        return self.vehicle_before != self.vehicle_after or moved or self.waits


@dataclass(frozen=True, slots=True)
class Effects:
    """rides: oldest request first; departures: by first call. Unchanged ones are left out."""

    rides: tuple[RideEffect, ...] = ()
    departures: tuple[DepartureEffect, ...] = ()


def ride_effect(before: Ride, after: Ride, room_s: float, *, waits: bool) -> RideEffect | None:
    """The effect on a ride that had not ended before; None if it is unchanged.

    room_s  a promise breaks when the plan misses it by more than this
    waits   its vehicle stands until it is resumed
    """
    is_waiting = after.state in (RideState.REQUESTED, RideState.ASSIGNED)
    effect = RideEffect(
        ride_id=before.ride_id,
        ride_code=before.ride_code,
        state=after.state,
        from_stop=before.from_stop,
        to_stop=before.to_stop,
        party=before.party,
        vehicle_before=before.vehicle_id,
        vehicle_after=None if after.has_ended else after.vehicle_id,
        pickup_before=before.pickup_eta if is_waiting else None,
        pickup_after=after.pickup_eta if is_waiting and not waits else None,
        arrival_before=before.arrival_eta,
        arrival_after=None if waits else after.arrival_eta,
        breaks=_breaks(before, after, timedelta(seconds=room_s)),
        waits=waits,
        ends=after.has_ended,
        to_stop_after=after.to_stop,
        postponed_to=_postponed_to(before, after),
    )
    moved_s = max(abs(effect.pickup_later_s or 0.0), abs(effect.arrival_later_s or 0.0))
    changed = (
        effect.vehicle_before != effect.vehicle_after
        or moved_s >= _NEWS_S
        or effect.breaks
        or effect.waits
        or effect.ends
        or effect.to_stop_after != effect.to_stop
        or effect.postponed_to is not None
    )
    return effect if changed else None


def _postponed_to(before: Ride, after: Ride) -> datetime | None:
    if after.has_ended or after.promise is None or before.promise is None or after.vehicle_id is not None:
        return None
    is_later = after.promise.pickup_from > before.promise.pickup_from
    return after.promise.pickup_from if is_later else None


def _breaks(before: Ride, after: Ride, room: timedelta) -> bool:
    """The plan kept the promise before, and does not now."""
    return _misses(after, before, room) and not _misses(before, before, room)


def _misses(ride: Ride, promised: Ride, room: timedelta) -> bool:
    promise = promised.promise
    if promise is None:
        return False
    is_waiting = ride.state in (RideState.REQUESTED, RideState.ASSIGNED)
    late_pickup = is_waiting and ride.pickup_eta is not None and ride.pickup_eta > promise.pickup_to + room
    return late_pickup or (ride.arrival_eta is not None and ride.arrival_eta > promise.arrive_by + room)


def _later_s(before: datetime | None, after: datetime | None) -> float | None:
    return None if before is None or after is None else (after - before).total_seconds()
