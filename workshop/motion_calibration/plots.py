"""Plots of a calibration by motion: turn rates and way of both sensors, and what is left of the windows."""

from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from workshop.motion_calibration.calibrate import MotionCalibration
from workshop.motion_calibration.drive import InertialDrive, LidarMotion
from workshop.motion_calibration.integration import rotation_vectors

_LIDAR, _UNIT = "#0077bb", "#cc3311"
_AXES = "xyz"


def write_plots(
    lidar: LidarMotion, unit: InertialDrive, found: MotionCalibration, folder: Path
) -> list[Path]:
    """Writes rates.png (turn rates of both in the lidar's frame) and motion_residuals.png."""
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    for name, figure in (
        ("rates", _rates(lidar, unit, found)),
        ("motion_residuals", _residuals(lidar, found)),
    ):
        FigureCanvasAgg(figure)
        path = folder / f"{name}.png"
        figure.savefig(path, dpi=110)
        written.append(path)
    return written


def _rates(lidar: LidarMotion, unit: InertialDrive, found: MotionCalibration) -> Figure:
    figure = Figure(figsize=(11.0, 8.0), layout="constrained")
    axes = figure.subplots(3, 1, sharex=True)
    turned = rotation_vectors(lidar.poses[:-1, :3, :3].transpose(0, 2, 1) @ lidar.poses[1:, :3, :3])
    seen = turned / np.diff(lidar.stamps_s)[:, None]
    middles_s = 0.5 * (lidar.stamps_s[1:] + lidar.stamps_s[:-1])
    unknowns = found.adjustment.unknowns
    felt = (unit.rates_radps - unknowns.rate_bias_radps) @ unknowns.rotation.T
    felt_s = unit.stamps_s + 1e-9 * (unit.start_ns - lidar.start_ns) + found.offset_s
    for number, axis in enumerate(axes):
        axis.plot(felt_s, felt[:, number], color=_UNIT, linewidth=0.6, label="inertial unit")
        axis.plot(middles_s, seen[:, number], color=_LIDAR, linewidth=1.0, label="lidar")
        axis.set(ylabel=f"{_AXES[number]} (rad/s)", xlim=(0.0, lidar.stamps_s[-1]))
    axes[0].legend(loc="upper right")
    axes[0].set_title("turn rates in the lidar's frame")
    axes[-1].set_xlabel("lidar's time (s)")
    return figure


def _residuals(lidar: LidarMotion, found: MotionCalibration) -> Figure:
    figure = Figure(figsize=(11.0, 7.0), layout="constrained")
    axes = figure.subplots(2, 1, sharex=True)
    rows = (
        (np.degrees(found.adjustment.turns_rad), found.windows.pairs, "turns (degrees)"),
        (found.adjustment.accelerations_mps2, found.windows.triples, "accelerations (m/s2)"),
    )
    for axis, (values, windows, label) in zip(axes, rows, strict=True):
        times_s = lidar.stamps_s[windows[:, 0]]
        for number, colour in enumerate(("#15201b", "#ee7733", "#009988")):
            axis.plot(times_s, values[:, number], ".", markersize=2, color=colour, label=_AXES[number])
        axis.set_ylabel(label)
    axes[0].legend(markerscale=6, loc="upper right")
    axes[-1].set_xlabel("lidar's time at the window's begin (s)")
    return figure
