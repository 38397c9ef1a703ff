"""What a database file holds: whether it is sound, its schema's revision, and how many rows it has."""

import sqlite3
from collections.abc import Iterator, Mapping
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import quote

from server.store.schema import head_revision, known_revisions
from server.store.tables import metadata

# What an operator recognises a campus by.
MAIN_TABLES = ("operators", "vehicles", "rides", "plans", "orders", "incidents", "runs", "server_events")


class BadDatabaseFile(Exception):
    """The file is not a sound database of this program; the text says what is wrong with it."""


@dataclass(frozen=True, slots=True)
class DatabaseContents:
    """revision: of the schema, as Alembic stores it; rows: of the main tables, by name."""

    revision: str
    is_current: bool
    size_bytes: int
    rows: Mapping[str, int]


def backup_contents(path: Path) -> DatabaseContents:
    """What a backup holds. Writes nothing, not even beside it.

    Raises BadDatabaseFile, also if a part of the database lies in another file.
    """
    for side in ("-wal", "-journal"):
        beside = path.with_name(f"{path.name}{side}")
        if beside.exists() and beside.stat().st_size:
            raise BadDatabaseFile(
                f"{path} is no backup but a database, or the plain copy of one: {beside.name} has "
                "a part of its rows; make backups with `campusloop backup`"
            )
    return _contents(path, "mode=ro&immutable=1")


def database_contents(path: Path) -> DatabaseContents:
    """The same of a database that a server may have open. Raises BadDatabaseFile."""
    return _contents(path, reading(path))


def reading(path: Path) -> str:
    """The parameters for `opened` with which a database is read, whether a server has it open or not.

    Without a log no server has it open, and SQLite would leave a log behind that belongs to this user.
    """
    has_log = path.with_name(f"{path.name}-wal").exists()
    return "mode=ro" if has_log else "mode=ro&immutable=1"


@contextmanager
def opened(path: Path, parameters: str) -> Iterator[sqlite3.Connection]:
    """A connection to a file that exists. Raises BadDatabaseFile for every error of SQLite inside."""
    try:
        if not path.is_file():
            raise BadDatabaseFile(f"{path} is not a file")
        with closing(sqlite3.connect(f"file:{quote(str(path))}?{parameters}", uri=True)) as connection:
            yield connection
    except (sqlite3.Error, OSError) as error:
        raise BadDatabaseFile(f"{path} cannot be used as a database: {error}") from error


def _contents(path: Path, parameters: str) -> DatabaseContents:
    with opened(path, parameters) as connection:
        tables = connection.execute("SELECT name FROM sqlite_master WHERE type = 'table'")
        present = {row[0] for row in tables}
        revision = _revision(connection, path, present)
        _check(connection, path)
        rows = {
            name: connection.execute(f'SELECT count(*) FROM "{name}"').fetchone()[0]
            for name in MAIN_TABLES
            if name in present
        }
    return DatabaseContents(revision, revision == head_revision(), path.stat().st_size, rows)


def _revision(connection: sqlite3.Connection, path: Path, present: set[str]) -> str:
    """Raises BadDatabaseFile if this version of the program does not know the database's revision."""
    found = (
        connection.execute("SELECT version_num FROM alembic_version").fetchall()
        if "alembic_version" in present
        else []
    )
    if len(found) != 1:
        raise BadDatabaseFile(f"{path} is not a Campusloop database: it has no revision of the schema")
    revision = str(found[0][0])
    if revision not in known_revisions():
        raise BadDatabaseFile(
            f"{path} is at revision {revision}, which this version does not know; update the program"
        )
    if revision == head_revision() and (missing := metadata.tables.keys() - present):
        raise BadDatabaseFile(f"{path} lacks the tables {', '.join(sorted(missing))}")
    return revision


def _check(connection: sqlite3.Connection, path: Path) -> None:
    defects = [row[0] for row in connection.execute("PRAGMA integrity_check(3)")]
    if defects != ["ok"]:
        raise BadDatabaseFile(f"{path} is damaged: {'; '.join(map(str, defects))}")
    orphans = connection.execute("PRAGMA foreign_key_check").fetchall()
    if orphans:
        raise BadDatabaseFile(f"{path} is damaged: {len(orphans)} rows refer to rows that are missing")
