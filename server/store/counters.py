"""Numbers that only grow, such as fences."""

from sqlalchemy.sql.dml import ReturningInsert

from server.store import tables
from server.store.repository import Repository, dialect_insert

# One statement a dialect.
_DRAWING: dict[str, ReturningInsert[int]] = {}


class Counters(Repository):
    def next(self, name: str, count: int = 1) -> int:
        """The first of so many numbers in a row; 1 at the beginning."""
        self._require_lock()
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
