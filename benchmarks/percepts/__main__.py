"""What percepts are worth for safety: `python -m benchmarks.percepts [--seeds N] [--json F]`.

A vehicle drives over a campus with four lidars of 16 beams, among people, cyclists and vehicles who hide each
other and come from behind parked vehicles, trees and walls. Of each road user in each scan it is asked: is
there a track on it, and is there an obstacle cell on it? Tracks come from clusters and network; cells come
from the points alone, and guard and gate stop for them whatever the network thinks.

Those count that are in the reach of the chain's grid: 35 m ahead, 12 m behind, 15 m to each side. The rows
are by range and by how much of the road user is seen: its returns, as a share of those of one in full view.

missed_pct    without a track
unnamed_pct   with a track of another kind only, of the tracked ones
no_cell_pct   without an obstacle cell
neither_pct   with neither: nothing on board knows that something stands there
velocity_rms_mps  deviation of the velocity of tracks with its kind

A road user who comes into view or reach (five returns, after a second with fewer) has a delay until the first
track and the first cell.
"""

import argparse
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from multiprocessing import get_context
from pathlib import Path

import numpy as np

from benchmarks.percepts.drives import sightings_of_drive
from benchmarks.percepts.sightings import (
    RETURNS_MIN,
    Appearance,
    Sighting,
    appearances,
    seen_shares,
)
from benchmarks.reporting.report import Row, RunReport
from vehicle_agent.perception.pillars.detector_file import DEFAULT_DETECTOR
from vehicle_agent.signals import CYCLIST, PEDESTRIAN, TRACK_KINDS, VEHICLE

_ROOT = Path(__file__).resolve().parents[2]
_RANGES_M = ((0.0, 10.0), (10.0, 20.0), (20.0, 30.0))
_SHARES = ((0.6, "in full view"), (0.2, "partly hidden"), (0.0, "mostly hidden"))
_KINDS = (PEDESTRIAN, CYCLIST, VEHICLE)
_SCAN_S = 0.1


def main() -> None:
    report = RunReport()
    arguments = _arguments()
    seeds = range(arguments.first_seed, arguments.first_seed + arguments.seeds)
    drive = partial(sightings_of_drive, arguments)
    if arguments.jobs > 1:
        with ProcessPoolExecutor(arguments.jobs, get_context("spawn")) as pool:
            drives = list(pool.map(drive, seeds))
    else:
        drives = [drive(seed) for seed in seeds]
    found = [one for sighted in drives for one in sighted]
    views = [view for sighted in drives for view in appearances(sighted)]
    rows = [*_missed(found), *_delays(views)]
    people = [row for row in rows if row["road_user"] == TRACK_KINDS[PEDESTRIAN]]
    near = [row for row in people if row["range_m"] in ("0 to 10", "10 to 20")]
    full = [row for row in near if row["view"] == "in full view"]
    summary: Row = {
        "people_in_view_missed_20m_pct": _share(full, "missed_pct"),
        "people_in_view_no_cell_20m_pct": _share(full, "no_cell_pct"),
        "people_neither_20m_pct": _share(near, "neither_pct"),
        "people_velocity_rms_20m_mps": _velocity_rms_mps(
            [one for one in found if one.kind == PEDESTRIAN and one.range_m < 20.0]
        ),
        "people_track_delay_p95_s": people[-1]["track_delay_p95_s"],
        "people_cell_delay_p95_s": people[-1]["cell_delay_p95_s"],
    }
    plain = {
        "map": str(arguments.map), "turns": arguments.turns, "seeds": arguments.seeds,
        "first_seed": arguments.first_seed, "detector": str(arguments.detector),
    }  # fmt: skip
    report.write(arguments.json, "percepts", plain, rows, summary)


def _missed(found: list[Sighting]) -> list[Row]:
    shares = seen_shares(found)
    rows: list[Row] = []
    for kind in _KINDS:
        for from_m, to_m in _RANGES_M:
            for number, (least, view) in enumerate(_SHARES):
                most = _SHARES[number - 1][0] if number else np.inf
                some = [
                    one
                    for one, share in zip(found, shares, strict=True)
                    if one.kind == kind
                    and from_m <= one.range_m < to_m
                    and least <= share < most
                    and one.returns > 0
                ]
                rows.append(
                    {
                        "road_user": TRACK_KINDS[kind],
                        "range_m": f"{from_m:.0f} to {to_m:.0f}",
                        "view": view,
                        "scans": len(some),
                        "missed_pct": _pct([not one.tracked for one in some]),
                        "unnamed_pct": _pct([not one.named for one in some if one.tracked]),
                        "no_cell_pct": _pct([not one.in_cells for one in some]),
                        "neither_pct": _pct([not (one.tracked or one.in_cells) for one in some]),
                        "velocity_rms_mps": _velocity_rms_mps(some),
                    }
                )
    return rows


def _delays(views: list[Appearance]) -> list[Row]:
    rows: list[Row] = []
    for kind in _KINDS:
        some = [view for view in views if view.kind == kind]
        track = [view.track_after * _SCAN_S for view in some if view.track_after is not None]
        cell = [view.cell_after * _SCAN_S for view in some if view.cell_after is not None]
        rows.append(
            {
                "road_user": TRACK_KINDS[kind],
                "range_m": "comes into view",
                "view": f"{RETURNS_MIN} returns",
                "scans": len(some),
                "track_delay_median_s": _quantile(track, 50),
                "track_delay_p95_s": _quantile(track, 95),
                "never_tracked": sum(view.track_after is None for view in some),
                "cell_delay_median_s": _quantile(cell, 50),
                "cell_delay_p95_s": _quantile(cell, 95),
                "never_in_cells": sum(view.cell_after is None for view in some),
            }
        )
    return rows


def _pct(values: list[bool]) -> float | None:
    return 100.0 * float(np.mean(values)) if values else None


def _velocity_rms_mps(found: list[Sighting]) -> float | None:
    off = [one.velocity_off_mps for one in found if one.velocity_off_mps is not None]
    return float(np.sqrt(np.mean(np.square(off)))) if off else None


def _quantile(values: list[float], quantile: float) -> float | None:
    return float(np.percentile(values, quantile)) if values else None


def _share(rows: list[Row], key: str) -> float | None:
    """The mean of a column, by scans."""
    told = [(float(row[key] or 0.0), int(row["scans"] or 0)) for row in rows]
    scans = sum(count for _, count in told)
    return sum(value * count for value, count in told) / scans if scans else None


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="benchmarks.percepts", description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--map", type=Path, default=_ROOT / "maps/snow-lion/map.json")
    parser.add_argument("--profile", type=Path, default=_ROOT / "vehicle_agent/profiles/campus-shuttle.toml")
    parser.add_argument("--turns", type=int, default=300, help="of each drive")
    parser.add_argument("--speed-mps", type=float, default=3.0)
    parser.add_argument("--seeds", type=int, default=6, help="drives")
    parser.add_argument("--first-seed", type=int, default=301, help="nothing was tuned on seeds from 300 on")
    parser.add_argument("--jobs", type=int, default=1, help="drives at a time")
    parser.add_argument("--detector", type=Path, default=DEFAULT_DETECTOR, help="a detector's file")
    parser.add_argument("--json", type=Path, help="where to write the report")
    return parser.parse_args()


if __name__ == "__main__":
    main()
