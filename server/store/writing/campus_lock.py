"""The one lock of the store: every writing transaction takes the lock of its campus first, and no other.

On SQLite `BEGIN IMMEDIATE` is the lock. `PRAGMA data_version` tells whether another connection has written; a
database in memory has only one.

On PostgreSQL the lock is the row `writer` of the campus's counters. Taking it counts the transaction, and a
rollback takes that back, so the number also tells whether another server has written. Its low bits are a
random mark: by it, a writer whose connection was cut during the commit finds out whether that is stored.
"""

from dataclasses import dataclass

from sqlalchemy import Connection, select
from sqlalchemy.dialects import postgresql
from sqlalchemy.sql.dml import ReturningInsert

from server.store import tables
from server.store.engine import is_in_memory

_WRITER = "writer"
_MARKS = 1 << 24
_counter = tables.counters.c


@dataclass(slots=True)
class CampusLock:
    """The proof that a transaction is the only writer of its campus.

    found, made  versions of the campus: before this transaction, and after it if it commits
    marked       PostgreSQL: what the row of the lock holds if it commits
    has_written  whether anything but the lock has been written
    """

    campus_id: str
    found: int
    made: int
    marked: int = 0
    is_held: bool = True
    has_written: bool = False

    def require(self, campus_id: str) -> None:
        """Before every write. AssertionError for one without the lock: too late, or to another campus."""
        assert self.is_held, "written after the transaction has ended"
        assert self.campus_id == campus_id, f"written to {campus_id} under the lock of {self.campus_id}"
        self.has_written = True


def take_campus_lock(connection: Connection, campus_id: str, chance: float) -> CampusLock:
    """The lock, for the transaction that has just begun. Other writers of the campus wait until it ends.

    chance  from 0 up to 1: the mark
    """
    if is_in_memory(connection.engine):
        return CampusLock(campus_id, 0, 0)
    if connection.dialect.name == "sqlite":
        version = int(connection.exec_driver_sql("PRAGMA data_version").scalar_one())
        return CampusLock(campus_id, version, version)
    first = _MARKS + int(chance * _MARKS)
    row = {"campus_id": campus_id, "name": _WRITER, "value": first}
    marked = int(connection.execute(_TAKING, row).scalar_one())
    made = marked // _MARKS
    return CampusLock(campus_id, made - 1, made, marked)


def was_committed(connection: Connection, lock: CampusLock) -> bool | None:
    """Whether the transaction that held this lock is stored; None if a later one has covered its mark.

    It waits until the database has ended that transaction.
    """
    row = select(_counter.value).where(_counter.campus_id == lock.campus_id, _counter.name == _WRITER)
    present = connection.execute(row.with_for_update()).scalar_one_or_none() or 0
    if present == lock.marked:
        return True
    return False if present // _MARKS < lock.made else None


def _taking() -> ReturningInsert[int]:
    new = postgresql.insert(tables.counters)
    counted = _counter.value // _MARKS * _MARKS + new.excluded.value
    taken = new.on_conflict_do_update(index_elements=["campus_id", "name"], set_={"value": counted})
    return taken.returning(_counter.value)


_TAKING = _taking()
