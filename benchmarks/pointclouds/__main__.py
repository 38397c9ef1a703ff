"""What perception from points finds in annotated sweeps: `python -m benchmarks.pointclouds DIR [--json F]`.

DIR has `NAME.pcd` (x, y, z, intensity; metres, sensor frame, z up) beside `NAME.csv` (class, x, y, z, length,
width, height, yaw, track; the same frame). Height and tilt of the sensor are estimated. Each row is a range:

boxes              pedestrians' boxes; with_returns: of them, those that hold a return above the feet
obstacle_pct       of those with returns, the ones with an obstacle cell or object in the box
all_pct            the same of all boxes
five_returns_pct   the same of those with five returns or more
pedestrian_pct     of those with returns, the ones in which an object is called a pedestrian
height_map_pct     of those with returns, the ones with a cell of the plain height map (GEM) in the box
flagged_pct        share of the cells with returns in which an obstacle is; outside_pct: of the cells outside
                   all boxes; height_map_flagged_pct: the plain height map's share
"""

import argparse
import sys
import time
from pathlib import Path

import numpy as np

from benchmarks.pointclouds.annotations import AnnotationError, Annotations, read_annotations
from benchmarks.pointclouds.sweep import SweepResult, grid_around, judged
from benchmarks.reporting.report import Row, RunReport
from vehicle_agent.perception.points.level import NoGroundError
from vehicle_agent.signals import PEDESTRIAN
from workshop.clouds.errors import CloudFileError
from workshop.clouds.pcd import read_pcd

_RANGES_M = ((0.0, 10.0), (10.0, 20.0), (20.0, 30.0), (30.0, 40.0), (0.0, 30.0))
_POINTS_MIN = 100


class SweepError(Exception):
    """A sweep that cannot be judged; the message says why."""


def main() -> None:
    arguments = _arguments()
    report = RunReport()
    sweeps = sorted(arguments.folder.rglob("*.pcd")) if arguments.folder.is_dir() else []
    if not sweeps:
        sys.exit(f"{arguments.folder} has no .pcd file")
    results, times_ms, skipped, tracks = [], [], [], set()
    grid = grid_around(arguments.own_m, arguments.above_m)
    for path in sweeps:
        try:
            points, boxes = read_sweep(path)
            begun_s = time.process_time()
            results.append(judged(points, boxes, grid))
            times_ms.append(1e3 * (time.process_time() - begun_s))
            tracks.update(zip(boxes.names, boxes.tracks, strict=True))
        except (SweepError, NoGroundError) as error:
            skipped.append(path.name)
            print(f"left out: {path.name}: {error}", file=sys.stderr)
    if not results:
        sys.exit(f"none of {len(sweeps)} sweeps can be judged")
    rows = [row_of(results, near_m, far_m) for near_m, far_m in _RANGES_M]
    within_30 = rows[-1]
    summary: Row = {
        "pedestrian_recall_30m": within_30["obstacle_pct"],
        "flagged_pct": within_30["flagged_pct"],
        "flagged_outside_boxes_pct": within_30["outside_pct"],
        "called_pedestrian_30m": within_30["pedestrian_pct"],
        "sweeps": len(results),
        "left_out": len(skipped),
        "tracks": len(tracks),
    }
    plain = {"folder": str(arguments.folder), "own_m": arguments.own_m, "above_m": arguments.above_m}
    report.write(arguments.json, "pointclouds", plain, rows, summary)


def read_sweep(path: Path) -> tuple[np.ndarray, Annotations]:
    """((n, 3) points, boxes) of NAME.pcd and the NAME.csv beside it. Raises SweepError."""
    beside = path.with_suffix(".csv")
    if not beside.exists():
        raise SweepError(f"{beside.name} is missing")
    try:
        boxes = read_annotations(beside)
        cloud = read_pcd(path)
    except (AnnotationError, CloudFileError) as error:
        raise SweepError(str(error)) from error
    if len(cloud) < _POINTS_MIN:
        raise SweepError(f"has {len(cloud)} points; {_POINTS_MIN} are needed")
    for reason, count in boxes.left_out.items():
        print(f"{beside.name}: {count} rows left out: {reason}", file=sys.stderr)
    return cloud.points_sensor, boxes


def row_of(results: list[SweepResult], near_m: float, far_m: float) -> Row:
    """The figures of the pedestrians and cells between two ranges, of all sweeps together."""
    boxes = [
        np.column_stack((r.returns, r.as_obstacle, r.as_pedestrian, r.by_height_map))[
            (r.kinds == PEDESTRIAN) & (r.ranges_m >= near_m) & (r.ranges_m < far_m)
        ]
        for r in results
    ]
    people = np.concatenate(boxes)
    cells = np.concatenate(
        [
            np.column_stack((r.flagged, r.flagged_by_height_map, r.in_box))[
                (r.cell_ranges_m >= near_m) & (r.cell_ranges_m < far_m)
            ]
            for r in results
        ]
    )
    met = people[:, 0] >= 1
    return {
        "range_m": f"{near_m:g} to {far_m:g}",
        "boxes": len(people),
        "with_returns": int(met.sum()),
        "obstacle_pct": _percent(people[met, 1]),
        "all_pct": _percent(people[:, 1]),
        "five_returns_pct": _percent(people[people[:, 0] >= 5, 1]),
        "pedestrian_pct": _percent(people[met, 2]),
        "height_map_pct": _percent(people[met, 3]),
        "cells": len(cells),
        "flagged_pct": _percent(cells[:, 0]),
        "outside_pct": _percent(cells[~cells[:, 2].astype(bool), 0]),
        "height_map_flagged_pct": _percent(cells[:, 1]),
    }


def _percent(values: np.ndarray) -> float | None:
    return 100.0 * float(values.mean()) if len(values) else None


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="benchmarks.pointclouds", description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("folder", type=Path)
    parser.add_argument("--own-m", type=float, default=2.5, help="the vehicle reaches so far from its sensor")
    parser.add_argument("--above-m", type=float, default=2.4, help="what is higher passes over a shuttle")
    parser.add_argument("--json", type=Path, help="where to write the report")
    return parser.parse_args()


if __name__ == "__main__":
    main()
