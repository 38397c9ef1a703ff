"""What the commands of operations print."""

from typing import NoReturn

import typer
from rich.console import Console

from server.store.backups.contents import DatabaseContents
from server.store.backups.postgresql import DumpContents

EXIT_REFUSED = 2


def print_contents(console: Console, contents: DatabaseContents | DumpContents) -> None:
    console.print(f"{contents.size_bytes} bytes, revision {contents.revision}")
    if isinstance(contents, DatabaseContents):
        console.print("rows: " + ", ".join(f"{name} {count}" for name, count in contents.rows.items()))


def refuse(console: Console, text: str) -> NoReturn:
    console.print(text, style="red", markup=False)
    raise typer.Exit(EXIT_REFUSED)
