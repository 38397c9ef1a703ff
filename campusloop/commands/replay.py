"""`campusloop replay`: repeat recorded segments and compare them bit for bit."""

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import Progress

from contract.roads.load import MapError
from contract.runlog.reader import RunLogError
from vehicle_agent.config import ProfileError, load_profile
from vehicle_agent.runtime.replay import ReplayResult, replay_segment
from vehicle_agent.stacks.choice import build_car

console = Console()

EXIT_DIFFERENT = 1
EXIT_UNREADABLE = 2


def replay(
    runs: Annotated[list[Path], typer.Argument(help="Segments (.mcap) or folders with segments in them.")],
    profile: Annotated[
        Path | None,
        typer.Option(help="Replay with another vehicle profile, to see where the run first differs."),
    ] = None,
) -> None:
    """Replay recorded runs; exit 1 at the first difference (tick, room, field), 2 for a damaged log."""
    paths = segment_paths(runs)
    if not paths:
        console.print("[red]No segments (*.mcap) there.[/red] A run lies in VEHICLE/runs/BOOT/.")
        raise typer.Exit(EXIT_UNREADABLE)
    try:
        other = load_profile(profile) if profile is not None else None
    except ProfileError as error:
        console.print(f"[red]{error}[/red]")
        raise typer.Exit(EXIT_UNREADABLE) from error
    ticks = 0
    with Progress(console=console, transient=True) as progress:
        task = progress.add_task("replaying", total=len(paths))
        for path in paths:
            try:
                result = replay_segment(path, build_car, other)
            except (RunLogError, MapError) as error:
                console.print(f"[red]{path}: {error}[/red]", soft_wrap=True)
                raise typer.Exit(EXIT_UNREADABLE) from error
            ticks += result.ticks
            _print_result(path, result)
            progress.advance(task)
    console.print(f"{len(paths)} segments, {ticks} ticks: exactly as recorded")


def segment_paths(runs: list[Path]) -> list[Path]:
    """The given segments and those below the given folders, in order."""
    found: list[Path] = []
    for run in runs:
        found += sorted(run.rglob("*.mcap")) if run.is_dir() else [run]
    return found


def _print_result(path: Path, result: ReplayResult) -> None:
    if result.difference is not None:
        console.print(f"[red]{path} differs at {result.difference}[/red]", soft_wrap=True)
        raise typer.Exit(EXIT_DIFFERENT)
    if result.cut_short:
        console.print(
            f"[yellow]{result.cut_short}; the {result.ticks} ticks before it replay as recorded. "
            "A process killed while recording leaves such a file; use the server's copy[/yellow]",
            soft_wrap=True,
        )
