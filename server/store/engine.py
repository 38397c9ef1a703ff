"""Opening a database by its URL: SQLite in WAL mode, or PostgreSQL."""

import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from sqlalchemy import Connection, Engine, create_engine, event
from sqlalchemy.pool import QueuePool, StaticPool

# The writer and the readers of one server.
POSTGRES_POOL = 5
BUSY_TIMEOUT_MS = 1_000
# SQLite moves the write-ahead log into the database after so many pages, 32 MB. With its own 1000, a thousand
# vehicles that report have the same pages moved, and flushed, ten times a second.
CHECKPOINT_PAGES = 8_000
CONNECT_TIMEOUT_S = 5
LOCK_TIMEOUT_MS = 5_000
IDLE_TRANSACTION_TIMEOUT_MS = 30_000
# A server that is frozen or cut off gives up the lock of its campus after the idle timeout. The others wait
# until the lock timeout, and then try again. A dead peer is noticed within a quarter of a minute.
_POSTGRES_CONNECTION: dict[str, Any] = {
    "connect_timeout": CONNECT_TIMEOUT_S,
    "options": f"-c lock_timeout={LOCK_TIMEOUT_MS} "
    f"-c idle_in_transaction_session_timeout={IDLE_TRANSACTION_TIMEOUT_MS}",
    "keepalives_idle": 5,
    "keepalives_interval": 3,
    "keepalives_count": 3,
    "tcp_user_timeout": 15_000,
}


class DatabaseUnsupported(ValueError):
    """The URL names a database that the store does not support."""


def open_engine(url: str) -> Engine:
    """An engine for `sqlite:///FILE`, `sqlite://` (in memory) or `postgresql://...`.

    Raises DatabaseUnsupported.
    """
    if url.startswith("sqlite"):
        return _sqlite(url)
    if url.startswith(("postgresql://", "postgres://", "postgresql+psycopg://")):
        _, rest = url.split("://", 1)
        return create_engine(
            f"postgresql+psycopg://{rest}",
            pool_size=POSTGRES_POOL,
            pool_pre_ping=True,
            hide_parameters=True,
            connect_args=_POSTGRES_CONNECTION,
        )
    raise DatabaseUnsupported(f"{url.split(':', 1)[0]} is not supported; use sqlite:///FILE or postgresql://")


def is_in_memory(engine: Engine) -> bool:
    return engine.dialect.name == "sqlite" and engine.url.database in (None, "", ":memory:")


@contextmanager
def read_only(connection: Connection) -> Iterator[None]:
    """One transaction that waits for no writer and cannot write."""
    if connection.dialect.name == "postgresql":
        with connection.begin():
            connection.exec_driver_sql("SET TRANSACTION READ ONLY")
            yield
        return
    raw: Any = connection.connection.dbapi_connection
    raw.execute("PRAGMA query_only=ON").close()
    connection.info["reading"] = True
    try:
        with connection.begin():
            yield
    finally:
        connection.info["reading"] = False
        raw.execute("PRAGMA query_only=OFF").close()


def _sqlite(url: str) -> Engine:
    in_memory = url in ("sqlite://", "sqlite:///:memory:")
    engine = create_engine(
        url,
        poolclass=StaticPool if in_memory else QueuePool,
        connect_args={"check_same_thread": False, "isolation_level": None},
        hide_parameters=True,
    )

    @event.listens_for(engine, "connect")
    def _prepare(raw: sqlite3.Connection, _record: object) -> None:
        for pragma in (
            "journal_mode=WAL",
            "synchronous=FULL",
            "foreign_keys=ON",
            "secure_delete=ON",
            f"wal_autocheckpoint={CHECKPOINT_PAGES}",
            f"busy_timeout={BUSY_TIMEOUT_MS}",
        ):
            raw.execute(f"PRAGMA {pragma}").close()

    @event.listens_for(engine, "begin")
    def _begin(connection: Connection) -> None:
        connection.exec_driver_sql("BEGIN" if connection.info.get("reading") else "BEGIN IMMEDIATE")

    return engine
