"""`campusloop backup`: a verified copy of the database, while the server runs."""

import os
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from campusloop.commands.operations.output import print_rows, refuse
from campusloop.operations.database_choice import NoDatabaseFile, chosen_database
from server.settings import SettingsError
from server.store.backups.backup import BackupRefused, back_up

ON_POSTGRESQL = (
    "install its client programs (Debian: postgresql-client) and run "
    "`pg_dump --format=custom --file=FILE URL`"
)


def backup(
    to: Annotated[Path, typer.Option("--to", help="New file for the backup; its folder must exist.")],
    database: Annotated[
        str | None, typer.Option(help="URL of the database; default: as in CAMPUSLOOP_*.")
    ] = None,
) -> None:
    """Copy the database while the server runs, and verify the copy."""
    console = Console(soft_wrap=True, highlight=False)
    try:
        source = chosen_database(os.environ, database, ON_POSTGRESQL)
        contents = back_up(source, to)
    except (NoDatabaseFile, SettingsError, BackupRefused) as error:
        refuse(console, str(error))
    console.print(f"{to} is a verified backup of {source}", markup=False)
    print_rows(console, contents)
