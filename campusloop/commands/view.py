"""`campusloop view`: run logs in the web viewer."""

import asyncio
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.markup import escape

from campusloop.clients.operator_client import OperatorError
from campusloop.live.run_viewer import RunViewError, runs_in
from campusloop.live.run_viewer import view as view_runs
from server.live_ports import CannotStart

EXIT_BAD_INPUT = 2

console = Console(highlight=False, soft_wrap=True)


def view(
    logs: Annotated[list[Path], typer.Argument(help="Run logs (.mcap), or folders of them.")],
    port: Annotated[int, typer.Option(help="TCP port of the viewer, on this machine only.")] = 8080,
) -> None:
    """Replay run logs in the browser: of scenarios, benchmarks, demos, or from a vehicle's disk."""
    try:
        asyncio.run(view_runs(runs_in(tuple(logs)), port, console.print))
    except (RunViewError, CannotStart, OperatorError) as error:
        console.print(f"[red]{escape(str(error))}[/red]")
        raise typer.Exit(EXIT_BAD_INPUT) from error
