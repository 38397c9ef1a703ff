"""Rides and the taps on their way to vehicles, as rows."""

from collections.abc import Sequence
from dataclasses import replace
from datetime import datetime

from sqlalchemy import ColumnElement, Connection, bindparam, select

from server.domain.rides.feedback import Feedback
from server.domain.rides.rides import (
    ENDED,
    ERASED,
    Promise,
    Ride,
    RideState,
    Tap,
)
from server.store import tables
from server.store.repository import AnyRow, Repository
from server.store.writing.campus_lock import CampusLock

_ride = tables.rides.c
_tap = tables.taps.c
_feedback = tables.ride_feedback.c
# Asked for every message to a vehicle: made once.
_PENDING_TAPS = (
    select(tables.taps)
    .where(
        _tap.campus_id == bindparam("campus_id"),
        _tap.vehicle_id == bindparam("vehicle_id"),
        _tap.state == "pending",
    )
    .order_by(_tap.made_at, _tap.tap_id)
)


class SqlRideRepository(Repository):
    """Rides are written when the transaction ends, or before it reads them: most change more than once."""

    def __init__(self, connection: Connection, campus_id: str, lock: CampusLock | None) -> None:
        super().__init__(connection, campus_id, lock)
        self._unwritten: dict[str, Ride] = {}

    def flush(self) -> None:
        """Write what has changed."""
        changed = [_ride_to_row(ride) for ride in self._unwritten.values()]
        self._unwritten.clear()
        self._put_all(tables.rides, changed)

    def get(self, ride_id: str) -> Ride | None:
        self.flush()
        return _optional(self._find(tables.rides, ride_id=ride_id))

    def by_code(self, ride_code: str) -> Ride | None:
        self.flush()
        rows = self._many(
            self._select(tables.rides, _ride.ride_code == ride_code).order_by(
                _ride.requested_at.desc(), _ride.ride_id.desc()
            )
        )
        rides = [ride_from_row(row) for row in rows]
        return next((ride for ride in rides if not ride.has_ended), rides[0] if rides else None)

    def by_old_token(self, token_sha256: str) -> Ride | None:
        self.flush()
        return _optional(self._find(tables.rides, old_token_sha256=token_sha256))

    def by_idempotency_key(self, key: str) -> Ride | None:
        self.flush()
        return _optional(self._find(tables.rides, idempotency_key=key))

    def in_states(self, states: Sequence[RideState]) -> tuple[Ride, ...]:
        return self._listed(_ride.state.in_([str(state) for state in states]))

    def of_vehicle(self, vehicle_id: str, states: Sequence[RideState]) -> tuple[Ride, ...]:
        return self._listed(_ride.vehicle_id == vehicle_id, _ride.state.in_([str(state) for state in states]))

    def wanted_between(self, begins: datetime, ends: datetime) -> tuple[Ride, ...]:
        return self._listed(_ride.earliest >= begins, _ride.earliest < ends)

    def code_in_use(self, ride_code: str) -> bool:
        self.flush()
        ended = [str(state) for state in ENDED]
        found = self._one(tables.rides, _ride.ride_code == ride_code, _ride.state.not_in(ended))
        return found is not None

    def add(self, ride: Ride) -> None:
        self._unwritten[ride.ride_id] = ride

    def save(self, ride: Ride) -> None:
        self._unwritten[ride.ride_id] = ride

    def adopt_ticket_key(self, key_id: str) -> int:
        self.flush()
        ended = [str(state) for state in ENDED]
        return self._update(
            tables.rides, {"ticket_key_id": key_id}, _ride.ticket_key_id == "", _ride.state.in_(ended)
        )

    def named_before(self, moment: datetime, limit: int) -> tuple[str, ...]:
        self.flush()
        statement = select(_ride.ride_id).where(
            _ride.campus_id == self._campus_id,
            _ride.ended_at < moment,
            _ride.state.in_([str(state) for state in ENDED]),
            _ride.ticket_key_id != ERASED,
        )
        return tuple(row.ride_id for row in self._many(statement.order_by(_ride.ended_at).limit(limit)))

    def erase(self, rides: Sequence[Ride]) -> None:
        for ride in rides:
            self.save(ride)
        self.flush()
        ride_ids = [ride.ride_id for ride in rides]
        self._update(tables.rides, {"old_token_sha256": None}, _ride.ride_id.in_(ride_ids))
        self._delete(tables.taps, _tap.ride_id.in_(ride_ids))
        self._delete(tables.ride_feedback, _feedback.ride_id.in_(ride_ids))

    def add_tap(self, tap: Tap) -> None:
        self._insert(tables.taps, _tap_to_row(tap))

    def save_tap(self, tap: Tap) -> None:
        self._change(tables.taps, _tap_to_row(tap), tap_id=tap.tap_id)

    def tap(self, tap_id: str) -> Tap | None:
        row = self._find(tables.taps, tap_id=tap_id)
        return None if row is None else _tap_from_row(row)

    def pending_taps(self, vehicle_id: str) -> tuple[Tap, ...]:
        named = {"campus_id": self._campus_id, "vehicle_id": vehicle_id}
        return tuple(_tap_from_row(row) for row in self._connection.execute(_PENDING_TAPS, named))

    def save_feedback(self, feedback: Feedback) -> None:
        self._put(
            tables.ride_feedback,
            {
                "ride_id": feedback.ride_id,
                "rating": feedback.rating,
                "lost_property": feedback.lost_property,
                "made_at": feedback.made_at,
            },
        )

    def feedback_of(self, ride_ids: Sequence[str]) -> dict[str, Feedback]:
        if not ride_ids:
            return {}
        rows = self._many(self._select(tables.ride_feedback, _feedback.ride_id.in_(ride_ids)))
        return {
            row.ride_id: Feedback(row.campus_id, row.ride_id, row.rating, row.lost_property, row.made_at)
            for row in rows
        }

    def _listed(self, *conditions: ColumnElement[bool]) -> tuple[Ride, ...]:
        self.flush()
        rows = self._many(self._select(tables.rides, *conditions).order_by(_ride.requested_at, _ride.ride_id))
        return tuple(ride_from_row(row) for row in rows)


def _optional(row: AnyRow | None) -> Ride | None:
    return None if row is None else ride_from_row(row)


def ride_from_row(row: AnyRow) -> Ride:
    promise = None
    if row.pickup_from is not None:
        promise = Promise(row.pickup_from, row.pickup_to, row.arrive_by)
    return Ride(
        campus_id=row.campus_id,
        ride_id=row.ride_id,
        ride_code=row.ride_code,
        ticket_key_id=row.ticket_key_id,
        state=RideState(row.state),
        from_stop=row.from_stop,
        to_stop=row.to_stop,
        party=row.party,
        wheelchairs=row.wheelchairs,
        earliest=row.earliest,
        requested_at=row.requested_at,
        source=row.source,
        promise=promise,
        vehicle_id=row.vehicle_id,
        pickup_eta=row.pickup_eta,
        arrival_eta=row.arrival_eta,
        boarded_at=row.boarded_at,
        boarded_how=row.boarded_how,
        ended_at=row.ended_at,
        reason=row.reason,
        reason_detail=row.reason_detail,
        promise_broken=row.promise_broken,
        first_promise=None
        if row.first_pickup_from is None
        else Promise(row.first_pickup_from, row.first_pickup_to, row.first_arrive_by),
        left_early=row.left_early,
        idempotency_key=row.idempotency_key,
        arrive_before=row.arrive_before,
        first_to_stop=row.first_to_stop,
        let_out=row.let_out,
        stranded_by=row.stranded_by,
        series_id=row.series_id,
        pinned=row.pinned,
    )


def _ride_to_row(ride: Ride) -> dict[str, object]:
    promise, first = ride.promise, ride.first_promise
    return {
        "ride_id": ride.ride_id,
        "ride_code": ride.ride_code,
        "ticket_key_id": ride.ticket_key_id,
        "state": str(ride.state),
        "from_stop": ride.from_stop,
        "to_stop": ride.to_stop,
        "party": ride.party,
        "wheelchairs": ride.wheelchairs,
        "earliest": ride.earliest,
        "requested_at": ride.requested_at,
        "source": ride.source,
        "pickup_from": None if promise is None else promise.pickup_from,
        "pickup_to": None if promise is None else promise.pickup_to,
        "arrive_by": None if promise is None else promise.arrive_by,
        "vehicle_id": ride.vehicle_id,
        "pickup_eta": ride.pickup_eta,
        "arrival_eta": ride.arrival_eta,
        "boarded_at": ride.boarded_at,
        "boarded_how": ride.boarded_how,
        "ended_at": ride.ended_at,
        "reason": ride.reason,
        "reason_detail": ride.reason_detail,
        "promise_broken": ride.promise_broken,
        "first_pickup_from": None if first is None else first.pickup_from,
        "first_pickup_to": None if first is None else first.pickup_to,
        "first_arrive_by": None if first is None else first.arrive_by,
        "left_early": ride.left_early,
        "idempotency_key": ride.idempotency_key,
        "arrive_before": ride.arrive_before,
        "first_to_stop": ride.first_to_stop,
        "let_out": ride.let_out,
        "stranded_by": ride.stranded_by,
        "series_id": ride.series_id,
        "pinned": ride.pinned,
    }


def _tap_from_row(row: AnyRow) -> Tap:
    tap = Tap(row.campus_id, row.tap_id, row.ride_id, row.vehicle_id, row.kind, row.made_at)
    return replace(tap, state=row.state, reason=row.reason)


def _tap_to_row(tap: Tap) -> dict[str, object]:
    return {
        "tap_id": tap.tap_id,
        "ride_id": tap.ride_id,
        "vehicle_id": tap.vehicle_id,
        "kind": tap.kind,
        "made_at": tap.made_at,
        "state": tap.state,
        "reason": tap.reason,
    }
