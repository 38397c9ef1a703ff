"""Reads of a stretch of time, by the indexes on when things happened."""

from collections.abc import Sequence
from datetime import datetime

from sqlalchemy import Integer, cast, exists, func, or_, select

from server.domain.instants import ns_of
from server.domain.record.events import RecordedEvent, ServerEvent
from server.domain.record.incidents import Incident
from server.domain.record.runs import Run
from server.domain.rides.rides import Ride
from server.store import tables
from server.store.record.events import recorded_from_row, server_event_from_row
from server.store.record.incidents import incident_from_row
from server.store.record.runs import SqlRunRepository
from server.store.repository import Repository
from server.store.rides.rides import ride_from_row
from server.usecases.ports.past import PastPosition, SpeedCount

_point = tables.history.c
_event = tables.vehicle_events.c
_said = tables.server_events.c
_incident = tables.incidents.c
_ride = tables.rides.c
_run = tables.runs.c
_segment = tables.segments.c


class SqlPast(Repository):
    def positions(self, since: datetime, until: datetime, limit: int) -> tuple[PastPosition, ...]:
        columns = (
            _point.vehicle_id,
            _point.received_at,
            _point.x_m,
            _point.y_m,
            _point.yaw_rad,
            _point.speed_mps,
            _point.mode,
            _point.battery_ratio,
        )
        rows = self._connection.execute(
            select(*columns)
            .where(
                _point.campus_id == self._campus_id, _point.received_at >= since, _point.received_at < until
            )
            .order_by(_point.received_at)
            .limit(limit)
        )
        return tuple(PastPosition(*row) for row in rows)

    def vehicle_events(
        self, since: datetime, until: datetime, kinds: Sequence[str], limit: int
    ) -> tuple[RecordedEvent, ...]:
        # The tag is the first field of every event as it is encoded.
        is_kind = or_(*(_event.body.startswith(f'{{"event":"{kind}"') for kind in kinds))
        chosen = self._select(
            tables.vehicle_events,
            _event.received_ns >= ns_of(since),
            _event.received_ns < ns_of(until),
            is_kind,
        )
        rows = self._many(chosen.order_by(_event.received_ns, _event.number).limit(limit))
        events = (recorded_from_row(row) for row in rows)
        return tuple(event for event in events if event is not None)

    def server_events(
        self, since: datetime, until: datetime, names: Sequence[str], limit: int
    ) -> tuple[ServerEvent, ...]:
        chosen = self._select(
            tables.server_events,
            _said.happened_at >= since,
            _said.happened_at < until,
            _said.name.in_(names),
        )
        rows = self._many(chosen.order_by(_said.happened_at, _said.number).limit(limit))
        return tuple(server_event_from_row(row) for row in rows)

    def incidents(self, since: datetime, until: datetime, limit: int) -> tuple[Incident, ...]:
        chosen = self._select(tables.incidents, _incident.opened_at >= since, _incident.opened_at < until)
        rows = self._many(chosen.order_by(_incident.opened_at, _incident.incident_id).limit(limit))
        return tuple(incident_from_row(row) for row in rows)

    def rides(self, since: datetime, until: datetime, limit: int) -> tuple[Ride, ...]:
        chosen = self._select(
            tables.rides,
            _ride.requested_at < until,
            or_(_ride.ended_at.is_(None), _ride.ended_at >= since),
            _ride.vehicle_id.is_not(None),
        )
        rows = self._many(chosen.order_by(_ride.requested_at, _ride.ride_id).limit(limit))
        return tuple(ride_from_row(row) for row in rows)

    def wanted_rides(self, since: datetime, until: datetime, limit: int) -> tuple[Ride, ...]:
        chosen = self._select(tables.rides, _ride.earliest >= since, _ride.earliest < until)
        rows = self._many(chosen.order_by(_ride.earliest, _ride.ride_id).limit(limit))
        return tuple(ride_from_row(row) for row in rows)

    def speeds(self, since: datetime, until: datetime) -> tuple[SpeedCount, ...]:
        # Down to the whole number, on both databases: none of them has a floor of its own everywhere.
        down = cast(func.round(func.abs(_point.speed_mps) * 3.6 - 0.4999), Integer)
        rows = self._connection.execute(
            select(down, func.count(), func.sum(func.abs(_point.speed_mps)))
            .where(
                _point.campus_id == self._campus_id, _point.received_at >= since, _point.received_at < until
            )
            .group_by(down)
            .order_by(down)
        )
        return tuple(SpeedCount(*row) for row in rows)

    def runs(self, since: datetime, until: datetime, limit: int) -> tuple[Run, ...]:
        # A segment's times are the vehicle's clock, so the server's own time of its arrival decides.
        is_recorded = exists().where(
            _segment.campus_id == _run.campus_id,
            _segment.vehicle_id == _run.vehicle_id,
            _segment.boot_id == _run.boot_id,
            _segment.received_at >= since,
        )
        chosen = self._select(tables.runs, _run.started_at < until, is_recorded)
        rows = self._many(chosen.order_by(_run.started_at, _run.vehicle_id, _run.boot_id).limit(limit))
        runs = SqlRunRepository(self._connection, self._campus_id, None)
        return tuple(runs.with_segments(row) for row in rows)
