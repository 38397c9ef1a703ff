"""GNSS fixes beside a recording, and where they say the keyframes are."""

import csv
import math
from pathlib import Path

import msgspec
import numpy as np

from contract.geometry import Array
from contract.roads.model import Origin
from contract.roads.projection import project
from workshop.cloud_mapping.pose_graph import Place

_COLUMNS = ("stamp_s", "latitude_deg", "longitude_deg", "position_std_m")
_HEIGHT = ("height_m", "height_std_m")


class FixFileError(Exception):
    """The file holds no fixes; the message is one sentence."""


class Fixes(msgspec.Struct, frozen=True):
    """stamps_ns (n,) in the scans' clock; places (n, 3) in the map frame; std_m (n, 3), inf: not known.

    dropped  lines that are not finite, or state that there is no solution
    """

    origin: Origin
    stamps_ns: np.ndarray
    places: Array
    std_m: Array
    dropped: int


class FixParams(msgspec.Struct, frozen=True):
    """How fixes become factors.

    every_m        of the way: fixes that follow each other have nearly the same error
    stated_factor  receivers know nothing of reflections
    std_m_max      worse fixes are left out
    gap_ns_max     between a keyframe and the fixes around it
    """

    every_m: float = 5.0
    stated_factor: float = 3.0
    std_m_max: float = 3.0
    gap_ns_max: int = 300_000_000


def read_fixes(path: Path, origin: Origin | None) -> Fixes:
    """The fixes of a CSV file; without an origin the first one is it. Raises FixFileError."""
    try:
        with path.open(newline="", encoding="utf-8") as file:
            reader = csv.DictReader(file)
            names = reader.fieldnames or []
            missing = [name for name in _COLUMNS if name not in names]
            if missing:
                raise FixFileError(f"{path} has no column {', '.join(missing)}.")
            has_height = all(name in names for name in _HEIGHT)
            rows = [
                [float(row[name]) for name in (*_COLUMNS, *(_HEIGHT if has_height else ()))] for row in reader
            ]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise FixFileError(f"{path} cannot be read: {error}.") from error
    except (TypeError, ValueError) as error:
        raise FixFileError(f"{path} has a line with a value that is no number: {error}.") from error
    table = np.array(rows).reshape(len(rows), -1 if rows else 0)
    usable = np.isfinite(table).all(axis=1) if len(table) else np.zeros(0, dtype=bool)
    if len(table):
        usable &= (np.abs(table[:, 1]) <= 90.0) & (np.abs(table[:, 2]) <= 180.0) & (table[:, 3] > 0.0)
    if not usable.any():
        raise FixFileError(f"{path} has no usable fix.")
    table = table[usable]
    table = table[np.argsort(table[:, 0], kind="stable")]
    origin = origin or Origin(float(table[0, 1]), float(table[0, 2]))
    xy = np.array([project(origin, lat, lon) for lat, lon in table[:, 1:3]])
    z = table[:, 4] if has_height else np.zeros(len(table))
    z_std = table[:, 5] if has_height else np.full(len(table), np.inf)
    return Fixes(
        origin,
        np.rint(1e9 * table[:, 0]).astype(np.int64),
        np.column_stack((xy, z)),
        np.column_stack((table[:, 3], table[:, 3], z_std)),
        int((~usable).sum()),
    )


def places_of(
    fixes: Fixes, stamps_ns: np.ndarray, way_m: Array, lever_sensor: Array, params: FixParams
) -> list[Place]:
    """The fixes as places of keyframes, whose stamps (k,) and way (k,) are given; interpolated in time."""
    found: list[Place] = []
    last_m = -math.inf
    for number, stamp_ns in enumerate(stamps_ns):
        if way_m[number] - last_m < params.every_m:
            continue
        after = int(np.searchsorted(fixes.stamps_ns, stamp_ns))
        before = max(0, after - 1)
        after = min(after, len(fixes.stamps_ns) - 1)
        gaps_ns = (abs(int(stamp_ns) - int(fixes.stamps_ns[i])) for i in (before, after))
        std_m = params.stated_factor * np.maximum(fixes.std_m[before], fixes.std_m[after])
        if max(gaps_ns) > params.gap_ns_max or std_m[0] > params.std_m_max:
            continue
        span_ns = int(fixes.stamps_ns[after] - fixes.stamps_ns[before])
        share = (int(stamp_ns) - int(fixes.stamps_ns[before])) / span_ns if span_ns else 0.0
        place = (1.0 - share) * fixes.places[before] + share * fixes.places[after]
        found.append(Place(number, lever_sensor, place, np.maximum(std_m, 0.02)))
        last_m = float(way_m[number])
    return found


def laid_on(poses: Array, places: list[Place]) -> Array:
    """Poses (k, 4, 4) turned about the vertical and moved so that they fit the places best (Umeyama 1991)."""
    nodes = [place.node for place in places]
    ours = np.array(
        [poses[n, :3, :3] @ p.lever_sensor + poses[n, :3, 3] for n, p in zip(nodes, places, strict=True)]
    )
    true = np.array([place.place_map for place in places])
    weights = np.array([place.std_m[0] ** -2 for place in places])
    weights /= weights.sum()
    middle, target = weights @ ours, weights @ true
    a, b = ours - middle, true - target
    yaw = math.atan2(
        float(weights @ (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])),
        float(weights @ (a[:, 0] * b[:, 0] + a[:, 1] * b[:, 1])),
    )
    T: Array = np.eye(4)
    T[:2, :2] = [[math.cos(yaw), -math.sin(yaw)], [math.sin(yaw), math.cos(yaw)]]
    T[:2, 3] = (target - T[:3, :3] @ middle)[:2]
    laid: Array = T @ poses
    return laid
