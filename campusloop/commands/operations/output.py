"""What the commands of operations print."""

from typing import NoReturn

import typer
from rich.console import Console

from server.store.backups.contents import DatabaseContents

EXIT_REFUSED = 2


def print_rows(console: Console, contents: DatabaseContents) -> None:
    rows = ", ".join(f"{name} {count}" for name, count in contents.rows.items())
    console.print(f"{contents.size_bytes} bytes, revision {contents.revision}; rows: {rows}")


def refuse(console: Console, text: str) -> NoReturn:
    console.print(text, style="red", markup=False)
    raise typer.Exit(EXIT_REFUSED)
