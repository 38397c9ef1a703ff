"""A street between two walls with pillars, scanned from a vehicle that drives along it: parcels of scans."""

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from contract.geometry import Array
from contract.roads.model import Origin
from contract.roads.projection import unproject
from contract.scan_parcels.parcels import FixRow, ParcelHeader, ParcelWriter, PoseRow

ORIGIN = Origin(31.3, 121.4)
LENGTH_M = 64.0
_MAST_M = 2.0
_RINGS = np.radians(np.linspace(-22.0, 14.0, 24))
_AZIMUTHS = np.radians(np.arange(0.0, 360.0, 1.0))

# x0, y0, x1, y1, height
Wall = tuple[float, float, float, float, float]


def walls(moved_m: float = 0.0, moved_from: float = 38.0, moved_to: float = 52.0) -> list[Wall]:
    """The left wall stands `moved_m` farther away between two x; pillars stand before both."""
    left, right = 8.0, -7.0
    found: list[Wall] = [
        (-20.0, left, moved_from, left, 5.0),
        (moved_from, left + moved_m, moved_to, left + moved_m, 5.0),
        (moved_to, left, LENGTH_M + 20.0, left, 5.0),
        (-20.0, right, LENGTH_M + 20.0, right, 4.0),
        (-20.0, right, -20.0, left, 4.0),
        (LENGTH_M + 20.0, right, LENGTH_M + 20.0, left, 4.0),
    ]
    if moved_m:
        found += [
            (moved_from, left, moved_from, left + moved_m, 5.0),
            (moved_to, left, moved_to, left + moved_m, 5.0),
        ]
    for x in (-6.0, 5.0, 13.0, 26.0, 33.0, 58.0, 70.0):
        found += [(x, right, x, right + 1.2, 4.0), (x, right + 1.2, x + 1.0, right + 1.2, 4.0)]
        found += [(x + 1.0, right + 1.2, x + 1.0, right, 4.0)]
    return found


def car(x: float) -> list[Wall]:
    """Four metres of a car in the other lane, of which the near side is seen."""
    return [(x, 3.0, x + 4.0, 3.0, 1.5), (x, 3.0, x, 4.8, 1.5), (x + 4.0, 3.0, x + 4.0, 4.8, 1.5)]


def scan(pose: Sequence[float], scene: Sequence[Wall], rng: np.random.Generator) -> Array:
    """(n, 3) points in the base frame at pose x, y, yaw; the ground is at 0."""
    x, y, yaw = pose
    angles = _AZIMUTHS + rng.uniform(0.0, math.radians(1.0))
    rays = np.stack([np.cos(yaw + angles), np.sin(yaw + angles)], axis=1)
    table = np.array(scene)
    starts, ways = table[:, :2] - (x, y), table[:, 2:4] - table[:, :2]
    cross = rays[:, None, 0] * ways[None, :, 1] - rays[:, None, 1] * ways[None, :, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        flat = (starts[:, 0] * ways[:, 1] - starts[:, 1] * ways[:, 0]) / cross
        along = (starts[None, :, 0] * rays[:, None, 1] - starts[None, :, 1] * rays[:, None, 0]) / cross
    flat[~((along >= 0.0) & (along <= 1.0) & (flat > 0.0))] = np.inf
    slope = np.tan(_RINGS)
    heights = _MAST_M + flat[:, :, None] * slope[None, None, :]
    flat3 = np.where((heights >= 0.0) & (heights <= table[None, :, 4, None]), flat[:, :, None], np.inf)
    nearest = flat3.min(axis=1)
    with np.errstate(divide="ignore"):
        ground = np.where(slope < 0.0, -_MAST_M / slope, np.inf)
    nearest = np.minimum(nearest, ground[None, :])
    hit = np.isfinite(nearest) & (nearest < 45.0)
    nearest = nearest + rng.normal(0.0, 0.01, nearest.shape)
    z = _MAST_M + nearest * slope[None, :]
    points = np.stack([nearest * np.cos(angles)[:, None], nearest * np.sin(angles)[:, None], z], axis=2)
    return points[hit]


def write_drive(
    folder: Path, scene: Sequence[Wall], seed: int = 1, name: str = "drive-0", offset_y_m: float = 0.0,
    cars: Sequence[float] = (), origin: Origin = ORIGIN, step_m: float = 0.5, fixes: bool = True,
    request_id: str = "scans-1", campus_id: str = "snow-lion",
) -> list[Path]:  # fmt: skip
    """Two parcels of one drive along the street. cars: where one stands at each scan."""
    rng = np.random.default_rng(seed)
    folder.mkdir(parents=True, exist_ok=True)
    xs = np.arange(0.0, LENGTH_M, step_m)
    paths = []
    for number, part in enumerate(np.array_split(np.arange(len(xs)), 2)):
        path = folder / f"{name}-{number}.zip"
        writer = ParcelWriter(path)
        fix_rows, pose_rows = [], []
        for one in part:
            pose = (xs[one], offset_y_m + 0.3 * math.sin(xs[one] / 9.0), 0.033 * math.cos(xs[one] / 9.0))
            stamp_ns = 5_000_000_000_000 + int(one) * 125_000_000
            standing = [wall for x in cars[one : one + 1] for wall in car(x)]
            writer.add_scan(stamp_ns, scan(pose, [*scene, *standing], rng))
            latitude, longitude = unproject(
                origin, pose[0] + rng.normal(0, 0.01), pose[1] + rng.normal(0, 0.01)
            )
            fix_rows.append(FixRow(stamp_ns, latitude, longitude, 0.02))
            pose_rows.append(PoseRow(stamp_ns, *pose, 4.0))
        first, last = (5_000_000_000_000 + int(part[at]) * 125_000_000 for at in (0, -1))
        header = ParcelHeader(
            1, request_id, "shuttle-1", campus_id, name, number, origin, "map-1", "", len(part),
            step_m * (len(part) - 1), first, last,
        )  # fmt: skip
        writer.finish(header, fix_rows if fixes else [], pose_rows)
        paths.append(path)
    return paths
