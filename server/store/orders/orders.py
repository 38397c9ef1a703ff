"""Orders as they went over the wire, every revision a row."""

from collections.abc import Sequence

from sqlalchemy import Connection, func, select

from contract.wire.messages import Order
from server.domain.orders.orders import IssuedOrder, OrderState
from server.store import tables
from server.store.columns import from_json, to_json
from server.store.counters import Counters
from server.store.repository import AnyRow, Repository
from server.store.writing.campus_lock import CampusLock

_order = tables.orders.c


class SqlOrderRepository(Repository):
    def __init__(self, connection: Connection, campus_id: str, lock: CampusLock | None) -> None:
        super().__init__(connection, campus_id, lock)
        self._counters = Counters(connection, campus_id, lock)

    def current(self, vehicle_id: str) -> IssuedOrder | None:
        statement = self._select(tables.orders, _order.vehicle_id == vehicle_id)
        row = self._connection.execute(statement.order_by(_order.number.desc()).limit(1)).first()
        return None if row is None else order_from_row(row)

    def all_current(self, vehicle_ids: Sequence[str]) -> dict[str, IssuedOrder]:
        """`current` of those vehicles that have one, by vehicle id."""
        newest = (
            select(func.max(_order.number))
            .where(_order.campus_id == self._campus_id, _order.vehicle_id.in_(vehicle_ids))
            .group_by(_order.vehicle_id)
        )
        rows = self._many(self._select(tables.orders, _order.number.in_(newest)))
        return {row.vehicle_id: order_from_row(row) for row in rows}

    def find(self, vehicle_id: str, order_id: str, revision: int) -> IssuedOrder | None:
        row = self._find(tables.orders, vehicle_id=vehicle_id, order_id=order_id, revision=revision)
        return None if row is None else order_from_row(row)

    def has_named(self, vehicle_id: str, ride_id: str) -> bool:
        # Reports on rides that a vehicle does not have are rare: the payloads need no index.
        named = _order.payload.contains(f'"ride_id":"{ride_id}"', autoescape=True)
        newest = (
            select(_order.number)
            .where(_order.campus_id == self._campus_id, _order.vehicle_id == vehicle_id, named)
            .order_by(_order.number.desc())
            .limit(1)
        )
        return self._connection.execute(newest).first() is not None

    def add(self, order: IssuedOrder) -> None:
        self._insert(tables.orders, {"number": self._counters.next("order"), **_to_row(order)})

    def save(self, order: IssuedOrder) -> None:
        self._change(tables.orders, _to_row(order), order_id=order.order_id, revision=order.revision)


def order_from_row(row: AnyRow) -> IssuedOrder:
    return IssuedOrder(
        campus_id=row.campus_id,
        vehicle_id=row.vehicle_id,
        order_id=row.order_id,
        revision=row.revision,
        plan_version=row.plan_version,
        state=OrderState(row.state),
        payload=from_json(row.payload, Order),
        issued_at=row.issued_at,
        reason=row.reason,
    )


def _to_row(order: IssuedOrder) -> dict[str, object]:
    return {
        "order_id": order.order_id,
        "revision": order.revision,
        "vehicle_id": order.vehicle_id,
        "plan_version": order.plan_version,
        "state": str(order.state),
        "payload": to_json(order.payload),
        "issued_at": order.issued_at,
        "reason": order.reason,
    }
