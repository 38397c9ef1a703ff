"""Sections held by vehicles, in memory."""

from sqlalchemy import Connection

from server.domain.orders.sections import HeldSection, Occupancy
from server.store.cache.memory import RowCache, Rows
from server.store.orders.sections import SqlSectionRepository
from server.store.writing.campus_lock import CampusLock

_OCCUPANCIES = "occupancies"


class CachedSectionRepository(SqlSectionRepository):
    def __init__(self, connection: Connection, campus_id: str, lock: CampusLock, memory: RowCache) -> None:
        super().__init__(connection, campus_id, lock)
        self._memory = memory

    def all(self) -> tuple[Occupancy, ...]:
        known = self._known()
        return tuple(known[vehicle_id] for vehicle_id in sorted(known))

    def held_by(self, vehicle_id: str) -> tuple[HeldSection, ...]:
        occupancy = self._known().get(vehicle_id)
        return () if occupancy is None else occupancy.held

    def save(self, occupancy: Occupancy) -> None:
        self._write(occupancy, self._known().get(occupancy.vehicle_id))
        self._memory.put(_OCCUPANCIES, occupancy.vehicle_id, occupancy)

    def remove(self, vehicle_id: str) -> None:
        super().remove(vehicle_id)
        self._memory.remove(_OCCUPANCIES, vehicle_id)

    def _known(self) -> Rows:
        return self._memory.table(
            _OCCUPANCIES,
            lambda: {occupancy.vehicle_id: occupancy for occupancy in SqlSectionRepository.all(self)},
        )
