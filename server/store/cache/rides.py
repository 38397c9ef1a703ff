"""Rides that have not ended, in memory."""

from collections.abc import Sequence

from sqlalchemy import Connection

from server.domain.rides.rides import ENDED, Ride, RideState
from server.store import tables
from server.store.cache.memory import RowCache, Rows
from server.store.rides.rides import SqlRideRepository
from server.store.writing.campus_lock import CampusLock

_RIDES, _CODES, _KEYS = "rides", "ride codes", "ride keys"
_ride = tables.rides.c


class CachedRideRepository(SqlRideRepository):
    def __init__(self, connection: Connection, campus_id: str, lock: CampusLock, memory: RowCache) -> None:
        super().__init__(connection, campus_id, lock)
        self._memory = memory

    def get(self, ride_id: str) -> Ride | None:
        return self._active().get(ride_id) or super().get(ride_id)

    def by_idempotency_key(self, key: str) -> Ride | None:
        known = self._memory.table(_KEYS, self._keys).get(key)
        return self._active()[known] if known is not None else super().by_idempotency_key(key)

    def in_states(self, states: Sequence[RideState]) -> tuple[Ride, ...]:
        if not ENDED.isdisjoint(states):
            return super().in_states(states)
        return _in_order([ride for ride in self._active().values() if ride.state in states])

    def of_vehicle(self, vehicle_id: str, states: Sequence[RideState]) -> tuple[Ride, ...]:
        if not ENDED.isdisjoint(states):
            return super().of_vehicle(vehicle_id, states)
        return _in_order(
            [r for r in self._active().values() if r.vehicle_id == vehicle_id and r.state in states]
        )

    def code_in_use(self, ride_code: str) -> bool:
        return ride_code in self._memory.table(_CODES, self._codes)

    def add(self, ride: Ride) -> None:
        super().add(ride)
        self._keep(ride)

    def save(self, ride: Ride) -> None:
        super().save(ride)
        self._keep(ride)

    def _active(self) -> Rows:
        return self._memory.table(_RIDES, self._read_active)

    def _read_active(self) -> Rows:
        ended = [str(state) for state in ENDED]
        return {ride.ride_id: ride for ride in self._listed(_ride.state.not_in(ended))}

    def _codes(self) -> Rows:
        return {ride.ride_code: ride.ride_id for ride in self._active().values()}

    def _keys(self) -> Rows:
        return {r.idempotency_key: r.ride_id for r in self._active().values() if r.idempotency_key}

    def _keep(self, ride: Ride) -> None:
        indexes = [(_CODES, ride.ride_code)]
        if ride.idempotency_key is not None:
            indexes.append((_KEYS, ride.idempotency_key))
        if ride.has_ended:
            self._memory.remove(_RIDES, ride.ride_id)
            for name, key in indexes:
                # The code may have been given to another ride since.
                self._memory.remove(name, key, ride.ride_id)
        else:
            self._memory.put(_RIDES, ride.ride_id, ride)
            for name, key in indexes:
                self._memory.put(name, key, ride.ride_id)


def _in_order(rides: list[Ride]) -> tuple[Ride, ...]:
    return tuple(sorted(rides, key=lambda ride: (ride.requested_at, ride.ride_id)))
