"""Reads for pages, joined and sorted in SQL."""

from collections.abc import Sequence, Set
from datetime import datetime
from typing import TypeVar

from sqlalchemy import and_, case, or_, select
from sqlalchemy.sql import ColumnElement

from server.domain.fleet.vehicles import Vehicle, VehicleCommand, Whereabouts
from server.domain.orders.orders import IssuedOrder, lanes_of
from server.domain.orders.sections import Occupancy
from server.domain.planning.plans import Plan
from server.domain.record.events import RecordedEvent, ServerEvent
from server.domain.record.incidents import Incident
from server.domain.record.runs import Run
from server.domain.rides.rides import Ride, RideState
from server.domain.service.timetable import Departure
from server.store import tables
from server.store.fleet.history import SqlHistoryRepository
from server.store.fleet.vehicles import SqlVehicleRepository
from server.store.keyset import rows_after
from server.store.orders.orders import SqlOrderRepository
from server.store.orders.sections import SqlSectionRepository
from server.store.planning.departures import departure_from_row
from server.store.planning.plans import SqlPlanRepository
from server.store.record.events import recorded_from_row, server_event_from_row
from server.store.record.incidents import incident_from_row
from server.store.record.runs import SqlRunRepository
from server.store.repository import Repository
from server.store.rides.rides import ride_from_row
from server.usecases.ports.views import (
    HistoryPoint,
    IncidentPosition,
    MomentAndId,
    RunPosition,
    VehicleView,
)

R = TypeVar("R", bound=Repository)

_ride = tables.rides.c
_incident = tables.incidents.c
_run = tables.runs.c
_event = tables.vehicle_events.c


class SqlViews(Repository):
    def vehicles(self, vehicle_ids: Set[str] | None = None) -> tuple[VehicleView, ...]:
        fleet = self._repository(SqlVehicleRepository)
        return self._shown(fleet.all() if vehicle_ids is None else fleet.these(vehicle_ids))

    def _shown(self, shown: Sequence[Vehicle]) -> tuple[VehicleView, ...]:
        vehicles = self._repository(SqlVehicleRepository)
        names = [vehicle.vehicle_id for vehicle in shown]
        occupancies = self._repository(SqlSectionRepository).of(set(names))
        plans = self._repository(SqlPlanRepository).of(set(names))
        where = vehicles.whereabouts_of(set(names))
        orders = self._repository(SqlOrderRepository).all_current(names)
        commands = vehicles.last_commands(names)
        return tuple(
            _joined(
                vehicle,
                plans.get(vehicle.vehicle_id) or Plan(self._campus_id, vehicle.vehicle_id, 0),
                orders.get(vehicle.vehicle_id),
                where.get(vehicle.vehicle_id),
                occupancies.get(vehicle.vehicle_id),
                commands.get(vehicle.vehicle_id),
            )
            for vehicle in shown
        )

    def vehicle(self, vehicle_id: str) -> VehicleView | None:
        vehicle = self._repository(SqlVehicleRepository).get(vehicle_id)
        if vehicle is None:
            return None
        return self._shown([vehicle])[0]

    def rides(
        self,
        states: Sequence[RideState] | None = None,
        vehicle_id: str | None = None,
        limit: int = 200,
        before: datetime | None = None,
        ride_ids: Set[str] | None = None,
        after: MomentAndId | None = None,
        since: datetime | None = None,
        stop_id: str | None = None,
        ride_code: str | None = None,
    ) -> tuple[Ride, ...]:
        statement = self._select(tables.rides)
        if since is not None:
            statement = statement.where(_ride.requested_at >= since)
        if stop_id is not None:
            statement = statement.where(or_(_ride.from_stop == stop_id, _ride.to_stop == stop_id))
        if ride_code is not None:
            statement = statement.where(_ride.ride_code == ride_code)
        if ride_ids is not None:
            statement = statement.where(_ride.ride_id.in_(sorted(ride_ids)))
        if states is not None:
            statement = statement.where(_ride.state.in_([str(state) for state in states]))
        if vehicle_id is not None:
            statement = statement.where(_ride.vehicle_id == vehicle_id)
        if before is not None:
            statement = statement.where(_ride.requested_at < before)
        if after is not None:
            order = ((_ride.requested_at, True), (_ride.ride_id, True))
            statement = statement.where(rows_after(order, after))
        ordered = statement.order_by(_ride.requested_at.desc(), _ride.ride_id.desc()).limit(limit)
        return tuple(ride_from_row(row) for row in self._many(ordered))

    def pickups(self, since: datetime, until: datetime) -> tuple[tuple[str, datetime], ...]:
        statement = select(_ride.from_stop, _ride.earliest).where(
            _ride.campus_id == self._campus_id, _ride.earliest >= since, _ride.earliest < until
        )
        rows = self._many(statement.order_by(_ride.earliest, _ride.ride_id))
        return tuple((row.from_stop, row.earliest) for row in rows)

    def incidents(
        self, include_closed: bool = False, limit: int = 200, after: IncidentPosition | None = None
    ) -> tuple[Incident, ...]:
        statement = self._select(tables.incidents)
        if not include_closed:
            statement = statement.where(_incident.closed_at.is_(None))
        if after is not None:
            statement = statement.where(_incidents_after(after))
        is_closed = case((_incident.closed_at.is_(None), 0), else_=1)
        ordered = statement.order_by(
            is_closed,
            case((_incident.closed_at.is_(None), _incident.priority), else_=0),
            _incident.closed_at.desc(),
            _incident.opened_at,
            _incident.incident_id,
        )
        return tuple(incident_from_row(row) for row in self._many(ordered.limit(limit)))

    def runs(
        self, vehicle_id: str | None = None, limit: int = 100, after: RunPosition | None = None
    ) -> tuple[Run, ...]:
        statement = self._select(tables.runs)
        if vehicle_id is not None:
            statement = statement.where(_run.vehicle_id == vehicle_id)
        if after is not None:
            order = ((_run.started_at, True), (_run.boot_id, False), (_run.vehicle_id, False))
            statement = statement.where(rows_after(order, after))
        ordered = statement.order_by(_run.started_at.desc(), _run.boot_id, _run.vehicle_id)
        rows = self._many(ordered.limit(limit))
        runs = self._repository(SqlRunRepository)
        return tuple(runs.with_segments(row) for row in rows)

    def run(self, vehicle_id: str, boot_id: str) -> Run | None:
        return self._repository(SqlRunRepository).get(vehicle_id, boot_id)

    def departures(self, limit: int = 200) -> tuple[Departure, ...]:
        first_call_at = tables.departures.c.first_call_at
        ordered = self._select(tables.departures).order_by(
            first_call_at.desc(), tables.departures.c.departure_id
        )
        return tuple(departure_from_row(row) for row in self._many(ordered.limit(limit)))

    def vehicle_events(self, vehicle_id: str | None = None, limit: int = 200) -> tuple[RecordedEvent, ...]:
        statement = self._select(tables.vehicle_events)
        if vehicle_id is not None:
            statement = statement.where(_event.vehicle_id == vehicle_id)
        ordered = statement.order_by(
            _event.received_ns.desc(), _event.vehicle_id, _event.boot_id, _event.sequence.desc()
        )
        events = (recorded_from_row(row) for row in self._many(ordered.limit(limit)))
        return tuple(event for event in events if event is not None)

    def server_events(self, limit: int = 200) -> tuple[ServerEvent, ...]:
        ordered = self._select(tables.server_events).order_by(tables.server_events.c.number.desc())
        return tuple(server_event_from_row(row) for row in self._many(ordered.limit(limit)))

    def events_about(self, subject: str, limit: int = 200) -> tuple[ServerEvent, ...]:
        event = tables.server_events.c
        newest = self._select(tables.server_events, event.subject == subject).order_by(event.number.desc())
        rows = self._many(newest.limit(limit))
        return tuple(server_event_from_row(row) for row in reversed(rows))

    def history(
        self, vehicle_id: str, since: datetime, until: datetime, limit: int = 10_000
    ) -> tuple[HistoryPoint, ...]:
        return self._repository(SqlHistoryRepository).between(vehicle_id, since, until, limit)

    def _repository(self, kind: type[R]) -> R:
        return kind(self._connection, self._campus_id, None)


def _incidents_after(position: IncidentPosition) -> ColumnElement[bool]:
    """Open ones are sorted by urgency, closed ones by when they were closed."""
    rest = ((_incident.opened_at, False), (_incident.incident_id, False))
    last = (position.opened_at, position.incident_id)
    if position.closed_at is None:
        order = ((_incident.priority, False), *rest)
        still_open = and_(_incident.closed_at.is_(None), rows_after(order, (position.priority, *last)))
        return or_(_incident.closed_at.is_not(None), still_open)
    order = ((_incident.closed_at, True), *rest)
    return and_(_incident.closed_at.is_not(None), rows_after(order, (position.closed_at, *last)))


def _joined(
    vehicle: Vehicle,
    plan: Plan,
    order: IssuedOrder | None,
    where: Whereabouts | None,
    occupancy: Occupancy | None,
    command: VehicleCommand | None,
) -> VehicleView:
    return VehicleView(
        vehicle=vehicle,
        plan=plan,
        held_sections=() if occupancy is None else occupancy.held,
        sections_ahead=() if occupancy is None else occupancy.ahead,
        heard_at=None if where is None else where.heard_at,
        status=None if where is None else where.status,
        order_id="" if order is None else order.order_id,
        revision=0 if order is None else order.revision,
        order_state=None if order is None else order.state,
        order_waits=order is not None and order.plan_version < plan.version,
        route=() if order is None else lanes_of(order.payload.visits),
        last_command=command,
    )
