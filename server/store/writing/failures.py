"""What an error of the database driver means: is the database unavailable, or is the statement wrong?"""

import sqlite3
from typing import Any

from sqlalchemy import Connection
from sqlalchemy.exc import DBAPIError, DisconnectionError
from sqlalchemy.exc import TimeoutError as PoolTimeout

# SQLSTATE classes: connection, insufficient resources, operator intervention, system error.
_UNAVAILABLE_CLASSES = frozenset({"08", "53", "57", "58"})
# Serialization failure, deadlock; a standby, which is read-only; a session that was idle for too long; a lock
# that was not given in time. The transaction is rolled back in each of these cases.
_UNAVAILABLE_STATES = frozenset({"40001", "40P01", "25006", "25P03", "55P03"})
_SQLITE_UNAVAILABLE = frozenset(
    {
        sqlite3.SQLITE_BUSY,
        sqlite3.SQLITE_LOCKED,
        sqlite3.SQLITE_NOMEM,
        sqlite3.SQLITE_READONLY,
        sqlite3.SQLITE_IOERR,
        sqlite3.SQLITE_CORRUPT,
        sqlite3.SQLITE_FULL,
        sqlite3.SQLITE_CANTOPEN,
        sqlite3.SQLITE_PROTOCOL,
        sqlite3.SQLITE_NOTADB,
    }
)
# The file and the connection are whole: another process holds the lock, or there is no room.
_SQLITE_WHOLE = frozenset({sqlite3.SQLITE_BUSY, sqlite3.SQLITE_LOCKED, sqlite3.SQLITE_FULL})


class TransactionLost(Exception):
    """The database has ended the transaction on its own; the cause says why."""


def is_unavailable(error: BaseException) -> bool:
    """The same work may succeed later: the database is locked, full, restarting or out of reach."""
    if isinstance(error, TransactionLost | PoolTimeout | DisconnectionError):
        return True
    if not isinstance(error, DBAPIError):
        return False
    if isinstance(error.orig, sqlite3.Error):
        # An error made by the driver itself has no code.
        return getattr(error.orig, "sqlite_errorcode", 0) & 0xFF in _SQLITE_UNAVAILABLE
    state = getattr(error.orig, "sqlstate", None)
    if error.connection_invalidated or (state is None and _is_operational(error)):
        return True
    return state is not None and (state in _UNAVAILABLE_STATES or state[:2] in _UNAVAILABLE_CLASSES)


def cause_of_loss(error: BaseException) -> BaseException:
    """What the database ended the transaction for. Undoing what is gone fails too, and comes after it."""
    seen: BaseException | None = error
    while seen is not None:
        if is_unavailable(seen):
            return seen
        seen = seen.__context__
    return error.__context__ or error


def leaves_connection_whole(error: BaseException) -> bool:
    """After a rollback it is as good as before: SQLite was locked by another process, or the disk is full.

    Of a database server that is never known.
    """
    cause = error.__cause__ if isinstance(error, TransactionLost) else error
    return (
        isinstance(cause, DBAPIError)
        and isinstance(cause.orig, sqlite3.Error)
        and getattr(cause.orig, "sqlite_errorcode", 0) & 0xFF in _SQLITE_WHOLE
    )


def cause_of(error: BaseException) -> str:
    """One line for people: the innermost cause without the statement."""
    if isinstance(error, TransactionLost) and error.__cause__ is not None:
        return cause_of(error.__cause__)
    text = str(error.orig if isinstance(error, DBAPIError) else error)
    return text.splitlines()[0] if text else type(error).__name__


def is_in_transaction(connection: Connection) -> bool:
    """False after the database has rolled back by itself, or is out of reach."""
    if connection.invalidated:
        return False
    raw: Any = connection.connection.dbapi_connection
    if connection.dialect.name == "sqlite":
        return bool(raw.in_transaction)
    return not raw.closed and raw.info.transaction_status.name in ("INTRANS", "INERROR")


def is_cut(connection: Connection, error: BaseException) -> bool:
    """The connection to a database server ended instead of answering the statement."""
    if connection.dialect.name == "sqlite":
        return False
    raw: Any = None if connection.invalidated else connection.connection.dbapi_connection
    diagnosis = getattr(getattr(error, "orig", None), "diag", None)
    severity = getattr(diagnosis, "severity_nonlocalized", None)
    return raw is None or bool(raw.closed) or severity in ("FATAL", "PANIC")


def _is_operational(error: DBAPIError) -> bool:
    return type(error.orig).__name__ in ("OperationalError", "InterfaceError")
