"""`campusloop demo`: a campus on this machine, live or in virtual time."""

import asyncio
import os
import tempfile
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from campusloop.commands.serve import DEFAULT_MAP
from campusloop.headless import run_headless
from campusloop.live_campus import CampusStartError, LiveOptions
from campusloop.live_demo import LiveDemo
from campusloop.virtual_campus import CampusOptions
from contract.roads.load import MapError, load_map

EXIT_FAILED = 1
EXIT_BAD_INPUT = 2


def demo(
    headless: Annotated[bool, typer.Option("--headless", help="Virtual time, as fast as possible.")] = False,
    rides: Annotated[int, typer.Option(min=1, help="How many rides (headless).")] = 6,
    seed: Annotated[int, typer.Option(help="Of people, noise and bookings.")] = 1,
    vehicles: Annotated[int, typer.Option(min=0, help="0: three, or two on two cores.")] = 0,
    host: Annotated[str, typer.Option(help="0.0.0.0 serves phones on the LAN, with TLS.")] = "127.0.0.1",
    port: Annotated[int, typer.Option(help="TCP port of the pages.")] = 8080,
    tls_cert: Annotated[Path | None, typer.Option(help="PEM certificate chain.")] = None,
    tls_key: Annotated[Path | None, typer.Option(help="PEM private key.")] = None,
    campus_map: Annotated[Path, typer.Option("--map", help="Campus map.")] = DEFAULT_MAP,
    folder: Annotated[Path, typer.Option(help="Where runs, logs and the database go.")] = Path("var/demo"),
    people: Annotated[bool, typer.Option(help="Simulated passengers book rides.")] = True,
) -> None:
    """Run a campus: book at the printed address, watch at /console."""
    console = Console()
    count = vehicles or (2 if (os.cpu_count() or 1) <= 2 else 3)
    try:
        if headless:
            _headless(console, campus_map, count, rides, seed)
            return
        options = LiveOptions(campus_map, folder, count, host, port, tls_cert, tls_key, seed)
        asyncio.run(LiveDemo(options, console, people_book=people).run())
    except (MapError, CampusStartError) as error:
        console.print(f"[red]{error}[/red]", soft_wrap=True, highlight=False)
        raise typer.Exit(EXIT_BAD_INPUT) from error


def _headless(console: Console, campus_map: Path, vehicles: int, rides: int, seed: int) -> None:
    with tempfile.TemporaryDirectory(prefix="campusloop-demo-") as folder:
        options = CampusOptions(load_map(campus_map), Path(folder), seed, vehicles)
        result = run_headless(options, rides, console)
    for failure in result.failures:
        console.print(f"[red]{failure}[/red]", soft_wrap=True, highlight=False)
    if result.failures:
        raise typer.Exit(EXIT_FAILED)
    console.print(f"all {rides} rides completed, every run replays exactly")
