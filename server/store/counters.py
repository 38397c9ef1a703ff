"""Numbers that only grow. Drawing one locks its row: writers of one thing take turns."""

from sqlalchemy import Connection, select

from server.store import tables
from server.store.repository import Repository


class Counters(Repository):
    def __init__(self, connection: Connection, campus_id: str) -> None:
        super().__init__(connection, campus_id, locks=True)

    def next(self, name: str) -> int:
        """1 for the first."""
        self.lock(name)
        counter = tables.counters
        self._update(counter, {"value": counter.c.value + 1}, counter.c.name == name)
        value = self._connection.execute(
            select(counter.c.value).where(counter.c.campus_id == self._campus_id, counter.c.name == name)
        ).scalar_one()
        return int(value)

    def lock(self, name: str) -> None:
        """Be the only one with this counter until the transaction ends."""
        self._add_missing(tables.counters, [{"name": name, "value": 0}])
        self._one(tables.counters, tables.counters.c.name == name)
