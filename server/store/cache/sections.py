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
        # Written when the transaction ends: one grant often follows another's release. As stored, by vehicle.
        self._stored: dict[str, Occupancy | None] = {}

    def all(self) -> tuple[Occupancy, ...]:
        known = self._known()
        return tuple(known[vehicle_id] for vehicle_id in sorted(known))

    def held_by(self, vehicle_id: str) -> tuple[HeldSection, ...]:
        occupancy = self._known().get(vehicle_id)
        return () if occupancy is None else occupancy.held

    def save(self, occupancy: Occupancy) -> None:
        vehicle_id = occupancy.vehicle_id
        self._stored.setdefault(vehicle_id, self._known().get(vehicle_id))
        self._memory.put(_OCCUPANCIES, vehicle_id, occupancy)

    def remove(self, vehicle_id: str) -> None:
        self._stored.pop(vehicle_id, None)
        super().remove(vehicle_id)
        self._memory.remove(_OCCUPANCIES, vehicle_id)

    def flush(self) -> None:
        stored, self._stored = self._stored, {}
        known = self._known() if stored else {}
        self._write([(before, known[vehicle_id]) for vehicle_id, before in stored.items()])

    def _known(self) -> Rows:
        return self._memory.table(
            _OCCUPANCIES,
            lambda: {occupancy.vehicle_id: occupancy for occupancy in SqlSectionRepository.all(self)},
        )
