"""Recorded pedestrians and cars from files: drone clips and pavement recordings.

A drone clip is a pair of CSV files, `NAME_ped_filtered.csv` (id, frame, label, x_est, y_est, vx_est, vy_est)
and `NAME_veh_filtered.csv` (with psi_est, vel_est), metres at 23.98 frames a second; a pavement recording is
an `obsmat.txt` (frame, id, x, z, y, vx, vz, vy), 2.5 observations a second at 10 or 6 frames apart.
"""

import csv
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from contract.geometry import Array
from vehicle_agent.signals import PEDESTRIAN, VEHICLE

DRONE_FPS = 23.98
OBSERVATIONS_PER_S = 2.5
PERSON_SIZE_M = 0.5
CAR_LENGTH_M, CAR_WIDTH_M = 4.5, 1.8
_PED, _VEH = "_ped_filtered.csv", "_veh_filtered.csv"


class RecordingError(Exception):
    """A recording cannot be read; the message names file, line and error."""


@dataclass(frozen=True, slots=True)
class RecordedTrack:
    """One person or car. times_s (n,) rising; states (n, 5): x, y, yaw, vx, vy, recording frame."""

    number: int
    kind: int
    times_s: Array
    states: Array
    size_m: tuple[float, float]

    @property
    def mean_speed_mps(self) -> float:
        """Path length over time; 0 for a single observation."""
        steps = np.diff(self.states[:, :2], axis=0)
        time_s = float(self.times_s[-1] - self.times_s[0])
        return float(np.hypot(steps[:, 0], steps[:, 1]).sum()) / time_s if time_s > 0.0 else 0.0

    @property
    def is_driven(self) -> bool:
        return self.kind != PEDESTRIAN


@dataclass(frozen=True, slots=True)
class Clip:
    """All tracks of one recording; ends_s: the last recorded time."""

    name: str
    tracks: tuple[RecordedTrack, ...]
    ends_s: float

    def cars(self) -> tuple[RecordedTrack, ...]:
        return tuple(track for track in self.tracks if track.is_driven)


def drone_clips(folder: Path) -> list[Clip]:
    """Every clip of a folder and the folders below it, by name. RecordingError without any."""
    found = sorted(folder.rglob(f"*{_PED}"))
    if not found:
        raise RecordingError(f"no *{_PED} in {folder}; give a folder of drone recordings")
    return [_drone_clip(path) for path in found]


def _drone_clip(people: Path) -> Clip:
    name = people.name.removesuffix(_PED)
    cars = people.with_name(name + _VEH)
    tracks = _tracks(people, PEDESTRIAN, 0)
    if cars.exists():
        tracks += _tracks(cars, VEHICLE, 100_000)
    ends_s = max((float(track.times_s[-1]) for track in tracks), default=0.0)
    return Clip(name, tuple(tracks), ends_s)


def _tracks(path: Path, kind: int, numbers_from: int) -> list[RecordedTrack]:
    """By id, each in order of time; a file without rows gives none."""
    rows: dict[int, list[tuple[float, ...]]] = {}
    with path.open(newline="", encoding="utf-8") as file:
        for line, row in enumerate(csv.DictReader(file), start=2):
            try:
                number, time_s = int(row["id"]), int(row["frame"]) / DRONE_FPS
                x, y = float(row["x_est"]), float(row["y_est"])
                if kind == VEHICLE:
                    yaw, speed = float(row["psi_est"]), float(row["vel_est"])
                    vx, vy = speed * math.cos(yaw), speed * math.sin(yaw)
                else:
                    vx, vy = float(row["vx_est"]), float(row["vy_est"])
                    yaw = math.atan2(vy, vx)
            except (KeyError, TypeError, ValueError) as error:
                raise RecordingError(f"{path}, line {line}: {error!r}") from error
            if not all(map(math.isfinite, (x, y, yaw, vx, vy))):
                raise RecordingError(f"{path}, line {line}: a value is not finite")
            rows.setdefault(number, []).append((time_s, x, y, yaw, vx, vy))
    size_m = (CAR_LENGTH_M, CAR_WIDTH_M) if kind == VEHICLE else (PERSON_SIZE_M, PERSON_SIZE_M)
    return [_recorded(numbers_from + number, kind, rows[number], size_m) for number in sorted(rows)]


def pavement_clip(path: Path) -> Clip:
    """An `obsmat.txt` as a clip of people. RecordingError for an invalid file."""
    try:
        table = np.loadtxt(path, ndmin=2)
    except ValueError as error:
        raise RecordingError(f"{path}: {error}") from error
    if table.shape[1] != 8 or not len(table) or not np.isfinite(table).all():
        raise RecordingError(f"{path}: expected rows of frame, id, x, z, y, vx, vz, vy, all finite")
    frames = np.unique(table[:, 0])
    step = float(np.diff(frames).min()) if len(frames) > 1 else 1.0
    rows: dict[int, list[tuple[float, ...]]] = {}
    for frame, number, x, _, y, vx, _, vy in table.tolist():
        time_s = (frame - float(frames[0])) / step / OBSERVATIONS_PER_S
        rows.setdefault(int(number), []).append((time_s, x, y, math.atan2(vy, vx), vx, vy))
    size_m = (PERSON_SIZE_M, PERSON_SIZE_M)
    tracks = [_recorded(number, PEDESTRIAN, rows[number], size_m) for number in sorted(rows)]
    return Clip(path.parent.name, tuple(tracks), max(float(t.times_s[-1]) for t in tracks))


def _recorded(
    number: int, kind: int, rows: list[tuple[float, ...]], size_m: tuple[float, float]
) -> RecordedTrack:
    table = np.array(sorted(rows))
    rising = np.concatenate(([True], np.diff(table[:, 0]) > 0.0))
    table = table[rising]
    table[:, 3] = np.unwrap(table[:, 3])
    return RecordedTrack(number, kind, np.ascontiguousarray(table[:, 0]), table[:, 1:].copy(), size_m)
