"""Whom a ride delays: the plans of its shuttle with it and without it, compared."""

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime

from server.domain.errors import RideNotAssigned
from server.domain.rides.rides import WAITING, Ride, RideState
from server.usecases.planning import plans
from server.usecases.ports.unit_of_work import Transactions, UnitOfWork
from server.usecases.record.dry_run import roll_back
from server.usecases.rides import rides

# A difference that nobody notices, and that rounding of expected times makes.
NOTICED_S = 1.0


@dataclass(frozen=True, slots=True)
class RideDelay:
    """Another ride of the same shuttle: how much later it is because of this one."""

    ride_id: str
    ride_code: str
    pickup_s: float
    arrival_s: float


async def delays_by(transactions: Transactions, ride_id: str) -> tuple[RideDelay, ...]:
    """The other rides of the shuttle that would be earlier without this one, the most delayed first.

    The shuttle is planned without the ride in a transaction that is rolled back. Raises RideUnknown,
    RideNotAssigned (it waits for no shuttle: nothing can be left out).
    """
    return await roll_back(transactions, lambda uow: _delays(uow, ride_id))


def _delays(uow: UnitOfWork, ride_id: str) -> tuple[RideDelay, ...]:
    ride = rides.ride_of(uow, ride_id)
    vehicle_id = ride.vehicle_id
    if ride.state not in WAITING or vehicle_id is None:
        raise RideNotAssigned(f"ride {ride.ride_code} is {ride.state}: it waits for no shuttle")
    plans.refresh_expected(uow)
    with_it = _others(uow, vehicle_id, ride_id)
    rides.cancel(uow, ride_id, "operator")
    plans.refresh_expected(uow)
    without_it = _others(uow, vehicle_id, ride_id)
    found = [
        _delay(other, without_it[other.ride_id]) for other in with_it.values() if other.ride_id in without_it
    ]
    noticed = [one for one in found if max(one.pickup_s, one.arrival_s) >= NOTICED_S]
    return tuple(sorted(noticed, key=lambda one: (-one.arrival_s, one.ride_id)))


def _others(uow: UnitOfWork, vehicle_id: str, ride_id: str) -> Mapping[str, Ride]:
    states = sorted(WAITING | {RideState.ABOARD})
    return {r.ride_id: r for r in uow.rides.of_vehicle(vehicle_id, states) if r.ride_id != ride_id}


def _delay(with_it: Ride, without_it: Ride) -> RideDelay:
    return RideDelay(
        with_it.ride_id,
        with_it.ride_code,
        _later_s(with_it.pickup_eta, without_it.pickup_eta) if with_it.boarded_at is None else 0.0,
        _later_s(with_it.arrival_eta, without_it.arrival_eta),
    )


def _later_s(with_it: datetime | None, without_it: datetime | None) -> float:
    if with_it is None or without_it is None:
        return 0.0
    return (with_it - without_it).total_seconds()
