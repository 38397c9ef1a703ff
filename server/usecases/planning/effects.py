"""What a change of the fleet or its roads does to riders and departures: a comparison of before and after."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import timedelta

from server.domain.rides.effects import DepartureEffect, Effects, ride_effect
from server.domain.rides.rides import Ride, RideState
from server.domain.service.timetable import Departure
from server.usecases.planning import plans
from server.usecases.ports.unit_of_work import UnitOfWork

_UNDER_WAY = (RideState.REQUESTED, RideState.ASSIGNED, RideState.BOARDING, RideState.ABOARD)


@dataclass(frozen=True, slots=True)
class ObservedFleet:
    """Rides under way and departures before a change; departures with their lateness in seconds, by id."""

    rides: Sequence[Ride]
    departures: dict[str, tuple[Departure, float]]


def observe_fleet(uow: UnitOfWork) -> ObservedFleet:
    """The state to compare with. Expected times are made current, on both sides of the comparison."""
    plans.refresh_expected(uow)
    return ObservedFleet(uow.rides.in_states(_UNDER_WAY), _departures(uow))


def effects_since(uow: UnitOfWork, fleet: ObservedFleet, standing: str = "") -> Effects:
    """What has changed for riders and departures since then.

    standing  the vehicle that the change holds until it is resumed, "" for none
    """
    plans.refresh_expected(uow)
    ride_effects = []
    for before in fleet.rides:
        after = uow.rides.get(before.ride_id) or before
        waits = not after.has_ended and bool(standing) and after.vehicle_id == standing
        effect = ride_effect(before, after, uow.rules.promise_lapse_s, waits=waits)
        if effect is not None:
            ride_effects.append(effect)
    now = _departures(uow)
    departure_effects = []
    for departure_id, (departure, late_before_s) in fleet.departures.items():
        # A departure that was given up has no vehicle, and is not late any more.
        after_one, late_after_s = now.get(departure_id, (replace(departure, vehicle_id=None), 0.0))
        departure_effects.append(
            DepartureEffect(
                departure_id,
                vehicle_before=departure.vehicle_id,
                vehicle_after=after_one.vehicle_id,
                late_before_s=late_before_s,
                late_after_s=late_after_s,
                waits=bool(standing) and after_one.vehicle_id == standing,
            )
        )
    return Effects(tuple(ride_effects), tuple(effect for effect in departure_effects if effect.is_news))


def _departures(uow: UnitOfWork) -> dict[str, tuple[Departure, float]]:
    """Those not done with how late each is at its next call, as planned; by id, in order of first call."""
    late_s: dict[str, float] = {}
    for plan in uow.plans.all():
        for visit in plan.visits:
            if visit.departure_id and visit.eta is not None and visit.not_before is not None:
                late = (visit.eta + timedelta(seconds=visit.dwell_s) - visit.not_before).total_seconds()
                late_s.setdefault(visit.departure_id, max(0.0, late))
    return {d.departure_id: (d, late_s.get(d.departure_id, 0.0)) for d in uow.departures.unfinished()}
