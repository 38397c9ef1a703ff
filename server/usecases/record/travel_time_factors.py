"""Measures driven times against planned ones, and learns the travel time factors."""

from datetime import timedelta
from math import isfinite

from server.domain.planning.plans import PlannedVisit
from server.domain.planning.travel_time_factors import (
    AS_PLANNED,
    DrivenLeg,
    TravelTimeFactors,
    learned_from,
)
from server.usecases.ports.unit_of_work import UnitOfWork

# Shorter legs are mostly starting and stopping.
_LEAST_S = 30.0
_LEARNT_FROM_DAYS = 28.0


def left(uow: UnitOfWork, vehicle_id: str, visit: PlannedVisit) -> None:
    """The vehicle has left a stop: a leg begins."""
    uow.travel_time_factors.end_leg(vehicle_id)
    if visit.stop_id:
        uow.travel_time_factors.begin_leg(vehicle_id, visit.stop_id, uow.now)


def arrived(uow: UnitOfWork, vehicle_id: str, visit: PlannedVisit) -> None:
    """The vehicle has come to its next place; a drive from stop to stop is recorded."""
    begun = uow.travel_time_factors.end_leg(vehicle_id)
    roads = uow.roads()
    if begun is None or visit.stop_id not in roads.stop_numbers or roads.closed:
        return
    from_stop, left_at = begun
    if from_stop not in roads.stop_numbers:
        return
    times = roads.stop_times(frozenset())
    planned_s = float(times[roads.stop_numbers[from_stop], roads.stop_numbers[visit.stop_id]])
    if planned_s < _LEAST_S or not isfinite(planned_s):
        return
    driven_s = (uow.now - left_at).total_seconds()
    hour = int(uow.hour_of(left_at + (uow.now - left_at) / 2))
    uow.travel_time_factors.add(
        DrivenLeg(uow.campus_id, vehicle_id, left_at, from_stop, visit.stop_id, hour, planned_s, driven_s)
    )


def interrupted(uow: UnitOfWork, vehicle_id: str) -> None:
    """The vehicle was held or taken over: its present drive is not measured."""
    uow.travel_time_factors.end_leg(vehicle_id)


def learn(uow: UnitOfWork) -> TravelTimeFactors:
    """Learn the factors from the legs of the last weeks, and forget older legs."""
    oldest = uow.now - timedelta(days=_LEARNT_FROM_DAYS)
    uow.travel_time_factors.forget_before(oldest)
    factors = learned_from(uow.travel_time_factors.legs(), uow.now)
    if factors.factors != present(uow).factors or factors.legs != present(uow).legs:
        uow.travel_time_factors.save(factors)
        uow.roads_changed()
    return factors


def present(uow: UnitOfWork) -> TravelTimeFactors:
    """Those that are planned with now."""
    return uow.travel_time_factors.present() or AS_PLANNED
