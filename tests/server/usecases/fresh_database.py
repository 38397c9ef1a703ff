"""SQLite databases with all tables, copied instead of migrated: tests want hundreds of them."""

import sqlite3
from contextlib import closing
from functools import cache
from pathlib import Path
from typing import Any

from sqlalchemy import Engine

from server.store.engine import open_engine
from server.store.schema import upgrade_to_head


def fresh_database() -> Engine:
    engine = open_engine("sqlite://")
    fill(engine, _migrated())
    return engine


def fill(engine: Engine, copied: sqlite3.Connection) -> None:
    """Put the content of another SQLite database in the place of this one's."""
    with engine.connect() as connection:
        raw: Any = connection.connection.dbapi_connection
        copied.backup(raw)


def write_fresh_database(path: Path) -> None:
    """The same as a file."""
    with closing(sqlite3.connect(path)) as made:
        _migrated().backup(made)


@cache
def _migrated() -> sqlite3.Connection:
    engine = open_engine("sqlite://")
    upgrade_to_head(engine)
    return taken_copy(engine)


def taken_copy(engine: Engine) -> sqlite3.Connection:
    """A copy of an SQLite database, which is closed."""
    copy = sqlite3.connect(":memory:", check_same_thread=False)
    with engine.connect() as connection:
        raw: Any = connection.connection.dbapi_connection
        raw.backup(copy)
    engine.dispose()
    return copy
