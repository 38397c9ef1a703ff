"""An SQLite database in memory with all tables, copied instead of migrated: for tests that want many."""

import sqlite3
from functools import cache
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
