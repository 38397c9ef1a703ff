"""Boxes of annotated sweeps: CSV files with class, x, y, z, length, width, height, yaw, track."""

import csv
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from contract.geometry import Array, IntArray
from vehicle_agent.signals import CYCLIST, OTHER, PEDESTRIAN, VEHICLE

# Other names that annotations give the columns.
_NAMES = {
    "class": ("class", "label", "category", "type", "name", "category_name", "class_name"),
    "x": ("x", "center_x", "cx"),
    "y": ("y", "center_y", "cy"),
    "z": ("z", "center_z", "cz"),
    "length": ("length", "l", "dx", "size_x"),
    "width": ("width", "w", "dy", "size_y"),
    "height": ("height", "h", "dz", "size_z"),
    "yaw": ("yaw", "heading", "rotation_z", "rot_z", "rotation"),
    "track": ("track", "track_id", "id", "instance", "instance_token", "object_id"),
    "frame": ("frame", "frame_id", "sweep", "index"),
    "time": ("time", "timestamp", "stamp", "t", "time_s"),
}
_NEEDED = ("class", "x", "y", "z", "length", "width", "height")
# Parts of class names; the first one found says the kind: a bicycle's rack is no cyclist.
_WORDS: tuple[tuple[str, int], ...] = (
    ("rack", OTHER), ("cone", OTHER), ("barrier", OTHER), ("debris", OTHER), ("animal", OTHER),
    ("static", OTHER), ("pushable", OTHER), ("dontcare", OTHER), ("ignore", OTHER), ("sign", OTHER),
    ("cyclist", CYCLIST), ("rider", CYCLIST), ("bicycle", CYCLIST), ("bike", CYCLIST),
    ("motorcycle", CYCLIST),
    ("pedestrian", PEDESTRIAN), ("person", PEDESTRIAN), ("human", PEDESTRIAN), ("people", PEDESTRIAN),
    ("vehicle", VEHICLE), ("car", VEHICLE), ("truck", VEHICLE), ("bus", VEHICLE), ("van", VEHICLE),
    ("trailer", VEHICLE), ("tram", VEHICLE),
)  # fmt: skip
# Yaws beyond this are degrees.
_RAD_MAX = 2.0 * math.pi + 0.01


class AnnotationError(Exception):
    """A file of boxes that cannot be read; the message says why."""


@dataclass(frozen=True, slots=True, eq=False)
class Annotations:
    """The boxes of one file.

    kinds (n,) as in TRACK_KINDS; names: (n,) the classes as written; centres (n, 3), sizes_m (n, 3) length,
    width, height; yaws (n,) rad; tracks (n,) as written, "" without; frames (n,) 0 without, otherwise their
    order in the file's column of frames or times; times_s (n,) NaN without
    left_out  rows that are no boxes, by reason
    """

    kinds: IntArray
    names: tuple[str, ...]
    centres: Array
    sizes_m: Array
    yaws: Array
    tracks: tuple[str, ...]
    frames: IntArray
    times_s: Array
    left_out: dict[str, int]

    def __len__(self) -> int:
        return len(self.names)


def kind_of(name: str) -> int:
    """The kind of a class name; `other` for names that are not known."""
    lower = name.lower()
    return next((kind for word, kind in _WORDS if word in lower), OTHER)


def read_annotations(path: Path) -> Annotations:
    """The boxes of a CSV file; a file with a header alone has none. Raises AnnotationError."""
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise AnnotationError(f"{path.name}: cannot be read ({error})") from error
    lines = [line for line in text.splitlines() if line.strip()]
    if not lines:
        raise AnnotationError(f"{path.name}: is empty; a header with {', '.join(_NEEDED)} is needed")
    separator = max((",", ";", "\t"), key=lines[0].count)
    rows = list(csv.reader(lines, delimiter=separator))
    columns = _columns(rows[0])
    missing = [name for name in _NEEDED if name not in columns]
    if missing:
        raise AnnotationError(f"{path.name}: no column {', '.join(missing)}; there are: {', '.join(rows[0])}")
    return _boxes(rows[1:], columns)


def _columns(header: list[str]) -> dict[str, int]:
    written = [name.strip().lower() for name in header]
    found = {}
    for name, others in _NAMES.items():
        at = next((written.index(other) for other in others if other in written), None)
        if at is not None:
            found[name] = at
    return found


def _boxes(rows: list[list[str]], columns: dict[str, int]) -> Annotations:
    numbers = [name for name in ("x", "y", "z", "length", "width", "height", "yaw") if name in columns]
    kept: list[list[str]] = []
    values: list[dict[str, float]] = []
    left_out: dict[str, int] = {}
    for row in rows:
        try:
            box = {name: float(row[columns[name]]) for name in numbers}
        except (ValueError, IndexError):
            left_out["a value is missing or no number"] = (
                left_out.get("a value is missing or no number", 0) + 1
            )
            continue
        if not all(math.isfinite(value) for value in box.values()) or min(box["length"], box["width"]) <= 0.0:
            left_out["no size"] = left_out.get("no size", 0) + 1
            continue
        kept.append(row)
        values.append(box)
    yaws = np.array([box.get("yaw", 0.0) for box in values])
    if len(yaws) and np.abs(yaws).max() > _RAD_MAX:
        yaws = np.radians(yaws)
    names = tuple(row[columns["class"]].strip() for row in kept)
    return Annotations(
        np.array([kind_of(name) for name in names], dtype=np.int64),
        names,
        np.array([[box["x"], box["y"], box["z"]] for box in values]).reshape(-1, 3),
        np.array([[box["length"], box["width"], box["height"]] for box in values]).reshape(-1, 3),
        yaws,
        tuple(_text(row, columns, "track") for row in kept),
        *_frames(kept, columns),
        left_out,
    )


def _text(row: list[str], columns: dict[str, int], name: str) -> str:
    at = columns.get(name)
    return row[at].strip() if at is not None and at < len(row) else ""


def _frames(rows: list[list[str]], columns: dict[str, int]) -> tuple[IntArray, Array]:
    """(number of each row's frame, its time in s)."""
    written = [_text(row, columns, "frame") or _text(row, columns, "time") for row in rows]
    keys = [_number(text) for text in written]
    order = {key: number for number, key in enumerate(sorted(set(keys)))}
    times = np.array([_number(_text(row, columns, "time")) for row in rows]).reshape(-1)
    # Dates in ns, us or ms are far from seconds.
    for unit, least in ((1e-9, 1e17), (1e-6, 1e14), (1e-3, 1e11)):
        if len(times) and np.nanmax(times, initial=0.0) > least:
            times = times * unit
            break
    return np.array([order[key] for key in keys], dtype=np.int64).reshape(-1), times


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return -1.0 if not text else float(sum(ord(letter) << (8 * k) for k, letter in enumerate(text[:6])))
