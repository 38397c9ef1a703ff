"""What a mapped drive leaves in a folder: tiles and their index, the drive, the residuals, a picture.

index.json, tiles/  the map (contract/point_map/map_files.py)
trajectory.csv      the lidar's pose at every scan, in the map frame
report.json         where the map comes from, its version, its residuals, its parameters
picture.png         the map from above, with drive and loops

All of it is written beside the folder and moved into place as a whole: what fails leaves nothing.
"""

import json
import math
import os
import shutil
from collections.abc import Sequence
from pathlib import Path

import msgspec
import numpy as np

from contract.geometry import Array
from contract.point_map.map_files import PointMapIndex, write_tiles
from contract.point_map.tiles import FORMAT, Surfels, TileError
from workshop.cloud_mapping.mapping import CloudMap, CloudMappingParams
from workshop.cloud_mapping.residuals import trajectory_error_m
from workshop.clouds.poses import read_poses

TRAJECTORY, REPORT, PICTURE = "trajectory.csv", "report.json", "picture.png"
TILE_M = 32.0
_PICTURE_PIXELS_MAX = 3000
# A true pose that is farther from a scan in time is not its.
_STAMP_S = 0.06


class MapFolderError(Exception):
    """The map, or the reference beside it, is not usable; the message is one sentence."""


class Reference(msgspec.Struct, frozen=True):
    """True positions (n, 3), and their stamps (n,) s, or None: one for each scan."""

    places: Array
    stamps_s: Array | None


def read_reference(path: Path) -> Reference:
    """Of a TUM or KITTI file; CloudFileError."""
    poses, stamps_s = read_poses(path)
    return Reference(poses[:, :3, 3], stamps_s)


def tiles_of(surfels: Surfels, tile_m: float = TILE_M) -> dict[tuple[int, int], Surfels]:
    """The elements by tile."""
    if not len(surfels):
        return {}
    at = np.floor(surfels.means[:, :2] / tile_m).astype(np.int64)
    order = np.lexsort((at[:, 1], at[:, 0]))
    at = at[order]
    starts = np.flatnonzero(np.concatenate(([True], (np.diff(at, axis=0) != 0).any(axis=1))))
    ends = np.append(starts[1:], len(at))
    return {
        (int(at[a, 0]), int(at[a, 1])): surfels.selected(order[a:b])
        for a, b in zip(starts, ends, strict=True)
    }


def write_map_folder(
    out: Path, cloud_map: CloudMap, params: CloudMappingParams, names: Sequence[str], notes: Sequence[str],
    reference: Reference | None,
) -> dict[str, float]:  # fmt: skip
    """Writes all files; returns the residuals. Raises OSError, and MapFolderError for an unfit reference."""
    numbers: dict[str, float] = {
        name: float(value) for name, value in msgspec.structs.asdict(cloud_map.residuals).items()
    }
    if reference is not None:
        numbers["ate_m"] = _error_m(cloud_map, reference)
    out.parent.mkdir(parents=True, exist_ok=True)
    fresh = out.parent / f".{out.name}.new-{os.getpid()}"
    try:
        try:
            index = write_tiles(
                fresh, tiles_of(cloud_map.surfels), TILE_M, params.surfaces.voxel_m, cloud_map.origin
            )
        except TileError as error:
            raise MapFolderError(f"The drive makes no map: {error}") from error
        _write_trajectory(fresh / TRAJECTORY, cloud_map)
        _write_report(fresh / REPORT, index, numbers, params, names, notes)
        _write_picture(fresh / PICTURE, cloud_map)
        # An empty folder may be there; one with files was refused before.
        fresh.replace(out)
    except BaseException:
        shutil.rmtree(fresh, ignore_errors=True)
        raise
    return numbers


def _error_m(cloud_map: CloudMap, reference: Reference) -> float:
    places = cloud_map.poses[:, :3, 3]
    if reference.stamps_s is None:
        if len(reference.places) != len(places):
            raise MapFolderError(
                f"The reference has {len(reference.places)} poses without times for {len(places)} scans."
            )
        return trajectory_error_m(places, reference.places)
    stamps_s = 1e-9 * cloud_map.stamps_ns
    order = np.argsort(reference.stamps_s)
    sorted_s = reference.stamps_s[order]
    after = np.clip(np.searchsorted(sorted_s, stamps_s), 1, len(sorted_s) - 1)
    is_before = stamps_s - sorted_s[after - 1] < sorted_s[after] - stamps_s
    nearest = np.where(is_before, after - 1, after)
    same = np.abs(sorted_s[nearest] - stamps_s) < _STAMP_S
    if same.sum() < 3:
        raise MapFolderError("The reference has no time in common with the scans.")
    return trajectory_error_m(places[same], reference.places[order][nearest[same]])


def _write_trajectory(path: Path, cloud_map: CloudMap) -> None:
    rows = ["stamp_s,x_m,y_m,z_m,roll_rad,pitch_rad,yaw_rad"]
    for stamp_ns, pose in zip(cloud_map.stamps_ns.tolist(), cloud_map.poses, strict=True):
        roll = math.atan2(pose[2, 1], pose[2, 2])
        pitch = -math.asin(max(-1.0, min(1.0, float(pose[2, 0]))))
        yaw = math.atan2(pose[1, 0], pose[0, 0])
        x, y, z = pose[:3, 3]
        rows.append(f"{stamp_ns / 1e9:.6f},{x:.4f},{y:.4f},{z:.4f},{roll:.5f},{pitch:.5f},{yaw:.5f}")
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")


def _write_report(
    path: Path, index: PointMapIndex, numbers: dict[str, float], params: CloudMappingParams,
    names: Sequence[str], notes: Sequence[str],
) -> None:  # fmt: skip
    report = {
        "format": FORMAT,
        "recordings": list(names),
        "notes": list(notes),
        "map_version": index.map_version,
        "frame": index.frame,
        "tiles": len(index.tiles),
        "bytes": sum(tile.bytes for tile in index.tiles),
        "residuals": numbers,
        "params": msgspec.to_builtins(params),
    }
    path.write_text(json.dumps(report, indent=2, allow_nan=False) + "\n", encoding="utf-8")


def _write_picture(path: Path, cloud_map: CloudMap) -> None:
    """The greatest height of the elements in each cell, drive in red, loops in blue."""
    # matplotlib takes a second to import.
    from matplotlib.figure import Figure

    means = cloud_map.surfels.means
    low, high = means[:, :2].min(axis=0), means[:, :2].max(axis=0)
    cell_m = max(0.25, float((high - low).max()) / _PICTURE_PIXELS_MAX)
    columns, rows = (np.ceil((high - low) / cell_m).astype(int) + 1).tolist()
    heights = np.full((rows, columns), -np.inf)
    at = np.floor((means[:, :2] - low) / cell_m).astype(int)
    np.maximum.at(heights, (at[:, 1], at[:, 0]), means[:, 2])
    shown = np.ma.masked_invalid(heights)
    bottom, top = np.percentile(means[:, 2], [2.0, 98.0])
    extent = (low[0], low[0] + columns * cell_m, low[1], low[1] + rows * cell_m)
    figure = Figure(figsize=(max(6.0, columns / 150.0), max(4.0, rows / 150.0)), dpi=150)
    axes = figure.add_subplot()
    axes.set_facecolor("black")
    axes.imshow(
        shown, cmap="viridis", vmin=bottom, vmax=top, origin="lower", extent=extent, interpolation="none"
    )
    axes.plot(cloud_map.poses[:, 0, 3], cloud_map.poses[:, 1, 3], color="tab:red", linewidth=0.6)
    for edge in cloud_map.loops:
        ends = cloud_map.keyframe_poses[[edge.from_, edge.to], :2, 3]
        axes.plot(ends[:, 0], ends[:, 1], color="tab:blue", linewidth=0.3)
    numbers = cloud_map.residuals
    axes.set_title(
        f"{numbers.way_m:.0f} m, {numbers.loops_closed} loops, {numbers.fixes_used} fixes", fontsize=9
    )
    axes.set_xlabel("x (m)")
    axes.set_ylabel("y (m)")
    figure.tight_layout()
    figure.savefig(path, metadata={"Software": None})
