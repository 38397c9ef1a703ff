"""The file of an SQLite database: one server at a time, and always the file that was opened."""

import fcntl
import os
from pathlib import Path
from typing import IO

from sqlalchemy import Engine

from server.store.engine import is_in_memory


class DatabaseInUse(RuntimeError):
    """Another server has this database open. holder: the number of its process."""

    def __init__(self, path: Path, holder: str) -> None:
        super().__init__(
            f"the database {path} is in use by another server (process {holder}): stop it, or give "
            "this server a folder of its own (CAMPUSLOOP_VAR_DIR); several servers share a PostgreSQL "
            "database (CAMPUSLOOP_DATABASE_URL)"
        )
        self.holder = holder


class DatabaseFile:
    """`lock` it for as long as the server runs; `is_replaced` tells that another file has its name now."""

    def __init__(self, path: Path) -> None:
        # Two names of one file have one lock.
        self._path = path.resolve()
        self._lock_path = self._path.with_name(f"{self._path.name}.lock")
        self._lock: IO[str] | None = None
        self._identity: tuple[int, int] | None = None

    def lock(self) -> None:
        """Keep other servers out until `close`, or until this process ends, however it ends.

        The lock is on a file beside the database, so that it also covers a copy that replaces the database.
        Raises DatabaseInUse, OSError.
        """
        opened = self._lock_path.open("a+", encoding="ascii")
        try:
            fcntl.flock(opened, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            opened.seek(0)
            holder = opened.read(20).strip() or "unknown"
            opened.close()
            raise DatabaseInUse(self._path, holder) from error
        opened.truncate(0)
        opened.write(f"{os.getpid()}\n")
        opened.flush()
        self._lock = opened

    def close(self) -> None:
        if self._lock is not None:
            self._lock.close()
            self._lock = None

    def opened(self) -> None:
        """A connection to the file has been opened: remember which file that is."""
        self._identity = self._present()

    def is_replaced(self) -> bool:
        """The name of the database belongs to another file, or to none."""
        return self._identity is not None and self._present() != self._identity

    def _present(self) -> tuple[int, int] | None:
        try:
            found = self._path.stat()
        except FileNotFoundError:
            return None
        return found.st_dev, found.st_ino


def database_file(engine: Engine) -> DatabaseFile | None:
    """The file of this database; None in memory and on PostgreSQL."""
    path = database_path(engine)
    return None if path is None else DatabaseFile(path)


def database_path(engine: Engine) -> Path | None:
    """Where the file of this database is; None in memory and on PostgreSQL."""
    if engine.dialect.name != "sqlite" or is_in_memory(engine):
        return None
    return Path(engine.url.database or "")
