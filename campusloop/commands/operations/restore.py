"""`campusloop restore`: a backup takes the place of the database."""

import os
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from campusloop.commands.operations.output import print_contents, refuse
from campusloop.operations.database_choice import NoSuchDatabase, chosen_database
from server.settings import SettingsError
from server.store.backups.restore import RestoreRefused
from server.store.backups.restore import restore as put_back

ON_POSTGRESQL = (
    "stop the servers and run "
    "`pg_restore --clean --if-exists --single-transaction --no-owner --dbname=URL FILE`"
)


def restore(
    backup: Annotated[Path, typer.Option("--from", help="A file made by `campusloop backup`.")],
    database: Annotated[
        str | None, typer.Option(help="URL of the database; default: as in CAMPUSLOOP_*.")
    ] = None,
    replace: Annotated[bool, typer.Option("--replace", help="Keep the present database beside it.")] = False,
) -> None:
    """Put a verified backup in the place of the database. The server must be stopped."""
    console = Console(soft_wrap=True, highlight=False)
    try:
        target = chosen_database(os.environ, database)
        if not isinstance(target, Path):
            refuse(console, f"PostgreSQL has a program for this: {ON_POSTGRESQL}")
        restored = put_back(backup, target, datetime.now(UTC), replace=replace)
    except (NoSuchDatabase, SettingsError, RestoreRefused) as error:
        refuse(console, str(error))
    console.print(f"{target} is restored from {backup}", markup=False)
    print_contents(console, restored.contents)
    if restored.kept is not None:
        console.print(f"the database that was there before is {restored.kept}", markup=False)
    if not restored.contents.is_current:
        console.print("its tables are those of an earlier version; the server migrates them when it starts")
