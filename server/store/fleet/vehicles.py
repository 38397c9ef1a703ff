"""Vehicles, where they are, and the commands to them, as rows."""

from collections.abc import Mapping, Sequence, Set
from dataclasses import fields
from datetime import datetime
from functools import lru_cache
from typing import Any

import msgspec
import structlog
from sqlalchemy import Connection, Select, bindparam, func, select
from sqlalchemy.sql import ColumnElement

from contract.geometry import Pose2
from contract.wire.messages import CommandKind, Status
from server.domain.fleet.shifts import Shifts
from server.domain.fleet.vehicles import (
    StatusReport,
    Vehicle,
    VehicleCommand,
    Whereabouts,
    within_bounds,
)
from server.store import tables
from server.store.columns import from_json, to_json
from server.store.fleet.history import SqlHistoryRepository
from server.store.repository import AnyRow, Repository
from server.store.writing.campus_lock import CampusLock

log = structlog.get_logger("store.fleet")

_vehicle = tables.vehicles.c
_where = tables.whereabouts.c
_command = tables.vehicle_commands.c
_VEHICLE_FIELDS = tuple(field.name for field in fields(Vehicle))


def _last_commands() -> Select[Any]:
    newest_first = func.row_number().over(
        partition_by=_command.vehicle_id, order_by=(_command.made_at.desc(), _command.command_id.desc())
    )
    is_one_of = _command.vehicle_id.in_(bindparam("vehicle_ids", expanding=True))
    ranked = (
        select(_command.command_id, newest_first.label("rank"))
        .where(_command.campus_id == bindparam("campus_id"), is_one_of)
        .subquery()
    )
    newest = select(ranked.c.command_id).where(ranked.c.rank == 1)
    return select(tables.vehicle_commands).where(
        _command.campus_id == bindparam("campus_id"), _command.command_id.in_(newest)
    )


# Asked for every message to a vehicle, and for every reading of a screen: made once.
_LAST_COMMANDS = _last_commands()
_PENDING_COMMANDS = (
    select(tables.vehicle_commands)
    .where(
        _command.campus_id == bindparam("campus_id"),
        _command.vehicle_id == bindparam("vehicle_id"),
        _command.state == "pending",
    )
    .order_by(_command.made_at, _command.command_id)
)


class SqlVehicleRepository(Repository):
    def __init__(self, connection: Connection, campus_id: str, lock: CampusLock | None) -> None:
        super().__init__(connection, campus_id, lock)
        self._history = SqlHistoryRepository(connection, campus_id, lock)

    def get(self, vehicle_id: str) -> Vehicle | None:
        row = self._find(tables.vehicles, vehicle_id=vehicle_id)
        return None if row is None else vehicle_from_row(row)

    def all(self) -> tuple[Vehicle, ...]:
        return self._on_duty()

    def these(self, vehicle_ids: Set[str]) -> tuple[Vehicle, ...]:
        """Those of `all` that have one of the ids."""
        return self._on_duty(_vehicle.vehicle_id.in_(vehicle_ids))

    def _on_duty(self, *conditions: ColumnElement[bool]) -> tuple[Vehicle, ...]:
        chosen = self._select(tables.vehicles, _vehicle.retired.is_(False), *conditions)
        return tuple(vehicle_from_row(row) for row in self._many(chosen.order_by(_vehicle.vehicle_id)))

    def add(self, vehicle: Vehicle) -> None:
        self._insert(tables.vehicles, _vehicle_to_row(vehicle))

    def save(self, vehicle: Vehicle) -> None:
        self._change(tables.vehicles, _vehicle_to_row(vehicle), vehicle_id=vehicle.vehicle_id)

    def whereabouts(self, vehicle_id: str) -> Whereabouts | None:
        row = self._find(tables.whereabouts, vehicle_id=vehicle_id)
        return None if row is None else whereabouts_from_row(row)

    def all_whereabouts(self) -> tuple[Whereabouts, ...]:
        rows = self._many(self._select(tables.whereabouts).order_by(_where.vehicle_id))
        return tuple(whereabouts_from_row(row) for row in rows)

    def whereabouts_of(self, vehicle_ids: Set[str]) -> dict[str, Whereabouts]:
        """Of those that were ever heard, by vehicle id."""
        rows = self._many(self._select(tables.whereabouts, _where.vehicle_id.in_(vehicle_ids)))
        return {row.vehicle_id: whereabouts_from_row(row) for row in rows}

    def heard(self, vehicle_id: str, at: datetime) -> None:
        self._put_heard({vehicle_id: at})

    def flush(self) -> None:
        """Write what waits for the end of the transaction."""

    def _put_heard(self, heard: Mapping[str, datetime]) -> None:
        rows = [{"vehicle_id": vehicle_id, "heard_at": at} for vehicle_id, at in heard.items()]
        self._put_all(tables.whereabouts, rows)

    def save_position(self, vehicle_id: str, status: Status) -> None:
        self._change(tables.whereabouts, {"status": to_json(status)}, vehicle_id=vehicle_id)

    def save_status(self, reports: Sequence[StatusReport]) -> None:
        newest = {report.vehicle_id: report for report in reports}
        self._put_all(
            tables.whereabouts,
            [
                {
                    "vehicle_id": vehicle_id,
                    "heard_at": report.received_at,
                    "status": to_json(report.status),
                }
                for vehicle_id, report in sorted(newest.items())
            ],
        )
        self._history.add(reports)

    def add_command(self, command: VehicleCommand) -> None:
        self._insert(tables.vehicle_commands, _command_to_row(command))

    def save_command(self, command: VehicleCommand) -> None:
        self._change(tables.vehicle_commands, _command_to_row(command), command_id=command.command_id)

    def command(self, command_id: str) -> VehicleCommand | None:
        row = self._find(tables.vehicle_commands, command_id=command_id)
        return None if row is None else _command_from_row(row)

    def last_commands(self, vehicle_ids: Sequence[str]) -> dict[str, VehicleCommand]:
        """The newest command to each of those vehicles that ever had one, by vehicle id."""
        named = {"campus_id": self._campus_id, "vehicle_ids": list(vehicle_ids)}
        rows = self._connection.execute(_LAST_COMMANDS, named).all()
        return {row.vehicle_id: _command_from_row(row) for row in rows}

    def newest_command(self, vehicle_id: str, kind: CommandKind) -> VehicleCommand | None:
        chosen = self._select(
            tables.vehicle_commands, _command.vehicle_id == vehicle_id, _command.kind == kind
        )
        ordered = chosen.order_by(_command.made_at.desc(), _command.command_id.desc())
        row = self._connection.execute(ordered.limit(1)).first()
        return None if row is None else _command_from_row(row)

    def marks(self, vehicle_id: str, since: datetime, until: datetime) -> tuple[VehicleCommand, ...]:
        chosen = self._select(
            tables.vehicle_commands,
            _command.vehicle_id == vehicle_id,
            _command.kind == "mark",
            _command.made_at >= since,
            _command.made_at < until,
        )
        return tuple(_command_from_row(row) for row in self._many(chosen.order_by(_command.made_at)))

    def pending_commands(self, vehicle_id: str) -> tuple[VehicleCommand, ...]:
        named = {"campus_id": self._campus_id, "vehicle_id": vehicle_id}
        rows = self._connection.execute(_PENDING_COMMANDS, named).all()
        return tuple(_command_from_row(row) for row in rows)


def vehicle_from_row(row: AnyRow) -> Vehicle:
    values = {name: getattr(row, name) for name in _VEHICLE_FIELDS}
    stored = Vehicle(**values | {"shifts": None if row.shifts is None else _shifts(row.shifts)})
    vehicle = within_bounds(stored)
    if vehicle is not stored:
        _log_invalid_row(row.vehicle_id, f"seats {row.seats}, wheelchair_places {row.wheelchair_places}")
    return vehicle


@lru_cache(maxsize=256)
def _shifts(text: str) -> Shifts:
    return from_json(text, Shifts)


def whereabouts_from_row(row: AnyRow) -> Whereabouts:
    if row.status is None:
        return Whereabouts(row.vehicle_id, row.heard_at)
    try:
        return Whereabouts(row.vehicle_id, row.heard_at, from_json(row.status, Status))
    except msgspec.DecodeError as error:
        _log_invalid_row(row.vehicle_id, str(error))
        return Whereabouts(row.vehicle_id, row.heard_at, unreadable=str(error))


@lru_cache(maxsize=256)
def _log_invalid_row(vehicle_id: str, what: str) -> None:
    """Say it once: rows are read many times a second."""
    log.error("vehicle.row_invalid", vehicle_id=vehicle_id, what=what)


def _vehicle_to_row(vehicle: Vehicle) -> dict[str, object]:
    values = {name: getattr(vehicle, name) for name in _VEHICLE_FIELDS if name != "campus_id"}
    return values | {"shifts": None if vehicle.shifts is None else to_json(vehicle.shifts)}


def _command_from_row(row: AnyRow) -> VehicleCommand:
    return VehicleCommand(
        campus_id=row.campus_id,
        command_id=row.command_id,
        vehicle_id=row.vehicle_id,
        kind=row.kind,
        text=row.text,
        by=row.made_by,
        made_at=row.made_at,
        state=row.state,
        detail=row.detail,
        announcement_id=row.announcement_id,
        pose=None if row.pose_x_m is None else Pose2(row.pose_x_m, row.pose_y_m, row.pose_yaw_rad),
    )


def _command_to_row(command: VehicleCommand) -> dict[str, object]:
    pose = command.pose
    return {
        "command_id": command.command_id,
        "vehicle_id": command.vehicle_id,
        "kind": command.kind,
        "text": command.text,
        "made_by": command.by,
        "made_at": command.made_at,
        "state": command.state,
        "detail": command.detail,
        "announcement_id": command.announcement_id,
        "pose_x_m": None if pose is None else pose.x_m,
        "pose_y_m": None if pose is None else pose.y_m,
        "pose_yaw_rad": None if pose is None else pose.yaw_rad,
    }
