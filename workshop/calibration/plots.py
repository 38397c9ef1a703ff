"""Plots of a calibration: the scans over each other before and after, and the distances from the planes."""

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from contract.geometry import Array
from contract.transforms import moved
from workshop.calibration.adjustment import distances_of
from workshop.calibration.calibrate import Calibration
from workshop.calibration.cells import thin
from workshop.calibration.rigs import Rig

_COLOURS = ("#15201b", "#cc3311", "#0077bb", "#ee7733", "#009988", "#aa3377")
_REACH_M = 20.0
_THIN_M = 0.1
_DISTANCE_M = 0.1


def write_plots(rig: Rig, found: Calibration, folder: Path) -> list[Path]:
    """Writes scans.png (from above and from the side) and residuals.png."""
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    for name, figure in (("scans", _scans(rig, found)), ("residuals", _residuals(found))):
        FigureCanvasAgg(figure)
        path = folder / f"{name}.png"
        figure.savefig(path, dpi=110)
        written.append(path)
    return written


def _scans(rig: Rig, found: Calibration) -> Figure:
    figure = Figure(figsize=(11.0, 10.0), layout="constrained")
    axes = figure.subplots(2, 2)
    before = [np.eye(4), *(guess if guess is not None else None for guess in rig.guesses[1:])]
    for row, (vertical, label) in enumerate(((1, "y (m)"), (2, "z (m)"))):
        _draw(axes[row, 0], rig, before, vertical, label)
        _draw(axes[row, 1], rig, list(found.transforms), vertical, label)
    axes[0, 0].set_title("as given")
    axes[0, 1].set_title("calibrated")
    axes[0, 1].legend(markerscale=8, loc="upper right")
    return figure


def _draw(axes: Axes, rig: Rig, transforms: list[Array | None], vertical: int, label: str) -> None:
    for number, (name, cloud, transform) in enumerate(zip(rig.names, rig.clouds, transforms, strict=True)):
        if transform is None:
            continue
        points = moved(transform, thin(cloud, _THIN_M))
        points = points[np.abs(points).max(axis=1) < _REACH_M]
        if vertical == 2:
            # A slice, or walls on both sides would cover each other.
            points = points[np.abs(points[:, 1]) < 2.0]
        axes.plot(
            points[:, 0],
            points[:, vertical],
            ",",
            color=_COLOURS[number % len(_COLOURS)],
            label=name,
            alpha=0.6,
        )
    axes.set(xlabel="x (m)", ylabel=label, xlim=(-_REACH_M, _REACH_M), aspect="equal")


def _residuals(found: Calibration) -> Figure:
    """Of each lidar the distances of its points from the adjusted planes."""
    figure = Figure(figsize=(8.0, 2.2 * len(found.names)), layout="constrained")
    axes = figure.subplots(len(found.names), 1, sharex=True, squeeze=False)[:, 0]
    of_lidars: list[list[Array]] = [[] for _ in found.names]
    for patch, plane in zip(found.patches, found.patch_planes, strict=True):
        for mine, distances in zip(of_lidars, distances_of(patch, found.transforms, plane), strict=True):
            mine.append(distances)
    bins = np.linspace(-_DISTANCE_M, _DISTANCE_M, 81)
    for number, (name, mine) in enumerate(zip(found.names, of_lidars, strict=True)):
        axes[number].hist(np.concatenate(mine), bins=bins, color=_COLOURS[number % len(_COLOURS)])
        axes[number].set(ylabel=name, yticks=[])
    axes[-1].set_xlabel("distance from the common planes (m)")
    return figure
