"""`campusloop workshop`: offline work on recorded sensor logs."""

from pathlib import Path
from typing import Annotated, NoReturn

import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TaskID, TextColumn, TimeRemainingColumn
from rich.table import Table

from campusloop.commands.calibrate import calibrate_lidars

app = typer.Typer(no_args_is_help=True)
console = Console(soft_wrap=True)

EXIT_BAD_INPUT = 2


app.command("calibrate")(calibrate_lidars)


@app.command("map")
def map_laser_log(
    laser: Annotated[Path, typer.Option(help="CARMEN log of a planar laser, plain, .gz or .bz2.")],
    out: Annotated[Path, typer.Option(help="Folder for map, drive, report and picture.")],
) -> None:
    """Build an occupancy map from a laser log, and say how well its parts agree."""
    from campusloop.kernels.compiling import ensure_kernels
    from campusloop.kernels.groups import WORKSHOP
    from workshop.carmen.laser_logs import read_laser_log
    from workshop.carmen.log_files import LogFileError
    from workshop.laser_mapping.map_folder import MAP, write_map_folder
    from workshop.laser_mapping.mapping import MappingParams, map_log
    from workshop.laser_mapping.occupancy import MapTooLarge

    if (out / MAP).exists():
        _refuse(f"{out} holds a map already; give another --out")
    try:
        log = read_laser_log(laser)
    except LogFileError as error:
        _refuse(str(error))
    for note in log.notes:
        console.print(f"[yellow]{note}[/yellow]", highlight=False)
    ensure_kernels(WORKSHOP)
    with _bars() as bars:
        try:
            laser_map = map_log(log, MappingParams(), _Bars(bars))
        except MapTooLarge as error:
            _refuse(f"{error} No map is made of it.")
    table = Table(title="residuals", title_justify="left")
    table.add_column("name")
    table.add_column("value", justify="right")
    for name in laser_map.residuals.__struct_fields__:
        table.add_row(name, f"{getattr(laser_map.residuals, name):.4g}")
    console.print(table)
    try:
        written = write_map_folder(out, laser_map, log, laser.name)
    except OSError as error:
        _refuse(f"{out} cannot be written: {error.strerror or error}")
    for path in written:
        console.print(f"written: {path}", highlight=False)


class _Bars:
    """Shows each stage as a bar."""

    def __init__(self, bars: Progress) -> None:
        self._bars = bars
        self._task: TaskID | None = None

    def begin(self, stage: str, steps: int) -> None:
        self._task = self._bars.add_task(stage, total=steps)

    def advance(self, steps: int) -> None:
        if self._task is not None:
            self._bars.advance(self._task, steps)


def _bars() -> Progress:
    return Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
        console=console,
    )


def _refuse(detail: str) -> NoReturn:
    console.print(f"[red]{detail}[/red]", highlight=False)
    raise typer.Exit(EXIT_BAD_INPUT)
