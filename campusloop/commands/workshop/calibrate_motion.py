"""`campusloop workshop calibrate --inertial`: where an inertial unit sits to a lidar, from a drive."""

import math
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from campusloop.kernels.compiling import ensure_kernels
from campusloop.kernels.groups import MOTION_CALIBRATION
from contract.transforms import angles_of
from workshop.calibration.errors import CalibrationError
from workshop.cloud_mapping.drive_scans import DriveScans
from workshop.clouds import bags
from workshop.clouds.errors import CloudFileError
from workshop.clouds.recordings import Recording, find_recordings
from workshop.motion_calibration.calibrate import MotionCalibration, calibrate_motion
from workshop.motion_calibration.drive import InertialDrive, LidarMotion, lidar_motion
from workshop.motion_calibration.inertial_files import read_inertial
from workshop.motion_calibration.result_file import inertial_toml

console = Console(soft_wrap=True)

# Cosine of 15 degrees: a kept direction nearer than this to the vertical is called so.
_UPRIGHT = 0.966


def calibrate_by_motion(
    scans: Path, inertial: str, lidar: str | None, lever_m: tuple[float, float, float] | None,
    out: Path, plots: Path | None,
) -> None:  # fmt: skip
    """Writes the unit's pose. Raises CloudFileError, CalibrationError, OSError."""
    unit = _unit(scans, inertial)
    drive = DriveScans([_recording(scans, lidar)])
    ensure_kernels(MOTION_CALIBRATION)
    with Progress(console=console, transient=True) as progress:
        bar = progress.add_task("the lidar's way", total=len(drive))
        motion = lidar_motion(drive, lambda: progress.advance(bar))
    for note in drive.notes:
        console.print(f"[yellow]{note}[/yellow]", highlight=False)
    found = calibrate_motion(motion, unit, None if lever_m is None else np.array(lever_m))
    _print(found, lever_m is not None)
    out.parent.mkdir(parents=True, exist_ok=True)
    out.write_text(inertial_toml(found), encoding="utf-8")
    for path in (out, *_plotted(motion, unit, found, plots)):
        console.print(f"written: {path}", highlight=False)


def _unit(scans: Path, inertial: str) -> InertialDrive:
    if Path(inertial).exists():
        return read_inertial(Path(inertial))
    if bags.is_bag(scans):
        return read_inertial(scans, inertial)
    raise CalibrationError(
        "bad_samples", f"{inertial} does not exist, and {scans} is no bag with such a topic"
    )


def _recording(scans: Path, lidar: str | None) -> Recording:
    if lidar is not None and bags.is_bag(scans):
        return Recording(scans, topic=bags.topic_with_scans(scans, lidar))
    found = find_recordings(scans if lidar is None else scans / lidar)
    if len(found) > 1:
        names = ", ".join(str(one.path) for one in found)
        raise CloudFileError(scans, f"holds {len(found)} recordings; give one of: {names}")
    return found[0]


def _plotted(
    motion: LidarMotion, unit: InertialDrive, found: MotionCalibration, folder: Path | None
) -> list[Path]:
    if folder is None:
        return []
    # matplotlib takes a second to import.
    from workshop.motion_calibration.plots import write_plots

    return write_plots(motion, unit, found, folder)


def _print(found: MotionCalibration, has_lever: bool) -> None:
    turned = math.degrees(found.turned_rad)
    console.print(f"{found.way_m:.0f} m driven, {turned:.0f} degrees of bends", highlight=False)
    table = Table(title="T_lidar_unit", title_justify="left")
    for heading in ("", "value", "std"):
        table.add_column(heading, justify="right" if heading else "left")
    place, angles = found.T_lidar_unit[:3, 3], np.degrees(angles_of(found.T_lidar_unit))
    for name, value, std in zip("xyz", place, found.lever_std_m, strict=True):
        table.add_row(f"{name} (m)", f"{value:.4f}", f"{std:.4f}")
    stds = np.degrees(found.rotation_std_rad)
    for name, value, axis, std in zip(("roll", "pitch", "yaw"), angles, "xyz", stds, strict=True):
        table.add_row(f"{name} (deg)", f"{value:.3f}", f"{std:.3f} about {axis}")
    table.add_row("clock offset (ms)", f"{1e3 * found.offset_s:.2f}", f"{1e3 * found.offset_std_s:.2f}")
    console.print(table)
    adjusted = found.adjustment
    console.print(
        f"left of the windows: {math.degrees(adjusted.turn_std_rad):.3f} degrees,"
        f" {adjusted.acceleration_std_mps2:.3f} m/s2",
        highlight=False,
    )
    for direction in found.kept:
        towards = ", ".join(f"{value:.2f}" for value in direction)
        what = "the vertical" if abs(float(direction @ found.up)) > _UPRIGHT else "a direction"
        kept = "the given value stays" if has_lever else "0 is taken; give --lever, as measured by tape"
        console.print(
            f"[yellow]not determined: the lever arm along {what} ({towards}); {kept}[/yellow]",
            highlight=False,
        )
