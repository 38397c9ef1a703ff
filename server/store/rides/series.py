"""Recurring bookings and their days, as rows."""

from collections.abc import Sequence
from datetime import date, datetime

from server.domain.rides.series import (
    Occurrence,
    OccurrenceState,
    Series,
    SeriesState,
)
from server.store import tables
from server.store.columns import from_json, to_json
from server.store.keyset import rows_after
from server.store.repository import AnyRow, Repository
from server.usecases.ports.views import MomentAndId

_series = tables.series.c
_occurrence = tables.occurrences.c


class SqlSeriesRepository(Repository):
    def get(self, series_id: str) -> Series | None:
        return _optional(self._find(tables.series, series_id=series_id))

    def by_old_token(self, token_sha256: str) -> Series | None:
        return _optional(self._find(tables.series, old_token_sha256=token_sha256))

    def by_idempotency_key(self, key: str) -> Series | None:
        return _optional(self._find(tables.series, idempotency_key=key))

    def listed(
        self,
        states: Sequence[SeriesState] | None = None,
        limit: int | None = None,
        after: MomentAndId | None = None,
    ) -> tuple[Series, ...]:
        statement = self._select(tables.series)
        if states is not None:
            statement = statement.where(_series.state.in_([str(state) for state in states]))
        if after is not None:
            order = ((_series.made_at, True), (_series.series_id, False))
            statement = statement.where(rows_after(order, after))
        rows = self._many(statement.order_by(_series.made_at.desc(), _series.series_id).limit(limit))
        return tuple(_to_series(row) for row in rows)

    def add(self, series: Series) -> None:
        self._insert(tables.series, _to_row(series))

    def save(self, series: Series) -> None:
        self._change(tables.series, _to_row(series), series_id=series.series_id)

    def ended_before(self, moment: datetime, limit: int) -> tuple[str, ...]:
        statement = self._select(tables.series, _series.ended_at < moment).order_by(_series.ended_at)
        return tuple(row.series_id for row in self._many(statement.limit(limit)))

    def unlink_rides(self, ride_ids: Sequence[str]) -> None:
        self._update(tables.occurrences, {"ride_id": None}, _occurrence.ride_id.in_(ride_ids))

    def erase(self, series_id: str) -> None:
        self._delete(tables.occurrences, _occurrence.series_id == series_id)
        self._delete(tables.series, _series.series_id == series_id)

    def occurrence(self, series_id: str, day: date) -> Occurrence | None:
        row = self._find(tables.occurrences, series_id=series_id, day=day)
        return None if row is None else _to_occurrence(row)

    def occurrences(self, series_id: str) -> tuple[Occurrence, ...]:
        statement = self._select(tables.occurrences, _occurrence.series_id == series_id)
        return tuple(_to_occurrence(row) for row in self._many(statement.order_by(_occurrence.day)))

    def occurrences_between(self, first: date, last: date) -> tuple[Occurrence, ...]:
        within = _occurrence.day.between(first, last)
        statement = self._select(tables.occurrences, within)
        rows = self._many(statement.order_by(_occurrence.series_id, _occurrence.day))
        return tuple(_to_occurrence(row) for row in rows)

    def save_occurrence(self, occurrence: Occurrence) -> None:
        self._put(
            tables.occurrences,
            {
                "series_id": occurrence.series_id,
                "day": occurrence.day,
                "leave_at": occurrence.leave_at,
                "state": str(occurrence.state),
                "ride_id": occurrence.ride_id,
                "reason": occurrence.reason,
                "reason_detail": occurrence.reason_detail,
                "tried_at": occurrence.tried_at,
            },
        )


def _optional(row: AnyRow | None) -> Series | None:
    return None if row is None else _to_series(row)


def _to_series(row: AnyRow) -> Series:
    return Series(
        campus_id=row.campus_id,
        series_id=row.series_id,
        ticket_key_id=row.ticket_key_id,
        from_stop=row.from_stop,
        to_stop=row.to_stop,
        party=row.party,
        wheelchairs=row.wheelchairs,
        weekdays=from_json(row.weekdays, tuple[int, ...]),
        leave_s=row.leave_s,
        starts_on=row.starts_on,
        ends_on=row.ends_on,
        made_at=row.made_at,
        source=row.source,
        state=SeriesState(row.state),
        ended_at=row.ended_at,
        idempotency_key=row.idempotency_key,
    )


def _to_row(series: Series) -> dict[str, object]:
    return {
        "series_id": series.series_id,
        "ticket_key_id": series.ticket_key_id,
        "from_stop": series.from_stop,
        "to_stop": series.to_stop,
        "party": series.party,
        "wheelchairs": series.wheelchairs,
        "weekdays": to_json(series.weekdays),
        "leave_s": series.leave_s,
        "starts_on": series.starts_on,
        "ends_on": series.ends_on,
        "made_at": series.made_at,
        "source": series.source,
        "state": str(series.state),
        "ended_at": series.ended_at,
        "idempotency_key": series.idempotency_key,
    }


def _to_occurrence(row: AnyRow) -> Occurrence:
    return Occurrence(
        campus_id=row.campus_id,
        series_id=row.series_id,
        day=row.day,
        leave_at=row.leave_at,
        state=OccurrenceState(row.state),
        ride_id=row.ride_id,
        reason=row.reason,
        reason_detail=row.reason_detail,
        tried_at=row.tried_at,
    )
