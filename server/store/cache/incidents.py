"""Open incidents, in memory: every report of a vehicle asks whether one about it is open."""

from datetime import datetime

from sqlalchemy import Connection

from server.domain.record.incidents import Incident, IncidentKind
from server.store.cache.memory import RowCache, Rows
from server.store.record.incidents import SqlIncidentRepository
from server.store.writing.campus_lock import CampusLock

_OPEN = "open incidents"


class CachedIncidentRepository(SqlIncidentRepository):
    def __init__(self, connection: Connection, campus_id: str, lock: CampusLock, memory: RowCache) -> None:
        super().__init__(connection, campus_id, lock)
        self._memory = memory

    def open_about(self, kind: IncidentKind, subject: str) -> Incident | None:
        found: Incident | None = self._known().get((kind, subject))
        return found

    def all_open(self) -> tuple[Incident, ...]:
        def urgency(incident: Incident) -> tuple[int, datetime, str]:
            return incident.priority, incident.opened_at, incident.incident_id

        return tuple(sorted(self._known().values(), key=urgency))

    def add(self, incident: Incident) -> None:
        super().add(incident)
        self._keep(incident)

    def save(self, incident: Incident) -> None:
        super().save(incident)
        self._keep(incident)

    def _keep(self, incident: Incident) -> None:
        about = (incident.kind, incident.subject)
        if incident.closed_at is None:
            self._memory.put(_OPEN, about, incident)
        else:
            self._memory.remove(_OPEN, about)

    def _known(self) -> Rows:
        return self._memory.table(
            _OPEN, lambda: {(one.kind, one.subject): one for one in SqlIncidentRepository.all_open(self)}
        )
