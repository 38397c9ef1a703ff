"""Putting a backup in the place of an SQLite database. Nothing is touched before the backup is verified."""

import os
import shutil
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from server.store.backups.backup import sync
from server.store.backups.contents import BadDatabaseFile, DatabaseContents, backup_contents
from server.store.database_file import DatabaseFile, DatabaseInUse

# What SQLite keeps beside a database. It would apply either file to any database of that name.
_LOGS = ("-wal", "-journal")


class RestoreRefused(Exception):
    """The database is as it was; the text says why and what to do."""


@dataclass(frozen=True, slots=True)
class Restored:
    """kept: where the database is that was there before."""

    contents: DatabaseContents
    kept: Path | None


def restore(backup: Path, database: Path, now: datetime, *, replace: bool) -> Restored:
    """Put a copy of `backup` in the place of `database` and keep the old one beside it.

    Raises RestoreRefused.
    """
    database = database.resolve()
    try:
        backup_contents(backup)
        if database.exists() and backup.samefile(database):
            raise RestoreRefused(f"{backup} is the database itself")
        database.parent.mkdir(parents=True, exist_ok=True)
        _refuse_other_user(database)
        file = DatabaseFile(database)
        file.lock()
        try:
            return _put(backup, database, now, replace)
        finally:
            file.close()
    except DatabaseInUse as error:
        raise RestoreRefused(
            f"a server uses {database} (process {error.holder}); stop it, restore, and start it again"
        ) from error
    except (BadDatabaseFile, OSError) as error:
        raise RestoreRefused(str(error)) from error


def _put(backup: Path, database: Path, now: datetime, replace: bool) -> Restored:
    if database.exists() and not replace:
        raise RestoreRefused(
            f"{database} exists; with --replace it is kept under another name and the backup takes its place"
        )
    draft = database.with_name(f".{database.name}.{os.getpid()}.draft")
    try:
        os.close(os.open(draft, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600))
        shutil.copyfile(backup, draft)
        # What is put into place is what has been verified, also if the backup changed meanwhile.
        contents = backup_contents(draft)
        sync(draft)
        kept = _keep(database, now)
        draft.replace(database)
        sync(database.parent)
    finally:
        draft.unlink(missing_ok=True)
    return Restored(contents, kept)


def _keep(database: Path, now: datetime) -> Path | None:
    """Give the present database and its log a second name, then take the log's first one away."""
    kept = database.with_name(f"{database.name}.before-{now.astimezone(UTC):%Y%m%dT%H%M%SZ}")
    had_database = database.exists()
    for side in ("", *_LOGS):
        present = database.with_name(f"{database.name}{side}")
        if present.exists():
            os.link(present, kept.with_name(f"{kept.name}{side}"))
    sync(database.parent)
    for side in (*_LOGS, "-shm"):
        database.with_name(f"{database.name}{side}").unlink(missing_ok=True)
    return kept if had_database else None


def _refuse_other_user(database: Path) -> None:
    """Files that root makes in another user's folder could not be opened by the server."""
    owner = database.parent.stat().st_uid
    if os.geteuid() == 0 and owner != 0:
        raise RestoreRefused(
            f"{database.parent} belongs to user {owner}, and the server could not open a file of root; "
            "run this command as that user (sudo -u)"
        )
