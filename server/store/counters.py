"""Numbers that only grow. Drawing one locks its row: writers of one thing take turns."""

from sqlalchemy import Connection
from sqlalchemy.sql.dml import ReturningInsert

from server.store import tables
from server.store.repository import Repository, dialect_insert

# One statement a dialect: it draws the number and locks its row at once.
_DRAWING: dict[str, ReturningInsert[int]] = {}


class Counters(Repository):
    def __init__(self, connection: Connection, campus_id: str) -> None:
        super().__init__(connection, campus_id, locks=True)

    def next(self, name: str, count: int = 1) -> int:
        """The first of so many numbers in a row; 1 at the beginning."""
        last = self._connection.execute(
            self._drawing(), {"campus_id": self._campus_id, "name": name, "value": count}
        ).scalar_one()
        return int(last) - count + 1

    def _drawing(self) -> ReturningInsert[int]:
        dialect = self._connection.dialect.name
        if dialect not in _DRAWING:
            counter = tables.counters
            new = dialect_insert(dialect, counter)
            drawn = {"value": counter.c.value + new.excluded.value}
            _DRAWING[dialect] = new.on_conflict_do_update(
                index_elements=["campus_id", "name"], set_=drawn
            ).returning(counter.c.value)
        return _DRAWING[dialect]

    def lock(self, name: str) -> None:
        """Lock this counter until the transaction ends."""
        self._add_missing(tables.counters, [{"name": name, "value": 0}])
        self._find(tables.counters, name=name)
