"""`campusloop restore`: a backup takes the place of the database."""

import os
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from sqlalchemy import URL

from campusloop.commands.operations.output import print_contents, refuse
from campusloop.operations.database_choice import NoSuchDatabase, chosen_database
from server.settings import SettingsError
from server.store.backups.postgresql import RestoredDump, restore_dump
from server.store.backups.restore import Restored, RestoreRefused
from server.store.backups.restore import restore as put_back


def restore(
    backup: Annotated[Path, typer.Option("--from", help="A file made by `campusloop backup`.")],
    database: Annotated[
        str | None, typer.Option(help="URL of the database; default: as in CAMPUSLOOP_*.")
    ] = None,
    replace: Annotated[bool, typer.Option("--replace", help="Keep the present database beside it.")] = False,
) -> None:
    """Put a verified backup in the place of the database. The servers must be stopped."""
    console = Console(soft_wrap=True, highlight=False)
    try:
        target = chosen_database(os.environ, database)
        now = datetime.now(UTC)
        restored: Restored | RestoredDump
        if isinstance(target, Path):
            restored = put_back(backup, target, now, replace=replace)
        else:
            restored = restore_dump(backup, target, _kept(backup, target, now), replace=replace)
    except (NoSuchDatabase, SettingsError, RestoreRefused) as error:
        refuse(console, str(error))
    shown = target if isinstance(target, Path) else target.render_as_string(hide_password=True)
    console.print(f"{shown} is restored from {backup}", markup=False)
    print_contents(console, restored.contents)
    if restored.kept is not None:
        console.print(f"the database that was there before is {restored.kept}", markup=False)
    if not restored.contents.is_current:
        console.print("its tables are those of an earlier version; the server migrates them when it starts")


def _kept(backup: Path, url: URL, now: datetime) -> Path:
    """Where the present content of a PostgreSQL database goes: beside the backup."""
    return backup.with_name(f"{url.database}.before-{now:%Y%m%dT%H%M%SZ}.dump")
