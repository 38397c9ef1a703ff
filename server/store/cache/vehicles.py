"""Vehicles and where they are, in memory."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from datetime import datetime
from typing import Any

from sqlalchemy import Connection

from contract.wire.messages import Status
from server.domain.fleet.vehicles import StatusReport, Vehicle, Whereabouts
from server.store import tables
from server.store.cache.memory import RowCache, Rows
from server.store.fleet.vehicles import SqlVehicleRepository, vehicle_from_row
from server.store.writing.campus_lock import CampusLock

_VEHICLES, _WHEREABOUTS = "vehicles", "whereabouts"
# Rows that were read one by one, until the whole table is. Where several servers write, all is read again
# after the commit of another one, and most transactions ask for a few vehicles only.
_SOME = {_VEHICLES: "some vehicles", _WHEREABOUTS: "some whereabouts"}
ONE_BY_ONE_MAX = 8


class CachedVehicleRepository(SqlVehicleRepository):
    def __init__(self, connection: Connection, campus_id: str, lock: CampusLock, memory: RowCache) -> None:
        super().__init__(connection, campus_id, lock)
        self._memory = memory
        # Written when the transaction ends: every event of a vehicle says that it was heard.
        self._heard: dict[str, datetime] = {}

    def get(self, vehicle_id: str) -> Vehicle | None:
        found: Vehicle | None = self._row(_VEHICLES, vehicle_id, super().get, self._known)
        return found

    def all(self) -> tuple[Vehicle, ...]:
        known = self._known()
        return tuple(known[vehicle_id] for vehicle_id in sorted(known) if not known[vehicle_id].retired)

    def add(self, vehicle: Vehicle) -> None:
        super().add(vehicle)
        self._remember(_VEHICLES, vehicle)

    def save(self, vehicle: Vehicle) -> None:
        super().save(vehicle)
        self._remember(_VEHICLES, vehicle)

    def whereabouts(self, vehicle_id: str) -> Whereabouts | None:
        found: Whereabouts | None = self._row(_WHEREABOUTS, vehicle_id, super().whereabouts, self._where)
        return found

    def all_whereabouts(self) -> tuple[Whereabouts, ...]:
        where = self._where()
        return tuple(where[vehicle_id] for vehicle_id in sorted(where))

    def heard(self, vehicle_id: str, at: datetime) -> None:
        self._heard[vehicle_id] = at
        before = self.whereabouts(vehicle_id) or Whereabouts(vehicle_id, at)
        self._remember(_WHEREABOUTS, replace(before, heard_at=at))

    def flush(self) -> None:
        heard, self._heard = self._heard, {}
        self._put_heard(heard)

    def save_position(self, vehicle_id: str, status: Status) -> None:
        self.flush()
        super().save_position(vehicle_id, status)
        before = self.whereabouts(vehicle_id)
        if before is not None:
            self._remember(_WHEREABOUTS, replace(before, status=status))

    def save_status(self, reports: Sequence[StatusReport]) -> None:
        self.flush()
        super().save_status(reports)
        for report in reports:
            where = Whereabouts(report.vehicle_id, report.received_at, report.status)
            self._remember(_WHEREABOUTS, where)

    def _row(
        self,
        table: str,
        vehicle_id: str,
        read: Callable[[str], Vehicle | Whereabouts | None],
        read_all: Callable[[], Rows],
    ) -> Any:
        """The vehicle's row of the whole table if that is loaded; the first few are read alone otherwise."""
        if self._memory.has(table):
            return read_all().get(vehicle_id)
        some = self._memory.table(_SOME[table])
        if vehicle_id not in some:
            if len(some) >= ONE_BY_ONE_MAX:
                return read_all().get(vehicle_id)
            self._memory.put(_SOME[table], vehicle_id, read(vehicle_id))
        return some[vehicle_id]

    def _remember(self, table: str, row: Vehicle | Whereabouts) -> None:
        for name in (table, _SOME[table]):
            self._memory.put(name, row.vehicle_id, row)

    def _known(self) -> Rows:
        return self._memory.table(_VEHICLES, self._read_vehicles)

    def _read_vehicles(self) -> Rows:
        rows = self._many(self._select(tables.vehicles))
        self._memory.unload(_SOME[_VEHICLES])
        return {row.vehicle_id: vehicle_from_row(row) for row in rows}

    def _where(self) -> Rows:
        return self._memory.table(_WHEREABOUTS, self._read_whereabouts)

    def _read_whereabouts(self) -> Rows:
        """That a vehicle was heard may not be written yet."""
        read = {where.vehicle_id: where for where in super().all_whereabouts()}
        some = self._memory.table(_SOME[_WHEREABOUTS])
        self._memory.unload(_SOME[_WHEREABOUTS])
        return read | {vehicle_id: where for vehicle_id, where in some.items() if where is not None}
