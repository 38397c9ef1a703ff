"""`campusloop audit verify`: is the audit log of a database whole?"""

import os
import re
from typing import Annotated

import typer
from rich.console import Console
from sqlalchemy.exc import SQLAlchemyError

from campusloop.commands.operations.output import refuse
from campusloop.operations.audit_log import audit_findings
from server.domain.record.audit import Head
from server.settings import SettingsError, settings_from
from server.store.engine import DatabaseUnsupported, open_engine

EXIT_BROKEN = 1
_HEAD = re.compile(r"(\d{1,18}):([0-9a-f]{64})")

app = typer.Typer(no_args_is_help=True)
# Without a callback, an app of one command would treat that command's name as an argument.
app.callback()(lambda: None)


@app.command("verify")
def verify(
    database: Annotated[
        str | None, typer.Option(help="URL of the database; default: as in CAMPUSLOOP_*.")
    ] = None,
    head: Annotated[
        str | None,
        typer.Option(help="NUMBER:SHA256 of `audit.head` in the server's log: shows if entries are cut off."),
    ] = None,
) -> None:
    """Follow the chain of hashes, and say where it is broken. It needs no server."""
    console = Console(soft_wrap=True, highlight=False)
    try:
        url = settings_from(os.environ, database_url=database).database()
        findings = audit_findings(open_engine(url), None if head is None else _head(console, head))
    except (SettingsError, DatabaseUnsupported) as error:
        refuse(console, str(error))
    except SQLAlchemyError as error:
        refuse(console, f"the database cannot be read: {str(error).splitlines()[0]}")
    if not findings:
        console.print("the audit log is empty")
        raise typer.Exit(EXIT_BROKEN if head else 0)
    for found in findings:
        if found.broken is None:
            end = f"{found.head.number}:{found.head.sha256}"
            console.print(f"{found.campus_id}: {found.head.number} entries follow one another; head {end}")
        else:
            where = f"{found.campus_id}: broken at entry {found.broken.number}: {found.broken.what}"
            console.print(where, style="red", markup=False)
    if any(found.broken for found in findings):
        raise typer.Exit(EXIT_BROKEN)


def _head(console: Console, text: str) -> Head:
    matched = _HEAD.fullmatch(text)
    if matched is None:
        refuse(console, "a head is NUMBER:SHA256, as the server's log has it in audit.head")
    return Head(int(matched[1]), matched[2])
