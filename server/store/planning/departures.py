"""Timetable departures as rows."""

from server.domain.service.timetable import Call, Departure, DepartureState
from server.store import tables
from server.store.columns import from_json, to_json
from server.store.repository import AnyRow, Repository

_departure = tables.departures.c


class SqlDepartureRepository(Repository):
    def get(self, departure_id: str) -> Departure | None:
        row = self._find(tables.departures, departure_id=departure_id)
        return None if row is None else departure_from_row(row)

    def unfinished(self) -> tuple[Departure, ...]:
        states = [DepartureState.PLANNED.value, DepartureState.ASSIGNED.value]
        rows = self._many(
            self._select(tables.departures, _departure.state.in_(states)).order_by(
                _departure.first_call_at, _departure.departure_id
            )
        )
        return tuple(departure_from_row(row) for row in rows)

    def add(self, departure: Departure) -> None:
        self._insert(tables.departures, _to_row(departure))

    def save(self, departure: Departure) -> None:
        self._change(tables.departures, _to_row(departure), departure_id=departure.departure_id)


def departure_from_row(row: AnyRow) -> Departure:
    return Departure(
        campus_id=row.campus_id,
        departure_id=row.departure_id,
        trip_id=row.trip_id,
        calls=from_json(row.calls, tuple[Call, ...]),
        state=DepartureState(row.state),
        vehicle_id=row.vehicle_id,
        reason=row.reason,
    )


def _to_row(departure: Departure) -> dict[str, object]:
    return {
        "departure_id": departure.departure_id,
        "trip_id": departure.trip_id,
        "first_call_at": departure.calls[0].leave_at,
        "calls": to_json(departure.calls),
        "state": str(departure.state),
        "vehicle_id": departure.vehicle_id,
        "reason": departure.reason,
    }
