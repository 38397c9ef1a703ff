"""How exactly sensors are calibrated: `python -m benchmarks.calibration [DIR] [--simulated N] [--json F]`.

--simulated N: random vehicles at random wall corners, scanned with real beams and noise, of whose poses
nothing is given; a quarter stand where the poses cannot be determined (one wall, a street), which must be
refused. DIR: real vehicles, a folder each (`campusloop workshop calibrate` says how); the residuals at the
given poses and at ours, on the reference's own surfaces, and a thickness that is not optimised.
--simulated-imu N: random vehicles with a lidar and an inertial unit on random drives, through the simulator's
sensors; every sixth stands or goes straight, which must be refused.
"""

import argparse
import math
import os
import time
from pathlib import Path

import numpy as np

from benchmarks.calibration.corner import View, simulated_rig
from benchmarks.calibration.motion_rows import motion_row, motion_summary
from benchmarks.reporting.report import Row, RunReport, Value
from contract.geometry import Array
from contract.transforms import apart
from workshop.calibration.calibrate import calibrate
from workshop.calibration.errors import CalibrationError
from workshop.calibration.registration import surfaces_of
from workshop.calibration.residuals import residual
from workshop.calibration.rigs import load_rig
from workshop.clouds import bags
from workshop.clouds.recordings import READERS

# Of eight vehicles six stand at a corner.
_VIEWS: tuple[View, ...] = ("corner",) * 6 + ("one_wall", "street")


def main() -> None:
    report = RunReport()
    arguments = _arguments()
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    rows: list[Row] = []
    summary: dict[str, Value] = {}
    if arguments.simulated:
        simulated = [
            _simulated(seed)
            for seed in range(arguments.first_seed, arguments.first_seed + arguments.simulated)
        ]
        rows += simulated
        summary |= _simulated_summary(simulated)
    if arguments.simulated_imu:
        drives = [motion_row(arguments.first_seed + number) for number in range(arguments.simulated_imu)]
        rows += drives
        summary |= motion_summary(drives)
    if arguments.folder is not None:
        real = [row for folder in _rig_folders(arguments.folder) for row in _real(folder)]
        rows += real
        summary |= _real_summary(real)
    plain = {
        "folder": str(arguments.folder), "simulated": arguments.simulated,
        "simulated_imu": arguments.simulated_imu, "first_seed": arguments.first_seed, "cores_used": 1,
    }  # fmt: skip
    report.write(arguments.json, "calibration", plain, rows, summary)


def _simulated(seed: int) -> Row:
    """One vehicle; its worst lidar."""
    view = _VIEWS[seed % len(_VIEWS)]
    rig = simulated_rig(view, np.random.default_rng(seed))
    names = [f"lidar {number}" for number in range(len(rig.clouds))]
    row: dict[str, Value] = {"seed": seed, "view": view, "lidars": ", ".join(rig.models)}
    began_cpu, began_wall = time.process_time(), time.perf_counter()
    errors: list[tuple[float, float]] = []
    refused = ""
    try:
        found = calibrate(names, rig.clouds, [None] * len(names))
        errors = [apart(ours, true) for ours, true in zip(found.transforms[1:], rig.truth[1:], strict=True)]
    except CalibrationError as error:
        refused = error.code
    times = {"cpu_s": time.process_time() - began_cpu, "wall_s": time.perf_counter() - began_wall}
    error_m = max((metres for metres, _ in errors), default=None)
    error_deg = max((math.degrees(angle) for _, angle in errors), default=None)
    return row | {"refused": refused, "error_m": error_m, "error_deg": error_deg, **times}


def _simulated_summary(rows: list[Row]) -> dict[str, Value]:
    """p95 over vehicles at corners, each by its worst lidar; a refused one counts as infinitely wrong."""
    corners = [row for row in rows if row["view"] == "corner"]
    others = [row for row in rows if row["view"] != "corner"]
    summary: dict[str, Value] = {"corners": len(corners)}
    for key in ("error_m", "error_deg"):
        errors = [math.inf if row["refused"] else float(row[key] or 0.0) for row in corners]
        for name, share in (("p50", 50.0), ("p95", 95.0), ("max", 100.0)):
            value = float(np.percentile(errors, share, method="higher")) if errors else math.inf
            summary[f"{name}_{key.removeprefix('error_')}"] = value if math.isfinite(value) else None
    summary["corners_refused"] = sum(bool(row["refused"]) for row in corners)
    summary["degenerate"] = len(others)
    summary["degenerate_accepted"] = sum(not row["refused"] for row in others)
    summary["cpu_s_mean"] = float(np.mean([float(row["cpu_s"] or 0.0) for row in rows]))
    return summary


def _rig_folders(path: Path) -> list[Path]:
    """The folder or bag itself, or the folders and bags in it that are vehicles."""
    if bags.is_bag(path) or _is_rig(path):
        return [path]
    return [folder for child in sorted(path.iterdir()) if child.is_dir() for folder in _rig_folders(child)]


def _is_rig(folder: Path) -> bool:
    scans = [child for child in folder.iterdir() if child.suffix.lower() in READERS]
    poses = any((folder / name).exists() for name in ("initial_extrinsic.txt", "extrinsics.toml"))
    return len(scans) > 1 or poses


def _real(folder: Path) -> list[Row]:
    """A row for each lidar but the reference."""
    rig = load_rig(folder)
    began_cpu, began_wall = time.process_time(), time.perf_counter()
    try:
        found = calibrate(rig.names, rig.clouds, rig.guesses)
    except CalibrationError as error:
        return [{"rig": str(folder), "lidar": ", ".join(rig.names), "refused": error.code}]
    times = {"cpu_s": time.process_time() - began_cpu, "wall_s": time.perf_counter() - began_wall}
    surfaces = surfaces_of(rig.clouds[0])
    rows: list[Row] = []
    for number in range(1, len(rig.names)):
        row: dict[str, Value] = {"rig": str(folder), "lidar": rig.names[number], "refused": ""}

        def add(poses: str, transform: Array, row: dict[str, Value] = row, number: int = number) -> None:
            values = residual(rig.clouds[0], surfaces, rig.clouds[number], transform)
            row |= {f"{poses}_plane_m": values.plane_m, f"{poses}_thickness_m": values.thickness_m}

        add("found", found.transforms[number])
        guess = rig.guesses[number]
        if guess is not None:
            add("given", guess)
        rows.append(row | times)
    return rows


def _real_summary(rows: list[Row]) -> dict[str, Value]:
    """The worst lidar's residuals as shares of those at the given poses."""
    summary: dict[str, Value] = {
        "real_lidars": len(rows),
        "real_refused": sum(bool(row["refused"]) for row in rows),
    }
    for key in ("plane", "thickness"):
        ratios = [
            float(row[f"found_{key}_m"] or 0.0) / float(row[f"given_{key}_m"] or 0.0)
            for row in rows
            if row.get(f"given_{key}_m")
        ]
        summary[f"{key}_ratio_max"] = max(ratios, default=None)
    return summary


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="benchmarks.calibration", description=__doc__)
    parser.add_argument("folder", nargs="?", type=Path, help="of one vehicle, or with a folder for each")
    parser.add_argument("--simulated", type=int, default=0, help="random vehicles")
    parser.add_argument("--simulated-imu", type=int, default=0, help="random drives with an inertial unit")
    parser.add_argument("--first-seed", type=int, default=1_000, help="of the first of them")
    parser.add_argument("--json", type=Path, help="where to write the report")
    arguments = parser.parse_args()
    if not (arguments.simulated or arguments.simulated_imu) and arguments.folder is None:
        parser.error("give a folder of real scans, --simulated N, or --simulated-imu N")
    return arguments


if __name__ == "__main__":
    main()
