"""A database to which rows are written while the test does something else."""

import sqlite3
import threading
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

from sqlalchemy import insert, select

from server.store.engine import open_engine
from server.store.tables import counters
from tests.server.usecases.fresh_database import write_fresh_database

WAIT_S = 60.0
ROWS_MAX = 100_000


class Writer:
    """Commits one row at a time. acknowledged: how many rows the database has confirmed"""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._changed = threading.Condition()
        self._stop = threading.Event()
        self.acknowledged = 0

    def run(self) -> None:
        engine = open_engine(f"sqlite:///{self._path}")
        for number in range(ROWS_MAX):
            if self._stop.is_set():
                break
            with engine.begin() as connection:
                connection.execute(insert(counters).values(campus_id="c", name=f"{number}", value=number))
            with self._changed:
                self.acknowledged = number + 1
                self._changed.notify_all()
        engine.dispose()

    def wait_for(self, rows: int) -> int:
        with self._changed:
            assert self._changed.wait_for(lambda: self.acknowledged >= rows, WAIT_S)
            return self.acknowledged

    def stop(self) -> None:
        self._stop.set()


@contextmanager
def written_meanwhile(path: Path) -> Iterator[Writer]:
    write_fresh_database(path)
    writer = Writer(path)
    thread = threading.Thread(target=writer.run)
    thread.start()
    try:
        yield writer
    finally:
        writer.stop()
        thread.join(WAIT_S)


def a_database(path: Path, rows: int = 1) -> Path:
    """A closed database with rows numbered from 0."""
    write_fresh_database(path)
    engine = open_engine(f"sqlite:///{path}")
    with engine.begin() as connection:
        for number in range(rows):
            connection.execute(insert(counters).values(campus_id="c", name=f"{number}", value=number))
    engine.dispose()
    return path


def numbers(path: Path) -> list[int]:
    """The rows that `Writer` and `a_database` have written."""
    engine = open_engine(f"sqlite:///{path}")
    with engine.connect() as connection:
        found = connection.execute(select(counters.c.value).where(counters.c.campus_id == "c")).scalars()
        rows = sorted(found)
    engine.dispose()
    return rows


def set_revision(path: Path, revision: str) -> None:
    with closing(sqlite3.connect(path)) as connection:
        connection.execute("UPDATE alembic_version SET version_num = ?", (revision,))
        connection.commit()
