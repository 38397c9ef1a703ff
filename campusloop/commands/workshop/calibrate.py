"""`campusloop workshop calibrate`: where the lidars of a vehicle sit to each other, or its inertial unit."""

import math
from pathlib import Path
from typing import Annotated, NoReturn

import typer
from rich.console import Console
from rich.markup import escape
from rich.progress import Progress
from rich.table import Table

from contract.transforms import angles_of
from workshop.calibration.calibrate import Calibration, calibrate
from workshop.calibration.errors import CalibrationError
from workshop.calibration.registration import surfaces_of
from workshop.calibration.residuals import Residual, residual
from workshop.calibration.rigs import SCANS_MAX, Rig, extrinsics_toml, load_rig
from workshop.clouds.errors import CloudFileError

console = Console()

EXIT_BAD_INPUT = 2
# Planes of each lidar, a first guess of all but one, three rounds of adjustment.
_ROUNDS = 3


def calibrate_lidars(
    scans: Annotated[
        Path,
        typer.Argument(
            help="Folder with one file or folder of scans for each lidar, or a bag with their topics."
        ),
    ],
    out: Annotated[
        Path | None,
        typer.Option(
            help="File to write the poses to (TOML), never overwritten; extrinsics.toml or inertial.toml"
            " without it."
        ),
    ] = None,
    reference: Annotated[
        str | None,
        typer.Option(help="Lidar whose frame the poses are in; without it the given or fullest one."),
    ] = None,
    inertial: Annotated[
        str | None,
        typer.Option(
            help="Samples of an inertial unit (CSV or bag), or its topic in the bag of scans: its pose is"
            " found from a drive."
        ),
    ] = None,
    lever: Annotated[
        tuple[float, float, float] | None,
        typer.Option(help="With --inertial: where the unit is in the lidar's frame by tape: x y z, m."),
    ] = None,
    plots: Annotated[Path | None, typer.Option(help="Folder for plots (PNG).")] = None,
    scans_max: Annotated[
        int, typer.Option(min=1, help="Scans of each lidar that are put together.")
    ] = SCANS_MAX,
) -> None:
    """Find the poses of several lidars from a scene that all see: the ground and a corner of two walls.

    The vehicle stands still. Given poses are read from extrinsics.toml beside the scans; they are only a
    guess. With --inertial the vehicle drives bends to both sides, and the pose of its inertial unit and the
    offset of the clocks are found.
    """
    out = out or Path("extrinsics.toml" if inertial is None else "inertial.toml")
    if out.exists():
        _refuse(f"{out} exists; give another --out")
    if inertial is not None:
        _by_motion(scans, inertial, reference, lever, out, plots)
        return
    try:
        rig = load_rig(scans, reference, scans_max)
        found = _calibrated(rig)
    except CloudFileError as error:
        _refuse(str(error))
    except CalibrationError as error:
        _refuse(f"{error.code}: {error}")
    _print_poses(found)
    _print_residuals(rig, found)
    out.parent.mkdir(parents=True, exist_ok=True)
    out.write_text(extrinsics_toml(found), encoding="utf-8")
    written = [out]
    if plots is not None:
        # matplotlib takes a second to import.
        from workshop.calibration.plots import write_plots

        written += write_plots(rig, found, plots)
    for path in written:
        console.print(f"written: {path}", soft_wrap=True, highlight=False)


def _by_motion(
    scans: Path, inertial: str, lidar: str | None, lever_m: tuple[float, float, float] | None,
    out: Path, plots: Path | None,
) -> None:  # fmt: skip
    from campusloop.commands.workshop.calibrate_motion import calibrate_by_motion

    try:
        calibrate_by_motion(scans, inertial, lidar, lever_m, out, plots)
    except CloudFileError as error:
        _refuse(str(error))
    except CalibrationError as error:
        _refuse(f"{error.code}: {error}")
    except OSError as error:
        _refuse(f"{out} cannot be written: {error.strerror or error}")


def _calibrated(rig: Rig) -> Calibration:
    with Progress(console=console, transient=True) as progress:
        bar = progress.add_task("reading", total=2 * len(rig.names) - 1 + _ROUNDS)

        def show(step: str) -> None:
            progress.update(bar, description=step, advance=1)

        return calibrate(rig.names, rig.clouds, rig.guesses, step=show)


def _print_poses(found: Calibration) -> None:
    table = Table(title=f"T_reference_sensor, reference {found.names[0]}", title_justify="left")
    for heading in (
        "lidar",
        "x (m)",
        "y (m)",
        "z (m)",
        "roll (deg)",
        "pitch (deg)",
        "yaw (deg)",
        "std (mm)",
        "std (deg)",
    ):
        table.add_column(heading, justify="left" if heading == "lidar" else "right")
    for name, transform, stds in zip(found.names, found.transforms, found.stds, strict=True):
        angles = (f"{math.degrees(angle):.3f}" for angle in angles_of(transform))
        table.add_row(
            name, *(f"{value:.4f}" for value in transform[:3, 3]), *angles,
            f"{1e3 * stds[3:].max():.1f}", f"{math.degrees(stds[:3].max()):.3f}",
        )  # fmt: skip
    console.print(table)


def _print_residuals(rig: Rig, found: Calibration) -> None:
    """Distances from the reference's surfaces, at the given poses and at those found."""
    table = Table(title="residuals", title_justify="left")
    for heading in ("lidar", "poses", "rms (cm)", "median (cm)", "thickness (cm)", "on surfaces (%)"):
        table.add_column(heading, justify="left" if heading in ("lidar", "poses") else "right")
    surfaces = surfaces_of(rig.clouds[0])
    for number in range(1, len(rig.names)):
        if found.kept[number]:
            console.print(f"{rig.names[number]}: the given pose fits best, and stays")
        for poses, transform in (("given", rig.guesses[number]), ("found", found.transforms[number])):
            if transform is not None:
                values = residual(rig.clouds[0], surfaces, rig.clouds[number], transform)
                table.add_row(rig.names[number], poses, *_cells(values))
    console.print(table)


def _cells(values: Residual) -> tuple[str, ...]:
    lengths = (values.plane_m, values.median_m, values.thickness_m)
    return (*(f"{100.0 * length:.2f}" for length in lengths), f"{100.0 * values.on_surfaces:.1f}")


def _refuse(detail: str) -> NoReturn:
    console.print(f"[red]{escape(detail)}[/red]", soft_wrap=True, highlight=False)
    raise typer.Exit(EXIT_BAD_INPUT)
