"""A verified copy of an SQLite database, made while a server runs on it."""

import os
import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

from server.store.backups.contents import BadDatabaseFile, DatabaseContents, backup_contents, opened


class BackupRefused(Exception):
    """There is no backup; the text says why and what to do."""


def back_up(database: Path, target: Path) -> DatabaseContents:
    """Write a backup to `target`, which appears only when it is complete, verified and on the disk.

    Raises BackupRefused.
    """
    try:
        with draft_beside(target) as draft:
            _copy(database, draft)
            contents = backup_contents(draft)
            publish_new(draft, target)
    except FileExistsError as error:
        raise BackupRefused(f"{target} exists; give another name") from error
    except (BadDatabaseFile, sqlite3.Error, OSError) as error:
        raise BackupRefused(str(error)) from error
    return contents


@contextmanager
def draft_beside(target: Path) -> Iterator[Path]:
    """An empty file that only this user may read, in the target's folder; it is removed at the end."""
    if target.exists():
        raise FileExistsError(target)
    draft = target.with_name(f".{target.name}.{os.getpid()}.draft")
    os.close(os.open(draft, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600))
    try:
        yield draft
    finally:
        draft.unlink(missing_ok=True)


def publish_new(draft: Path, target: Path) -> None:
    """Give a finished file its name for good. Raises FileExistsError if the name was taken meanwhile."""
    sync(draft)
    os.link(draft, target)
    sync(target.parent)


def sync(path: Path) -> None:
    """Write a file, or the names in a folder, to the disk."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _copy(database: Path, draft: Path) -> None:
    with opened(database, "mode=ro") as source, closing(sqlite3.connect(draft)) as copy:
        # All pages in one step are one snapshot, and readers of the log stop no writer. In several steps,
        # the copy would begin again after each commit of the server.
        source.backup(copy, pages=-1)
        # The mode is stored in the file. In WAL mode, SQLite would open a second file beside the backup.
        copy.execute("PRAGMA journal_mode=DELETE").fetchone()
