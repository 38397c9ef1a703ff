"""Watches the statements of a PostgreSQL engine: the campus's lock comes first, and reading locks no row."""

import re
from typing import Any

from sqlalchemy import Connection, Engine, event

_WRITES = re.compile(r"^\s*(INSERT|UPDATE|DELETE|MERGE|TRUNCATE|LOCK)\b", re.IGNORECASE)
_LOCKS_BY_READING = re.compile(r"\bFOR\s+(NO\s+KEY\s+)?(UPDATE|SHARE|KEY\s+SHARE)\b", re.IGNORECASE)
_TAKES_CAMPUS_LOCK = re.compile(r"^\s*INSERT INTO counters\b.*%\(name\)s", re.IGNORECASE | re.DOTALL)


class LockOrderBroken(AssertionError):
    """A writing transaction locked something before its campus."""


def watch_lock_order(engine: Engine) -> None:
    """Raise LockOrderBroken at the first statement that breaks the order of docs/server/store.md."""
    if engine.dialect.name != "postgresql":
        return

    @event.listens_for(engine, "begin")
    def _begun(connection: Connection) -> None:
        connection.info["campus_locked"] = False

    @event.listens_for(engine, "before_cursor_execute")
    def _check(
        connection: Connection, _cursor: Any, statement: str, parameters: Any, _context: Any, _many: bool
    ) -> None:
        if _LOCKS_BY_READING.search(statement):
            raise LockOrderBroken(f"locked by reading: {statement}")
        if _TAKES_CAMPUS_LOCK.match(statement) and parameters.get("name") == "writer":
            connection.info["campus_locked"] = True
        elif _WRITES.match(statement) and not connection.info.get("campus_locked"):
            raise LockOrderBroken(f"written before the lock of the campus: {statement}")
