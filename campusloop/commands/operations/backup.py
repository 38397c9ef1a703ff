"""`campusloop backup`: a verified copy of the database, while the server runs."""

import os
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from campusloop.commands.operations.output import print_contents, refuse
from campusloop.operations.database_choice import NoSuchDatabase, chosen_database
from server.settings import SettingsError
from server.store.backups.backup import BackupRefused, back_up
from server.store.backups.postgresql import dump


def backup(
    to: Annotated[Path, typer.Option("--to", help="New file for the backup; its folder must exist.")],
    database: Annotated[
        str | None, typer.Option(help="URL of the database; default: as in CAMPUSLOOP_*.")
    ] = None,
) -> None:
    """Copy the database while the server runs, and verify the copy."""
    console = Console(soft_wrap=True, highlight=False)
    try:
        source = chosen_database(os.environ, database)
        contents = back_up(source, to) if isinstance(source, Path) else dump(source, to)
    except (NoSuchDatabase, SettingsError, BackupRefused) as error:
        refuse(console, str(error))
    shown = source if isinstance(source, Path) else source.render_as_string(hide_password=True)
    console.print(f"{to} is a verified backup of {shown}", markup=False)
    print_contents(console, contents)
