"""What a mapped log leaves in a folder: the map, the drive, the residuals, a picture.

map.yaml, map.pgm  the occupancy map (contract/occupancy/map_files.py)
trajectory.csv     the laser's pose at every scan, in the map frame
report.json        where the map comes from, its hash, and its residuals
picture.png        map, drive and loops for a person to look at
"""

import json
from pathlib import Path

import msgspec
import numpy as np

from contract.occupancy.map_files import write_map
from contract.occupancy.occupancy_map import FORMAT, FREE, OCCUPIED
from workshop.carmen.laser_logs import LaserLog
from workshop.laser_mapping.mapping import LaserMap

MAP, TRAJECTORY, REPORT, PICTURE = "map.yaml", "trajectory.csv", "report.json", "picture.png"
_PICTURE_PIXELS_MAX = 3000.0
_PIXELS_PER_INCH = 100.0


def write_map_folder(folder: Path, laser_map: LaserMap, log: LaserLog, log_name: str) -> list[Path]:
    """The files written, the map first. Raises OSError."""
    folder.mkdir(parents=True, exist_ok=True)
    write_map(laser_map.occupancy, folder / MAP)
    _write_trajectory(folder / TRAJECTORY, laser_map)
    report = {
        "format": FORMAT,
        "log": log_name,
        "notes": list(log.notes),
        "map_hash": laser_map.occupancy.map_hash,
        "cell_m": laser_map.occupancy.cell_m,
        "residuals": msgspec.structs.asdict(laser_map.residuals),
    }
    (folder / REPORT).write_text(json.dumps(report, indent=2, allow_nan=False) + "\n", encoding="utf-8")
    _write_picture(folder / PICTURE, laser_map)
    return [folder / name for name in (MAP, TRAJECTORY, REPORT, PICTURE)]


def _write_trajectory(path: Path, laser_map: LaserMap) -> None:
    rows = ["stamp_s,x_m,y_m,yaw_rad"]
    for stamp_s, (x_m, y_m, yaw_rad) in zip(laser_map.stamps_s, laser_map.poses, strict=True):
        rows.append(f"{stamp_s:.6f},{x_m:.4f},{y_m:.4f},{yaw_rad:.5f}")
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")


def _write_picture(path: Path, laser_map: LaserMap) -> None:
    # matplotlib takes a second to import.
    from matplotlib.figure import Figure

    occupancy = laser_map.occupancy
    rows, columns = occupancy.cells.shape
    shades = np.full((rows, columns), 0.8)
    shades[occupancy.cells == FREE] = 1.0
    shades[occupancy.cells == OCCUPIED] = 0.0
    left_m, low_m = occupancy.origin_x_m, occupancy.origin_y_m
    extent = (left_m, left_m + columns * occupancy.cell_m, low_m, low_m + rows * occupancy.cell_m)
    scale = min(1.0, _PICTURE_PIXELS_MAX / max(rows, columns)) / _PIXELS_PER_INCH
    figure = Figure(figsize=(max(6.0, columns * scale), max(4.0, rows * scale)), dpi=_PIXELS_PER_INCH)
    axes = figure.add_subplot()
    axes.imshow(shades, cmap="gray", vmin=0.0, vmax=1.0, origin="lower", extent=extent)
    axes.plot(laser_map.poses[:, 0], laser_map.poses[:, 1], color="tab:red", linewidth=0.8, label="drive")
    for edge in laser_map.loops:
        ends = laser_map.keyframe_poses[[edge.from_, edge.to]]
        axes.plot(ends[:, 0], ends[:, 1], color="tab:blue", linewidth=0.4)
    numbers = laser_map.residuals
    axes.set_title(
        f"{numbers.way_m:.0f} m, {numbers.loops_closed} loops (blue), passes agree within "
        f"{100.0 * numbers.pass_median_m:.1f} cm (median), {100.0 * numbers.pass_p95_m:.1f} cm (95 %)",
        fontsize=9,
    )
    axes.set_xlabel("x (m)")
    axes.set_ylabel("y (m)")
    axes.legend(loc="best", fontsize=8)
    figure.tight_layout()
    figure.savefig(path, metadata={"Software": None})
