"""The order in force of each vehicle, in memory."""

from sqlalchemy import Connection

from server.domain.orders.orders import IssuedOrder
from server.store.cache.memory import RowCache
from server.store.orders.orders import SqlOrderRepository
from server.store.writing.campus_lock import CampusLock

_CURRENT = "orders in force"


class CachedOrderRepository(SqlOrderRepository):
    def __init__(self, connection: Connection, campus_id: str, lock: CampusLock, memory: RowCache) -> None:
        super().__init__(connection, campus_id, lock)
        self._memory = memory

    def current(self, vehicle_id: str) -> IssuedOrder | None:
        known = self._memory.table(_CURRENT)
        if vehicle_id not in known:
            self._memory.put(_CURRENT, vehicle_id, super().current(vehicle_id))
        order: IssuedOrder | None = known[vehicle_id]
        return order

    def add(self, order: IssuedOrder) -> None:
        super().add(order)
        self._memory.table(_CURRENT)
        self._memory.put(_CURRENT, order.vehicle_id, order)

    def save(self, order: IssuedOrder) -> None:
        super().save(order)
        present = self._memory.table(_CURRENT).get(order.vehicle_id)
        if present is not None and (present.order_id, present.revision) == (order.order_id, order.revision):
            self._memory.put(_CURRENT, order.vehicle_id, order)
