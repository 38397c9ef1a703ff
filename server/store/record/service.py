"""Service patterns and the days that differ from them, as rows."""

from datetime import date
from typing import Any

from sqlalchemy import select

from contract.roads.model import TimetableTrip
from server.domain.service.service import Hours, ServiceException, ServicePattern
from server.domain.service.trips import Timetable, TimetableVersion
from server.store import tables
from server.store.columns import from_json, to_json
from server.store.repository import AnyRow, Repository

_pattern = tables.service_patterns.c
_exception = tables.service_exceptions.c
_timetable = tables.timetables.c


class SqlServiceRepository(Repository):
    def patterns(self) -> tuple[ServicePattern, ...]:
        rows = self._many(self._select(tables.service_patterns).order_by(_pattern.service_id))
        return tuple(_to_pattern(row) for row in rows)

    def pattern(self, service_id: str) -> ServicePattern | None:
        row = self._find(tables.service_patterns, service_id=service_id)
        return None if row is None else _to_pattern(row)

    def save_pattern(self, pattern: ServicePattern) -> None:
        self._put(
            tables.service_patterns,
            {
                "service_id": pattern.service_id,
                "name": pattern.name,
                "weekdays": to_json(pattern.weekdays),
                "starts_on": pattern.starts_on,
                "ends_on": pattern.ends_on,
                "hours": to_json(pattern.hours),
            },
        )

    def remove_pattern(self, service_id: str) -> None:
        self._delete(tables.service_patterns, _pattern.service_id == service_id)
        self._delete(tables.service_exceptions, _exception.service_id == service_id)

    def timetable(self, revision: int | None = None) -> Timetable | None:
        statement = self._select(tables.timetables)
        if revision is not None:
            statement = statement.where(_timetable.revision == revision)
        rows = self._many(statement.order_by(_timetable.revision.desc()).limit(1))
        return _to_timetable(rows[0]) if rows else None

    def timetable_versions(self, limit: int) -> tuple[TimetableVersion, ...]:
        facts = [column for column in _timetable if column.name != "trips"]
        query = select(*facts).where(_timetable.campus_id == self._campus_id)
        rows = self._many(query.order_by(_timetable.revision.desc()).limit(limit))
        return tuple(
            TimetableVersion(row.revision, row.trip_count, row.made_by, row.made_at, row.note) for row in rows
        )

    def add_timetable(self, timetable: Timetable) -> None:
        self._insert(
            tables.timetables,
            {
                "revision": timetable.revision,
                "trips": to_json(timetable.trips),
                "trip_count": len(timetable.trips),
                "made_by": timetable.made_by,
                "made_at": timetable.made_at,
                "note": timetable.note,
            },
        )

    def exceptions(self, since: date | None = None) -> tuple[ServiceException, ...]:
        statement = self._select(tables.service_exceptions)
        if since is not None:
            statement = statement.where(_exception.day >= since)
        rows = self._many(statement.order_by(_exception.day, _exception.service_id))
        return tuple(_to_exception(row) for row in rows)

    def save_exception(self, exception: ServiceException) -> None:
        self._put(
            tables.service_exceptions,
            {
                "day": exception.day,
                "service_id": exception.service_id,
                "runs": exception.runs,
                "note": exception.note,
                "made_by": exception.made_by,
            },
        )

    def remove_exception(self, day: date, service_id: str) -> bool:
        is_this = (_exception.day == day, _exception.service_id == service_id)
        return self._delete(tables.service_exceptions, *is_this) > 0


def _to_timetable(row: AnyRow) -> Timetable:
    trips = from_json(row.trips, tuple[TimetableTrip, ...])
    return Timetable(row.campus_id, row.revision, trips, row.made_by, row.made_at, row.note)


def _to_pattern(row: AnyRow) -> ServicePattern:
    values: dict[str, Any] = {
        "weekdays": from_json(row.weekdays, tuple[int, ...]),
        "hours": from_json(row.hours, tuple[Hours, ...]),
    }
    return ServicePattern(
        row.campus_id, row.service_id, row.name, starts_on=row.starts_on, ends_on=row.ends_on, **values
    )


def _to_exception(row: AnyRow) -> ServiceException:
    return ServiceException(row.campus_id, row.day, row.service_id, row.runs, row.note, row.made_by)
