"""Incidents as rows."""

from collections.abc import Sequence

from sqlalchemy import or_

from server.domain.record.incidents import Incident, IncidentKind
from server.store import tables
from server.store.repository import AnyRow, Repository

_incident = tables.incidents.c


class SqlIncidentRepository(Repository):
    def get(self, incident_id: str) -> Incident | None:
        row = self._find(tables.incidents, incident_id=incident_id)
        return None if row is None else incident_from_row(row)

    def open_about(self, kind: IncidentKind, subject: str) -> Incident | None:
        row = self._one(
            tables.incidents,
            _incident.kind == str(kind),
            _incident.subject == subject,
            _incident.closed_at.is_(None),
        )
        return None if row is None else incident_from_row(row)

    def all_open(self) -> tuple[Incident, ...]:
        rows = self._many(
            self._select(tables.incidents, _incident.closed_at.is_(None)).order_by(
                _incident.priority, _incident.opened_at, _incident.incident_id
            )
        )
        return tuple(incident_from_row(row) for row in rows)

    def about_rides(self, ride_ids: Sequence[str]) -> tuple[Incident, ...]:
        is_about = or_(_incident.ride_id.in_(ride_ids), _incident.subject.in_(ride_ids))
        rows = self._many(self._select(tables.incidents, is_about).order_by(_incident.incident_id))
        return tuple(incident_from_row(row) for row in rows)

    def add(self, incident: Incident) -> None:
        self._insert(tables.incidents, _to_row(incident))

    def save(self, incident: Incident) -> None:
        self._change(tables.incidents, _to_row(incident), incident_id=incident.incident_id)


def incident_from_row(row: AnyRow) -> Incident:
    return Incident(
        campus_id=row.campus_id,
        incident_id=row.incident_id,
        kind=IncidentKind(row.kind),
        subject=row.subject,
        cause=row.cause,
        opened_at=row.opened_at,
        vehicle_id=row.vehicle_id,
        ride_id=row.ride_id,
        acknowledged_at=row.acknowledged_at,
        acknowledged_by=row.acknowledged_by,
        closed_at=row.closed_at,
        closed_by=row.closed_by,
    )


def _to_row(incident: Incident) -> dict[str, object]:
    return {
        "incident_id": incident.incident_id,
        "kind": str(incident.kind),
        "priority": incident.priority,
        "subject": incident.subject,
        "cause": incident.cause,
        "opened_at": incident.opened_at,
        "vehicle_id": incident.vehicle_id,
        "ride_id": incident.ride_id,
        "acknowledged_at": incident.acknowledged_at,
        "acknowledged_by": incident.acknowledged_by,
        "closed_at": incident.closed_at,
        "closed_by": incident.closed_by,
    }
