"""`campusloop scenario run`: drive scenario files with the whole onboard loop; exit 1 if one fails."""

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

from campusloop.kernels.compiling import ensure_kernels
from campusloop.kernels.groups import SIMULATOR, for_vehicle
from campusloop.scenes.scenario import Outcome, drive
from campusloop.scenes.scenario_file import ScenarioError, ScenarioFile, load_scenario
from campusloop.scenes.stacks import profile_of
from vehicle_agent.config import Profile, ProfileError, load_profile
from vehicle_agent.runtime.replay import replay_segment
from vehicle_agent.stacks.choice import build_car

app = typer.Typer(no_args_is_help=True)
console = Console()

EXIT_FAILED = 1
EXIT_BAD_INPUT = 2


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
) -> None:
    """Drive scenarios and check their expectations. With --out, every run is also replayed bit for bit."""
    try:
        paths = scenario_paths(files)
        found = [(path, load_scenario(path)) for path in paths]
        profiles = {name: _profile(name, profile_path) for name in stack.split(",")}
    except (ScenarioError, ProfileError) as error:
        console.print(f"[red]{error}[/red]", soft_wrap=True, highlight=False)
        raise typer.Exit(EXIT_BAD_INPUT) from error
    ensure_kernels((*SIMULATOR, *sorted({group for name in profiles for group in for_vehicle(name)})))
    table = Table(title="Scenarios", title_justify="left")
    for heading in ("scenario", "stack", "time s", "contacts", "clearance m", "result"):
        table.add_column(heading, overflow="fold")
    failed = 0
    for name, profile in profiles.items():
        for path, scenario in found:
            if scenario.stacks and name not in scenario.stacks:
                continue
            try:
                failures, outcome = _drive_and_replay(path, scenario, name, profile, out)
            except ScenarioError as error:
                console.print(f"[red]{path}: {error}[/red]", soft_wrap=True, highlight=False)
                raise typer.Exit(EXIT_BAD_INPUT) from error
            failed += bool(failures)
            table.add_row(path.stem, name, *_figures(outcome), "; ".join(failures) or "passed")
            console.print(f"{name} {path.stem}: {'; '.join(failures) or 'passed'}", highlight=False)
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


def _drive_and_replay(
    path: Path, scenario: ScenarioFile, stack: str, profile: Profile, out: Path | None
) -> tuple[tuple[str, ...], Outcome]:
    """(failures, outcome); a replay that differs is a failure too."""
    folder = None if out is None else out / stack / path.stem
    if folder is not None and folder.exists():
        raise ScenarioError(f"{folder} is there already; give another --out")
    runs = None if folder is None else folder / "runs"
    outcome = drive(scenario, path.stem, profile, path.parent, runs)
    if folder is None or runs is None:
        return outcome.failures, outcome
    outcome.run.trace.write(folder, path.stem)
    failures = list(outcome.failures)
    for segment in sorted(runs.rglob("*.mcap")):
        result = replay_segment(segment, build_car)
        if result.difference is not None or result.cut_short:
            failures.append(f"replay: {result.difference or result.cut_short}")
    return tuple(failures), outcome


def _figures(outcome: Outcome) -> tuple[str, str, str]:
    run, metrics = outcome.run, outcome.run.metrics
    time = "-" if run.time_s is None else f"{run.time_s:.1f}"
    clearance = "-" if metrics.clearance_m == float("inf") else f"{metrics.clearance_m:.2f}"
    return time, f"{len(metrics.front_contacts)} + {len(metrics.other_contacts)}", clearance


def _profile(stack: str, path: Path | None) -> Profile:
    return profile_of(stack) if path is None else load_profile(path)
