"""Numbers that only grow. Drawing one locks its row: writers of one thing take turns."""

from typing import Any

from sqlalchemy import Connection

from server.store import tables
from server.store.repository import Repository

# One statement a dialect: it draws the number and locks its row at once.
_DRAWING: dict[str, Any] = {}


class Counters(Repository):
    def __init__(self, connection: Connection, campus_id: str) -> None:
        super().__init__(connection, campus_id, locks=True)

    def next(self, name: str, count: int = 1) -> int:
        """The first of so many numbers in a row; 1 at the beginning."""
        last = self._connection.execute(
            self._drawing(), {"campus_id": self._campus_id, "name": name, "value": count}
        ).scalar_one()
        return int(last) - count + 1

    def _drawing(self) -> Any:
        if self._connection.dialect.name not in _DRAWING:
            counter = tables.counters
            new = self._dialect_insert(counter)
            drawn = {"value": counter.c.value + new.excluded.value}
            _DRAWING[self._connection.dialect.name] = new.on_conflict_do_update(
                index_elements=["campus_id", "name"], set_=drawn
            ).returning(counter.c.value)
        return _DRAWING[self._connection.dialect.name]

    def lock(self, name: str) -> None:
        """Lock this counter until the transaction ends."""
        self._add_missing(tables.counters, [{"name": name, "value": 0}])
        self._find(tables.counters, name=name)
