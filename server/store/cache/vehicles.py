"""Vehicles and where they are, in memory."""

from collections.abc import Sequence
from dataclasses import replace
from datetime import datetime

from sqlalchemy import Connection

from contract.wire.messages import Status
from server.domain.fleet.vehicles import StatusReport, Vehicle, Whereabouts
from server.store import tables
from server.store.cache.memory import RowCache, Rows
from server.store.fleet.vehicles import SqlVehicleRepository, vehicle_from_row
from server.store.writing.campus_lock import CampusLock

_VEHICLES, _WHEREABOUTS = "vehicles", "whereabouts"
# Rows that were read one by one. Where several servers write, all is read again after the commit of another
# one, and most transactions ask for a few vehicles only.
_SOME_VEHICLES, _SOME_WHEREABOUTS = "some vehicles", "some whereabouts"
ONE_BY_ONE_MAX = 8


class CachedVehicleRepository(SqlVehicleRepository):
    def __init__(self, connection: Connection, campus_id: str, lock: CampusLock, memory: RowCache) -> None:
        super().__init__(connection, campus_id, lock)
        self._memory = memory
        # Written when the transaction ends: every event of a vehicle says that it was heard.
        self._heard: dict[str, datetime] = {}

    def get(self, vehicle_id: str) -> Vehicle | None:
        if not self._memory.has(_VEHICLES):
            some = self._memory.table(_SOME_VEHICLES)
            if vehicle_id not in some and len(some) < ONE_BY_ONE_MAX:
                self._memory.put(_SOME_VEHICLES, vehicle_id, super().get(vehicle_id))
            if vehicle_id in some:
                found: Vehicle | None = some[vehicle_id]
                return found
        return self._known().get(vehicle_id)

    def all(self) -> tuple[Vehicle, ...]:
        known = self._known()
        return tuple(known[vehicle_id] for vehicle_id in sorted(known) if not known[vehicle_id].retired)

    def add(self, vehicle: Vehicle) -> None:
        super().add(vehicle)
        self._remember(vehicle)

    def save(self, vehicle: Vehicle) -> None:
        super().save(vehicle)
        self._remember(vehicle)

    def whereabouts(self, vehicle_id: str) -> Whereabouts | None:
        if not self._memory.has(_WHEREABOUTS):
            some = self._memory.table(_SOME_WHEREABOUTS)
            if vehicle_id not in some and len(some) < ONE_BY_ONE_MAX:
                self._memory.put(_SOME_WHEREABOUTS, vehicle_id, super().whereabouts(vehicle_id))
            if vehicle_id in some:
                found: Whereabouts | None = some[vehicle_id]
                return found
        return self._where().get(vehicle_id)

    def all_whereabouts(self) -> tuple[Whereabouts, ...]:
        where = self._where()
        return tuple(where[vehicle_id] for vehicle_id in sorted(where))

    def heard(self, vehicle_id: str, at: datetime) -> None:
        self._heard[vehicle_id] = at
        before = self.whereabouts(vehicle_id) or Whereabouts(vehicle_id, at)
        self._remember_where(replace(before, heard_at=at))

    def flush(self) -> None:
        heard, self._heard = self._heard, {}
        self._put_heard(heard)

    def save_position(self, vehicle_id: str, status: Status) -> None:
        self.flush()
        super().save_position(vehicle_id, status)
        before = self.whereabouts(vehicle_id)
        if before is not None:
            self._remember_where(replace(before, status=status))

    def save_status(self, reports: Sequence[StatusReport]) -> None:
        self.flush()
        super().save_status(reports)
        for report in reports:
            self._remember_where(Whereabouts(report.vehicle_id, report.received_at, report.status))

    def _remember(self, vehicle: Vehicle) -> None:
        for table in (_VEHICLES, _SOME_VEHICLES):
            self._memory.put(table, vehicle.vehicle_id, vehicle)

    def _remember_where(self, where: Whereabouts) -> None:
        for table in (_WHEREABOUTS, _SOME_WHEREABOUTS):
            self._memory.put(table, where.vehicle_id, where)

    def _known(self) -> Rows:
        return self._memory.table(_VEHICLES, self._read_vehicles)

    def _read_vehicles(self) -> Rows:
        rows = self._many(self._select(tables.vehicles))
        return {row.vehicle_id: vehicle_from_row(row) for row in rows}

    def _where(self) -> Rows:
        return self._memory.table(_WHEREABOUTS, self._read_whereabouts)

    def _read_whereabouts(self) -> Rows:
        """That a vehicle was heard may not be written yet."""
        read = {where.vehicle_id: where for where in super().all_whereabouts()}
        some = self._memory.table(_SOME_WHEREABOUTS)
        return read | {vehicle_id: where for vehicle_id, where in some.items() if where is not None}
