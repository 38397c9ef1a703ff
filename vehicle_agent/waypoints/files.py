"""Waypoint files: CSV of latitude, longitude and speed, one named file for each desired speed."""

import csv
import math
from collections.abc import Sequence
from pathlib import Path

import msgspec
import numpy as np

from contract.geometry import Array
from contract.roads.model import Origin
from contract.roads.projection import project, unproject
from contract.roads.routing import ReferenceLine
from vehicle_agent.planning.waypoint.waypoints import (
    WaypointRules,
    Waypoints,
    curve_speed_mps,
    waypoints_from_line,
    waypoints_from_points,
)
from vehicle_agent.waypoints.recorder import Waypoint

_HEADER = ["latitude_deg", "longitude_deg", "speed_mps"]


class WaypointFileError(Exception):
    """The file has no usable waypoints; the message names the line."""


def file_name(route: str, speed_mps: float) -> str:
    """The file name with the speed: `loop-3.0mps.csv`."""
    return f"{route}-{speed_mps:.1f}mps.csv"


def write_recording(
    folder: Path, route: str, recorded: Sequence[Waypoint], origin: Origin, speeds_mps: Sequence[float]
) -> list[Path]:
    """One file for each desired speed; each waypoint no faster than sqrt(0.5 r) allows."""
    points = np.array([(waypoint.x_m, waypoint.y_m) for waypoint in recorded])
    allowed = np.array([curve_speed_mps(waypoint.radius_m) for waypoint in recorded])
    return [
        _write(folder, route, speed_mps, points, np.minimum(allowed, speed_mps), origin)
        for speed_mps in speeds_mps
    ]


def write_route(
    folder: Path,
    route: str,
    line: ReferenceLine,
    origin: Origin,
    speeds_mps: Sequence[float],
    rules: WaypointRules,
) -> list[Path]:
    """One file for each desired speed; each waypoint no faster than the road and its curve allow."""
    paths = []
    for speed_mps in speeds_mps:
        waypoints = waypoints_from_line(
            line, msgspec.structs.replace(rules, speed_mps_max=speed_mps, overrun_m=0.0)
        )
        paths.append(_write(folder, route, speed_mps, waypoints.points_map, waypoints.speeds_mps, origin))
    return paths


def _write(
    folder: Path, route: str, speed_mps: float, points_map: Array, speeds_mps: Array, origin: Origin
) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / file_name(route, speed_mps)
    with path.open("w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow(_HEADER)
        for (x_m, y_m), allowed_mps in zip(points_map, speeds_mps, strict=True):
            latitude_deg, longitude_deg = unproject(origin, float(x_m), float(y_m))
            rows.writerow([f"{latitude_deg:.9f}", f"{longitude_deg:.9f}", f"{allowed_mps:.3f}"])
    return path


def read_waypoints(path: Path, origin: Origin, rules: WaypointRules) -> Waypoints:
    """The file's waypoints in the map frame of `origin`. WaypointFileError with the line at fault."""
    points: list[tuple[float, float]] = []
    speeds: list[float] = []
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (FileNotFoundError, UnicodeDecodeError) as error:
        raise WaypointFileError(f"{path}: {error}") from error
    for number, row in enumerate(csv.reader(lines), start=1):
        if not row or row == _HEADER:
            continue
        latitude_deg, longitude_deg, speed_mps = _triplet(path, number, row)
        points.append(project(origin, latitude_deg, longitude_deg))
        speeds.append(speed_mps)
    if len(points) < 3:
        raise WaypointFileError(f"{path}: a path needs at least three waypoints, this has {len(points)}")
    return waypoints_from_points(np.array(points), np.array(speeds), rules)


def _triplet(path: Path, number: int, row: list[str]) -> tuple[float, float, float]:
    try:
        latitude_deg, longitude_deg, speed_mps = (float(cell) for cell in row)
    except ValueError as error:
        raise WaypointFileError(f"{path}:{number}: expected latitude, longitude, speed; got {row}") from error
    in_range = abs(latitude_deg) <= 90.0 and abs(longitude_deg) <= 180.0
    if not in_range or not (math.isfinite(speed_mps) and speed_mps >= 0.0):
        raise WaypointFileError(f"{path}:{number}: {row} is no place with a speed")
    return latitude_deg, longitude_deg, speed_mps
