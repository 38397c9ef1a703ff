"""Recorded pedestrians and cars from files: drone clips and pavement recordings.

A drone clip is a pair of CSV files, `NAME_ped_filtered.csv` (id, frame, label, x_est, y_est, vx_est, vy_est)
and `NAME_veh_filtered.csv` (with psi_est, vel_est), in metres; `frame_rates` reads its frame rate. Velocities
come from the positions: vel_est of cars lags by seconds, and vx_est, vy_est of people by 0.2 s, which the
simulated tracker would add to its own latency. A pavement recording is an `obsmat.txt`
(frame, id, x, z, y, vx, vz, vy), 2.5 observations a second at 10 or 6 frames apart.
"""

import csv
import math
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from contract.geometry import Array
from simulator.traffic.frame_rates import FrameRateError, frame_rate_fps
from simulator.traffic.track_repairs import Repairs, repaired, velocities_mps
from vehicle_agent.signals import PEDESTRIAN, VEHICLE

OBSERVATIONS_PER_S = 2.5
PERSON_SIZE_M = 0.5
CAR_LENGTH_M, CAR_WIDTH_M = 4.5, 1.8
# Faster than this between two frames is a jump of the tracker.
PERSON_MPS_MAX, CAR_MPS_MAX = 8.0, 25.0
# A velocity is the slope of the positions over this time.
CAR_WINDOW_S, PERSON_WINDOW_S = 1.0, 0.5
CARS_FROM = 100_000
_PED, _VEH = "_ped_filtered.csv", "_veh_filtered.csv"


class RecordingError(Exception):
    """A recording cannot be read; the message names file, line and error."""


@dataclass(frozen=True, slots=True)
class RecordedTrack:
    """One person or car. times_s (n,) rising; states (n, 5): x, y, yaw, vx, vy, recording frame.

    recorded_id: the id in the file, which pieces of a track that was cut share; -1 without a file
    """

    number: int
    kind: int
    times_s: Array
    states: Array
    size_m: tuple[float, float]
    recorded_id: int = -1

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
    """All tracks of one recording. ends_s: the last recorded time; fps: its frame rate, 0 if it has none."""

    name: str
    tracks: tuple[RecordedTrack, ...]
    ends_s: float
    fps: float = 0.0
    repairs: Repairs = field(default_factory=Repairs)

    def cars(self) -> tuple[RecordedTrack, ...]:
        return tuple(track for track in self.tracks if track.is_driven)


def drone_clips(folder: Path) -> list[Clip]:
    """Every clip of a folder and the folders below it, by name. RecordingError without any."""
    found = sorted(folder.rglob(f"*{_PED}"))
    if not found:
        raise RecordingError(f"no *{_PED} in {folder}; give a folder of drone recordings")
    return [_drone_clip(path) for path in found]


def _drone_clip(people_path: Path) -> Clip:
    name = people_path.name.removesuffix(_PED)
    cars_path = people_path.with_name(name + _VEH)
    people = _rows(people_path, PEDESTRIAN)
    cars = _rows(cars_path, VEHICLE) if cars_path.exists() else {}
    if not people and not cars:
        return Clip(name, (), 0.0)
    try:
        fps = frame_rate_fps([_motion(rows) for rows in people.values()], [_motion(r) for r in cars.values()])
    except FrameRateError as error:
        raise RecordingError(f"{people_path}: {error}") from error
    walked, people_repairs = _tracks(people, PEDESTRIAN, 0, fps)
    driven, car_repairs = _tracks(cars, VEHICLE, CARS_FROM, fps)
    tracks = (*walked, *driven)
    ends_s = max(float(track.times_s[-1]) for track in tracks)
    return Clip(name, tracks, ends_s, fps, people_repairs + car_repairs)


def _motion(rows: Array) -> Array:
    """(n, 5) frame, x, y, vx, vy."""
    return rows[:, (0, 1, 2, 4, 5)]


def _rows(path: Path, kind: int) -> dict[int, Array]:
    """By id (n, 6): frame, x, y, yaw, vx, vy; frames rise. RecordingError names file and line."""
    rows: dict[int, dict[int, tuple[float, ...]]] = {}
    line = 1
    try:
        with path.open(newline="", encoding="utf-8") as file:
            for line, row in enumerate(csv.DictReader(file), start=2):
                number, frame = int(row["id"]), int(row["frame"])
                values = _values(row, kind)
                if not all(map(math.isfinite, values)):
                    raise RecordingError(f"{path}, line {line}: a value is not finite")
                if rows.setdefault(number, {}).setdefault(frame, values) != values:
                    raise RecordingError(f"{path}, line {line}: id {number} is twice in frame {frame}")
    except (KeyError, TypeError, ValueError, csv.Error) as error:
        raise RecordingError(f"{path}, line {line}: {error!r}") from error
    return {
        number: np.array([(frame, *by_frame[frame]) for frame in sorted(by_frame)], dtype=np.float64)
        for number, by_frame in sorted(rows.items())
    }


def _values(row: dict[str, str], kind: int) -> tuple[float, ...]:
    """x, y, yaw, vx, vy of a row."""
    x, y = float(row["x_est"]), float(row["y_est"])
    if kind == VEHICLE:
        yaw, speed = float(row["psi_est"]), float(row["vel_est"])
        return x, y, yaw, speed * math.cos(yaw), speed * math.sin(yaw)
    vx, vy = float(row["vx_est"]), float(row["vy_est"])
    return x, y, math.atan2(vy, vx), vx, vy


def _tracks(
    rows: dict[int, Array], kind: int, numbers_from: int, fps: float
) -> tuple[list[RecordedTrack], Repairs]:
    """The tracks by number; a piece that was cut off gets a number of its own."""
    size_m, speed_mps_max, window_s = (
        ((CAR_LENGTH_M, CAR_WIDTH_M), CAR_MPS_MAX, CAR_WINDOW_S)
        if kind == VEHICLE
        else ((PERSON_SIZE_M, PERSON_SIZE_M), PERSON_MPS_MAX, PERSON_WINDOW_S)
    )
    tracks, done = [], Repairs()
    free = max(rows, default=0) + 1
    for number, table in rows.items():
        timed = table.copy()
        timed[:, 0] /= fps
        pieces, repairs = repaired(timed, 1.0 / fps, speed_mps_max)
        done += repairs
        for k, piece in enumerate(pieces):
            piece[:, 4:6] = velocities_mps(piece[:, 0], piece[:, 1:3], window_s)
            track = _recorded(numbers_from + (free if k else number), kind, piece, size_m)
            tracks.append(replace(track, recorded_id=number))
            free += k > 0
    return tracks, done


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
    tracks = []
    for number in sorted(rows):
        table = np.array(sorted(rows[number]))
        rising = np.concatenate(([True], np.diff(table[:, 0]) > 0.0))
        tracks.append(_recorded(number, PEDESTRIAN, table[rising], size_m))
    return Clip(path.parent.name, tuple(tracks), max(float(t.times_s[-1]) for t in tracks))


def _recorded(number: int, kind: int, table: Array, size_m: tuple[float, float]) -> RecordedTrack:
    table[:, 3] = np.unwrap(table[:, 3])
    return RecordedTrack(number, kind, np.ascontiguousarray(table[:, 0]), table[:, 1:].copy(), size_m)
