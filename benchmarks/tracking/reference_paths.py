"""Paths to follow: a lemniscate, and recorded loops."""

import csv
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from contract.geometry import Array, arc_lengths, project, resample

DENSE_M = 0.02


class PathFileError(Exception):
    """A recorded path cannot be used; the message says why."""


@dataclass(frozen=True, slots=True)
class ReferencePath:
    """points (n, 2) densely along the path, metres; laps of it are driven one after the other if closed."""

    name: str
    points: Array
    s: Array
    closed: bool

    @property
    def length_m(self) -> float:
        return float(self.s[-1])

    def cross_track_m(self, xy: Array) -> Array:
        """(n,) signed distances of a drive's (n, 2) places from the path, followed along it in order.

        A closed curve continues after the last lap, so that a stop a little beyond the end is still on it.
        """
        errors = np.empty(len(xy))
        segment = 0
        window = round(5.0 / DENSE_M)
        points, s = self.points, self.s
        if self.closed:
            points = np.vstack((points, points[1 : window + 1]))
            s = np.concatenate((s, s[-1] + s[1 : window + 1]))
        for i, (x, y) in enumerate(xy):
            _, errors[i], segment = project(points, s, x, y, segment - window, segment + window)
        return errors


def lemniscate(least_radius_m: float, laps: int) -> ReferencePath:
    """Bernoulli's figure of eight from its crossing on; its curvature 3 r / a^2 is greatest at r = a."""
    a = 3.0 * least_radius_m
    t = np.linspace(0.5 * math.pi, (0.5 + 2.0 * laps) * math.pi, laps * 40_000 + 1)
    scale = a / (1.0 + np.sin(t) ** 2)
    dense = np.column_stack((scale * np.cos(t), scale * np.sin(t) * np.cos(t)))
    points = resample(dense, DENSE_M)
    return ReferencePath(f"lemniscate R{least_radius_m:g} m", points, arc_lengths(points), True)


def recorded_path(path: Path, spacing_m: float = 1.0) -> ReferencePath:
    """A recording of x, y (m) and other columns, thinned to `spacing_m` and smoothed between.

    Standing still is left out. PathFileError for an invalid file.
    """
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise PathFileError(f"{path}: {error}") from error
    places: list[tuple[float, float]] = []
    for number, row in enumerate(csv.reader(lines), start=1):
        if not row or row[0].lstrip().startswith("#"):
            continue
        x_m, y_m = _place(path, number, row)
        if not places or math.hypot(x_m - places[-1][0], y_m - places[-1][1]) >= spacing_m:
            places.append((x_m, y_m))
    if len(places) < 5:
        raise PathFileError(f"{path}: it never gets {5 * spacing_m:g} m away from its start")
    points = resample(_through(np.array(places)), DENSE_M)
    return ReferencePath(path.stem, points, arc_lengths(points), False)


def _place(path: Path, number: int, row: list[str]) -> tuple[float, float]:
    try:
        x_m, y_m = float(row[0]), float(row[1])
    except (ValueError, IndexError) as error:
        raise PathFileError(f"{path}:{number}: expected x, y in metres, got {row}") from error
    if not (math.isfinite(x_m) and math.isfinite(y_m)):
        raise PathFileError(f"{path}:{number}: {row} is not finite")
    return x_m, y_m


def _through(points: Array) -> Array:
    """A Catmull-Rom curve (Catmull, Rom 1974) through (n, 2) points, 20 samples between two of them."""
    padded = np.vstack((2.0 * points[0] - points[1], points, 2.0 * points[-1] - points[-2]))
    p0, p1, p2, p3 = padded[:-3], padded[1:-2], padded[2:-1], padded[3:]
    t = np.linspace(0.0, 1.0, 20, endpoint=False)[:, None, None]
    curve = 0.5 * (
        2.0 * p1
        + (p2 - p0) * t
        + (2.0 * p0 - 5.0 * p1 + 4.0 * p2 - p3) * t**2
        + (3.0 * p1 - p0 - 3.0 * p2 + p3) * t**3
    )
    smooth: Array = np.vstack((curve.transpose(1, 0, 2).reshape(-1, 2), points[-1:]))
    return smooth
