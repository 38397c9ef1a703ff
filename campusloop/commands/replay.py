"""`campusloop replay`: repeat recorded segments and compare them bit for bit."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.markup import escape
from rich.progress import Progress

from campusloop.campaigns.campaign import CampaignError
from campusloop.campaigns.choice import open_campaign
from contract.roads.load import MapError
from contract.runlog.reader import RunLogError
from vehicle_agent.config import Profile, ProfileError, load_profile
from vehicle_agent.runtime.replay import ReplayResult, replay_segment
from vehicle_agent.stacks.choice import build_car

console = Console()

EXIT_DIFFERENT = 1
EXIT_UNREADABLE = 2


@dataclass(frozen=True, slots=True)
class SegmentReplay:
    """One segment to replay. profile: another one than the recorded; None: the recorded one."""

    path: Path
    profile: Profile | None


def replay(
    runs: Annotated[list[Path], typer.Argument(help="Segments (.mcap) or folders with segments in them.")],
    profile: Annotated[
        Path | None,
        typer.Option(help="Replay with another vehicle profile, to see where the run first differs."),
    ] = None,
    workers: Annotated[int, typer.Option(min=0, help="Processes; 0: one for each core.")] = 1,
    cluster: Annotated[
        str | None,
        typer.Option(
            help="Dask scheduler (tcp://HOST:8786) whose workers replay; they read the same folders."
        ),
    ] = None,
) -> None:
    """Replay recorded runs; exit 1 at the first difference (tick, room, field), 2 for a damaged log."""
    paths = segment_paths(runs)
    if not paths:
        console.print("[red]No segments (*.mcap) there.[/red] A run lies in VEHICLE/runs/BOOT/.")
        raise typer.Exit(EXIT_UNREADABLE)
    ticks = 0
    try:
        other = load_profile(profile) if profile is not None else None
        jobs = [SegmentReplay(path.absolute(), other) for path in paths]
        with Progress(console=console, transient=True) as progress:
            task = progress.add_task("replaying", total=len(paths))
            for path, result in zip(paths, _results(jobs, workers, cluster), strict=True):
                if isinstance(result, str):
                    console.print(f"[red]{escape(f'{path}: {result}')}[/red]", soft_wrap=True)
                    raise typer.Exit(EXIT_UNREADABLE)
                ticks += result.ticks
                _print_result(path, result)
                progress.advance(task)
    except (ProfileError, CampaignError) as error:
        console.print(f"[red]{escape(str(error))}[/red]", soft_wrap=True)
        raise typer.Exit(EXIT_UNREADABLE) from error
    console.print(f"{len(paths)} segments, {ticks} ticks: exactly as recorded")


def replay_or_reason(job: SegmentReplay) -> ReplayResult | str:
    """The result, or why the segment cannot be replayed."""
    try:
        return replay_segment(job.path, build_car, job.profile)
    except (RunLogError, MapError) as error:
        return str(error)


def _results(jobs: list[SegmentReplay], workers: int, cluster: str | None) -> Iterator[ReplayResult | str]:
    if cluster is None and (workers == 1 or len(jobs) == 1):
        yield from map(replay_or_reason, jobs)
        return
    with open_campaign(cluster, workers) as campaign:
        yield from campaign.run(replay_or_reason, jobs)


def segment_paths(runs: list[Path]) -> list[Path]:
    """The given segments and those below the given folders, in order."""
    found: list[Path] = []
    for run in runs:
        found += sorted(run.rglob("*.mcap")) if run.is_dir() else [run]
    return found


def _print_result(path: Path, result: ReplayResult) -> None:
    if result.difference is not None:
        console.print(f"[red]{escape(f'{path} differs at {result.difference}')}[/red]", soft_wrap=True)
        raise typer.Exit(EXIT_DIFFERENT)
    if result.cut_short:
        console.print(
            f"[yellow]{result.cut_short}; the {result.ticks} ticks before it replay as recorded. "
            "A process killed while recording leaves such a file; use the server's copy[/yellow]",
            soft_wrap=True,
        )
