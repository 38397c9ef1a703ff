"""Service patterns and exceptions, in memory: they change seldom, and every booking reads them."""

from datetime import date

from sqlalchemy import Connection

from server.domain.service.service import ServiceException, ServicePattern
from server.domain.service.trips import Timetable
from server.store.cache.memory import RowCache, Rows
from server.store.record.service import SqlServiceRepository
from server.store.writing.campus_lock import CampusLock

_PATTERNS, _EXCEPTIONS, _TIMETABLE = "service patterns", "service exceptions", "timetable"
_NEWEST = "newest"


class CachedServiceRepository(SqlServiceRepository):
    def __init__(self, connection: Connection, campus_id: str, lock: CampusLock, memory: RowCache) -> None:
        super().__init__(connection, campus_id, lock)
        self._memory = memory

    def patterns(self) -> tuple[ServicePattern, ...]:
        known = self._memory.table(
            _PATTERNS, lambda: {p.service_id: p for p in SqlServiceRepository.patterns(self)}
        )
        return tuple(known.values())

    def pattern(self, service_id: str) -> ServicePattern | None:
        return next((pattern for pattern in self.patterns() if pattern.service_id == service_id), None)

    def save_pattern(self, pattern: ServicePattern) -> None:
        super().save_pattern(pattern)
        self._memory.unload(_PATTERNS)

    def remove_pattern(self, service_id: str) -> None:
        super().remove_pattern(service_id)
        self._memory.unload(_PATTERNS)
        self._memory.unload(_EXCEPTIONS)

    def timetable(self, revision: int | None = None) -> Timetable | None:
        if revision is not None:
            return super().timetable(revision)
        newest: Timetable | None = self._memory.table(_TIMETABLE, self._read_newest).get(_NEWEST)
        return newest

    def add_timetable(self, timetable: Timetable) -> None:
        super().add_timetable(timetable)
        self._memory.unload(_TIMETABLE)

    def exceptions(self, since: date | None = None) -> tuple[ServiceException, ...]:
        known = self._memory.table(_EXCEPTIONS, self._read_exceptions)
        return tuple(e for e in known.values() if since is None or e.day >= since)

    def save_exception(self, exception: ServiceException) -> None:
        super().save_exception(exception)
        self._memory.unload(_EXCEPTIONS)

    def remove_exception(self, day: date, service_id: str) -> bool:
        self._memory.unload(_EXCEPTIONS)
        return super().remove_exception(day, service_id)

    def _read_newest(self) -> Rows:
        return {_NEWEST: super().timetable()}

    def _read_exceptions(self) -> Rows:
        return {(e.day, e.service_id): e for e in super().exceptions()}
