"""`campusloop scenario run`: drive scenario files with the whole onboard loop; exit 1 if one fails."""

import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from campusloop.campaigns.campaign import CampaignError
from campusloop.campaigns.choice import open_campaign
from campusloop.kernels.compiling import ensure_kernels
from campusloop.kernels.groups import SIMULATOR, for_vehicle
from campusloop.scenes.scenario_files.scenario import Outcome, drive
from campusloop.scenes.scenario_files.scenario_file import ScenarioError, ScenarioFile, load_scenario
from campusloop.scenes.stacks import profile_of
from vehicle_agent.config import Profile, ProfileError, load_profile
from vehicle_agent.runtime.replay import replay_segment
from vehicle_agent.stacks.choice import build_car

app = typer.Typer(no_args_is_help=True)
console = Console()

EXIT_FAILED = 1
EXIT_BAD_INPUT = 2


@dataclass(frozen=True, slots=True)
class ScenarioRun:
    """One drive. out: folder for traces and run logs of all drives; None for none.

    plant_seed: of the shuttles' dynamics; None: nominal ones
    """

    path: Path
    scenario: ScenarioFile
    stack: str
    profile: Profile
    out: Path | None
    plant_seed: int | None = None

    @property
    def folder(self) -> Path | None:
        return None if self.out is None else self.out / self.stack / self.path.stem


@app.callback()
def _group() -> None:
    """Scenarios from small files."""


@app.command()
def run(
    files: Annotated[list[Path], typer.Argument(help="Scenario files (.toml), or folders of them.")],
    stack: Annotated[str, typer.Option(help="snow_lion, gem or nus; several with commas.")] = "snow_lion",
    out: Annotated[Path | None, typer.Option(help="Folder for traces (CSV) and run logs (MCAP).")] = None,
    profile_path: Annotated[
        Path | None, typer.Option("--profile", help="Vehicle profile (TOML); the stack's own without it.")
    ] = None,
    plant_seed: Annotated[
        int | None, typer.Option(help="Of the shuttles' dynamics; nominal ones without it.")
    ] = None,
    workers: Annotated[int, typer.Option(min=0, help="Processes; 0: one for each core.")] = 1,
    cluster: Annotated[
        str | None, typer.Option(help="Dask scheduler (tcp://HOST:8786) whose workers drive.")
    ] = None,
) -> None:
    """Drive scenarios and check their expectations. With --out, every run is also replayed bit for bit."""
    try:
        paths = scenario_paths(files)
        found = [(path, load_scenario(path)) for path in paths]
        profiles = {name: _profile(name, profile_path) for name in stack.split(",")}
    except (ScenarioError, ProfileError) as error:
        console.print(f"[red]{escape(str(error))}[/red]", soft_wrap=True, highlight=False)
        raise typer.Exit(EXIT_BAD_INPUT) from error
    ensure_kernels((*SIMULATOR, *sorted({group for name in profiles for group in for_vehicle(name)})))
    jobs = [
        ScenarioRun(
            path.absolute(),
            scenario,
            name,
            profiles[name],
            None if out is None else out.absolute(),
            plant_seed,
        )
        for name in profiles
        for path, scenario in found
        if not scenario.stacks or name in scenario.stacks
    ]
    table = Table(title="Scenarios", title_justify="left")
    for heading in ("scenario", "stack", "time s", "contacts", "clearance m", "result"):
        table.add_column(heading, overflow="fold")
    failed = 0
    try:
        _refuse_present_folders(jobs)
        for job, (failures, figures) in zip(jobs, _results(jobs, workers, cluster), strict=True):
            failed += bool(failures)
            table.add_row(job.path.stem, job.stack, *figures, "; ".join(failures) or "passed")
            console.print(f"{job.stack} {job.path.stem}: {'; '.join(failures) or 'passed'}", highlight=False)
    except (ScenarioError, CampaignError, OSError) as error:
        console.print(f"[red]{escape(str(error))}[/red]", soft_wrap=True, highlight=False)
        raise typer.Exit(EXIT_BAD_INPUT) from error
    console.print(table)
    if failed:
        raise typer.Exit(EXIT_FAILED)


def scenario_paths(files: list[Path]) -> list[Path]:
    """The given files and those below the given folders, in order. ScenarioError for a folder without any."""
    out: list[Path] = []
    for file in files:
        inside = sorted(file.rglob("*.toml")) if file.is_dir() else [file]
        if not inside:
            raise ScenarioError(f"{file}: no scenario files (*.toml) there")
        out += inside
    return out


def drive_and_replay(job: ScenarioRun) -> tuple[tuple[str, ...], tuple[str, str, str]]:
    """(failures, figures); a replay that differs is a failure too. Raises ScenarioError."""
    folder = job.folder
    try:
        if folder is None:
            outcome = drive(job.scenario, job.path.stem, job.profile, job.path.parent, None, job.plant_seed)
            return outcome.failures, _figures(outcome)
        # What is there now was left by a worker that was lost.
        shutil.rmtree(folder, ignore_errors=True)
        runs = folder / "runs"
        outcome = drive(job.scenario, job.path.stem, job.profile, job.path.parent, runs, job.plant_seed)
    except ScenarioError as error:
        raise ScenarioError(f"{job.path}: {error}") from error
    outcome.run.trace.write(folder, job.path.stem)
    failures = list(outcome.failures)
    for segment in sorted(runs.rglob("*.mcap")):
        result = replay_segment(segment, build_car)
        if result.difference is not None or result.cut_short:
            failures.append(f"replay: {result.difference or result.cut_short}")
    return tuple(failures), _figures(outcome)


def _results(
    jobs: list[ScenarioRun], workers: int, cluster: str | None
) -> Iterator[tuple[tuple[str, ...], tuple[str, str, str]]]:
    if cluster is None and (workers == 1 or len(jobs) == 1):
        yield from map(drive_and_replay, jobs)
        return
    files = sorted({job.path for job in jobs} | {path for job in jobs for path in _named_files(job)})
    with open_campaign(cluster, workers, files=files) as campaign:
        yield from campaign.run(drive_and_replay, jobs)


def _named_files(job: ScenarioRun) -> list[Path]:
    road_map = job.scenario.road.map
    return [(job.path.parent / road_map).resolve()] if road_map else []


def _refuse_present_folders(jobs: list[ScenarioRun]) -> None:
    for job in jobs:
        if job.folder is not None and job.folder.exists():
            raise ScenarioError(f"{job.path}: {job.folder} is there already; give another --out")


def _figures(outcome: Outcome) -> tuple[str, str, str]:
    run, metrics = outcome.run, outcome.run.metrics
    time = "-" if run.time_s is None else f"{run.time_s:.1f}"
    clearance = "-" if metrics.clearance_m == float("inf") else f"{metrics.clearance_m:.2f}"
    return time, f"{len(metrics.front_contacts)} + {len(metrics.other_contacts)}", clearance


def _profile(stack: str, path: Path | None) -> Profile:
    return profile_of(stack) if path is None else load_profile(path)
