"""One simulated drive after the other: how far the found pose and clock are from the true ones."""

import math
import time

import numpy as np

from benchmarks.calibration.motion import MotionDrive, Way
from benchmarks.reporting.report import Row, Value
from workshop.calibration.errors import CalibrationError
from workshop.motion_calibration.calibrate import calibrate_motion
from workshop.motion_calibration.drive import lidar_motion
from workshop.motion_calibration.integration import rotation_vectors

# Of six drives one stands or goes straight, in turn.
_WAYS: tuple[Way, ...] = ("bends",) * 5 + ("straight",) + ("bends",) * 5 + ("stands",)
# A tape measure.
_TAPE_STD_M = 0.02


def motion_row(seed: int) -> Row:
    """One vehicle and its drive; the lever arm is given as a tape measures it."""
    way = _WAYS[seed % len(_WAYS)]
    drive = MotionDrive(seed, way)
    rng = np.random.default_rng([seed, 3])
    tape_m = drive.T_lidar_unit[:3, 3] + rng.normal(0.0, _TAPE_STD_M, 3)
    row: dict[str, Value] = {"seed": seed, "way": way, "lidar": drive.model.name}
    scans, unit = list(drive.clouds()), drive.inertial()
    began_cpu, began_wall = time.process_time(), time.perf_counter()
    try:
        found = calibrate_motion(lidar_motion(scans), unit, tape_m)
    except CalibrationError as error:
        times = {"cpu_s": time.process_time() - began_cpu, "wall_s": time.perf_counter() - began_wall}
        return row | {"refused": error.code} | times
    times = {"cpu_s": time.process_time() - began_cpu, "wall_s": time.perf_counter() - began_wall}
    off = rotation_vectors((found.T_lidar_unit[:3, :3] @ drive.T_lidar_unit[:3, :3].T)[None])[0]
    lever = found.T_lidar_unit[:3, 3] - drive.T_lidar_unit[:3, 3]
    level = lever - found.up * float(found.up @ lever)
    late_s = found.offset_s - drive.offset_s
    return row | {
        "refused": "",
        "error_deg": math.degrees(float(np.linalg.norm(off))),
        "offset_ms": 1e3 * abs(late_s),
        "lever_level_m": float(np.linalg.norm(level)),
        "kept": len(found.kept),
        "rotation_stds": float(np.max(np.abs(off) / found.rotation_std_rad)),
        "offset_stds": abs(late_s) / found.offset_std_s,
        "bends_deg": math.degrees(found.turned_rad),
    } | times  # fmt: skip


def motion_summary(rows: list[Row]) -> dict[str, Value]:
    """Percentiles over the drives with bends that were found; how many were refused, and of which kind."""
    bends = [row for row in rows if row["way"] == "bends"]
    others = [row for row in rows if row["way"] != "bends"]
    found = [row for row in bends if not row["refused"]]
    summary: dict[str, Value] = {"drives": len(bends), "drives_refused": len(bends) - len(found)}
    for key in ("error_deg", "offset_ms", "lever_level_m"):
        values = [float(row[key] or 0.0) for row in found]
        for name, share in (("p50", 50.0), ("p95", 95.0), ("max", 100.0)):
            at = float(np.percentile(values, share, method="higher")) if values else None
            summary[f"{name}_{key}"] = at
    for key in ("rotation_stds", "offset_stds"):
        within = sum(float(row[key] or 0.0) <= 3.0 for row in found)
        summary[f"within_3_{key}"] = within / max(1, len(found))
    summary["undetermined"] = len(others)
    summary["undetermined_accepted"] = sum(not row["refused"] for row in others)
    summary["motion_cpu_s_mean"] = float(np.mean([float(row["cpu_s"] or 0.0) for row in rows]))
    return summary
