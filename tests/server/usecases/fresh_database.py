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
    with engine.connect() as connection:
        raw: Any = connection.connection.dbapi_connection
        _migrated().backup(raw)
    return engine


def write_fresh_database(path: Path) -> None:
    """The same as a file."""
    with closing(sqlite3.connect(path)) as made:
        _migrated().backup(made)


@cache
def _migrated() -> sqlite3.Connection:
    engine = open_engine("sqlite://")
    upgrade_to_head(engine)
    copy = sqlite3.connect(":memory:", check_same_thread=False)
    with engine.connect() as connection:
        raw: Any = connection.connection.dbapi_connection
        raw.backup(copy)
    engine.dispose()
    return copy
