"""`campusloop workshop propose`: a point map of vehicles' parcels of scans, beside the map in force.

With `--for-server` the server runs it as a child process. Each line of its output is then a JSON object, and
it ends when its standard input does, so that it never outlives the server.
"""

import json
import os
import shutil
import sys
import tempfile
import threading
from pathlib import Path
from typing import Annotated, NoReturn

import typer
from rich.console import Console
from rich.markup import escape

from campusloop.commands.workshop.bars import StageBars, stage_bars

console = Console(soft_wrap=True)

EXIT_BAD_INPUT, EXIT_NOT_WRITTEN = 2, 3


class _Lines:
    """Tells the stages to the process that reads the output: a line for each percent, not for each step."""

    def __init__(self) -> None:
        self._stage, self._steps, self._done, self._told = "", 1, 0, -1

    def begin(self, stage: str, steps: int) -> None:
        self._stage, self._steps, self._done, self._told = stage, max(1, steps), 0, -1
        self._tell()

    def advance(self, steps: int) -> None:
        self._done += steps
        self._tell()

    def _tell(self) -> None:
        percent = min(100, 100 * self._done // self._steps)
        if percent != self._told:
            self._told = percent
            tell({"stage": self._stage, "percent": percent})


def tell(line: dict[str, object]) -> None:
    sys.stdout.write(json.dumps(line) + "\n")
    sys.stdout.flush()


def propose_map(
    parcels: Annotated[Path, typer.Option(help="Folder of parcels of scans (*.zip).")],
    out: Annotated[Path, typer.Option(help="New folder for the proposed map, its figures and its picture.")],
    in_force: Annotated[
        Path | None, typer.Option(help="The point map in force; without it nothing is compared.")
    ] = None,
    for_server: Annotated[bool, typer.Option("--for-server", hidden=True)] = False,
) -> None:
    """Make a point map of scans that vehicles kept, and say what it changes of the map in force."""
    if for_server:
        threading.Thread(target=_end_with_input, name="server's end", daemon=True).start()
        if hasattr(os, "nice"):
            os.nice(15)
    if out.exists():
        _refuse(f"{out} exists already; give another --out", EXIT_BAD_INPUT, for_server)
    from campusloop.kernels.compiling import ensure_kernels
    from campusloop.kernels.groups import CLOUD_MAPPING
    from contract.localization_maps import LocalizationMapError
    from workshop.scan_maps.drives import NoMapOfScans
    from workshop.scan_maps.proposal import ProposalParams, propose

    if not for_server:
        ensure_kernels(CLOUD_MAPPING)
    out.parent.mkdir(parents=True, exist_ok=True)
    work = Path(tempfile.mkdtemp(prefix=".scans-", dir=out.parent))
    try:
        found = sorted(parcels.glob("*.zip"))
        if for_server:
            comparison = propose(found, in_force, out, work, ProposalParams(), _Lines())
        else:
            with stage_bars(console) as bars:
                comparison = propose(found, in_force, out, work, ProposalParams(), StageBars(bars))
    except (NoMapOfScans, LocalizationMapError) as error:
        _refuse(str(error), EXIT_BAD_INPUT, for_server)
    except OSError as error:
        reason = f"{out} cannot be written: {error.strerror or error}. Nothing was left there."
        _refuse(reason, EXIT_NOT_WRITTEN, for_server)
    finally:
        shutil.rmtree(work, ignore_errors=True)
    if for_server:
        tell({"done": comparison.map_version})
        return
    for note in comparison.notes:
        console.print(f"[yellow]{note}[/yellow]", highlight=False)
    changed = [tile for tile in comparison.tiles if tile.is_changed]
    console.print(
        f"{len(changed)} of {len(comparison.tiles)} tiles changed"
        + "".join(f", {tile.ix}_{tile.iy} by {100 * tile.changed_ratio:.0f} %" for tile in changed),
        highlight=False,
    )
    console.print(f"written: {out}", highlight=False)


def _refuse(detail: str, code: int, for_server: bool) -> NoReturn:
    if for_server:
        tell({"refused": detail})
    else:
        console.print(f"[red]{escape(detail)}[/red]", highlight=False)
    raise typer.Exit(code)


def _end_with_input() -> None:
    """The server holds the other end; the pipe breaks with it, however it ends."""
    while os.read(0, 1024):
        pass
    os._exit(1)
