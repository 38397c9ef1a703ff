"""`campusloop vehicle`: what a vehicle answers to its commands, from a recorded drive."""

import math
from pathlib import Path
from typing import Annotated, NoReturn

import typer
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from campusloop.commands.replay import segment_paths
from contract.runlog.reader import RunLogError
from vehicle_agent.config import ProfileError, load_profile, profile_toml
from vehicle_agent.identification.drive_signals import IdentificationError
from vehicle_agent.identification.identify import Identification, identify
from vehicle_agent.identification.recorded_drive import recorded_drive

app = typer.Typer(no_args_is_help=True)
console = Console()

EXIT_BAD_INPUT = 2


@app.command("identify")
def identify_run(
    runs: Annotated[list[Path], typer.Argument(help="Segments (.mcap) or folders of one drive, in order.")],
    out: Annotated[Path, typer.Option(help="The profile to write (TOML); never overwritten.")] = Path(
        "identified.toml"
    ),
    profile: Annotated[
        Path | None, typer.Option(help="Profile to begin with; the one that the run recorded without it.")
    ] = None,
    plots: Annotated[Path | None, typer.Option(help="Folder for plots (PNG).")] = None,
) -> None:
    """Fit pedal maps, dead times, steering bias and wheelbase to a drive, and write the vehicle's profile."""
    paths = segment_paths(runs)
    if not paths:
        _refuse("No segments (*.mcap) there. A run lies in VEHICLE/runs/BOOT/.")
    if out.exists():
        _refuse(f"{out} exists; give another --out")
    try:
        drive, recorded = recorded_drive(paths)
        found = identify(drive, recorded if profile is None else load_profile(profile))
    except (RunLogError, ProfileError) as error:
        _refuse(str(error))
    except IdentificationError as error:
        _refuse(f"{error.code}: {error}")
    _print_values(found)
    out.write_text(profile_toml(found.profile), encoding="utf-8")
    written = [out]
    if plots is not None:
        # matplotlib takes a second to import.
        from campusloop.studies.identification.plots import write_plots

        written += write_plots(found, plots)
    for path in written:
        console.print(f"written: {path}", soft_wrap=True, highlight=False)


@app.command("drive")
def drive_for_identification(
    out: Annotated[Path, typer.Option(help="Folder for the run log.")] = Path("var/identification"),
    profile: Annotated[
        Path | None, typer.Option(help="Vehicle profile (TOML); the campus shuttle without it.")
    ] = None,
    plant_seed: Annotated[
        int | None, typer.Option(help="Of the vehicle's true dynamics; nominal ones without it.")
    ] = None,
    seed: Annotated[int, typer.Option(help="Of sensor noise.")] = 1,
    duration_s: Annotated[float, typer.Option(min=10.0, max=900.0, help="Of the drive.")] = 300.0,
) -> None:
    """Drive the identification drive in the simulator, and record it as a vehicle would."""
    from campusloop.kernels.compiling import ensure_kernels
    from campusloop.kernels.groups import SIMULATOR, for_vehicle
    from campusloop.scenes.drive import SceneDrive
    from campusloop.studies.identification.identification_drive import identification_scene
    from vehicle_agent.config import Profile

    if out.exists() and any(out.rglob("*.mcap")):
        _refuse(f"{out} holds run logs already; give another --out")
    try:
        chosen = Profile() if profile is None else load_profile(profile)
    except ProfileError as error:
        _refuse(str(error))
    ensure_kernels((*SIMULATOR, *for_vehicle(chosen.stack)))
    run = SceneDrive(identification_scene(chosen, seed, plant_seed, duration_s), out).run()
    console.print(f"{run.driven_m:.0f} m driven; recorded in {out}", highlight=False)


def _print_values(found: Identification) -> None:
    table = Table()
    for heading in ("value", "identified", "standard deviation", "unit"):
        table.add_column(heading, justify="left" if heading in ("value", "unit") else "right")
    for value in found.values:
        std = "" if math.isnan(value.std) else f"{value.std:.2g}"
        table.add_row(value.name, f"{value.value:.5g}", std, value.unit)
    console.print(table)


def _refuse(detail: str) -> NoReturn:
    console.print(f"[red]{escape(detail)}[/red]", soft_wrap=True, highlight=False)
    raise typer.Exit(EXIT_BAD_INPUT)
