"""The rows of scan-to-map localization: its error in outages, in a changed world, and after kidnappings."""

from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np

from benchmarks.localization.campus_way import campus_way
from benchmarks.localization.drive import is_outage
from benchmarks.localization.scan_drive import (
    SCAN_CONDITIONS,
    ScanConditions,
    ScanDrive,
    map_of_way,
    scan_drive,
)
from benchmarks.mapping.campus_drive import Trace, trace
from benchmarks.reporting.report import Row
from contract.roads.model import RoadMap
from vehicle_agent.config import load_profile
from vehicle_agent.localization.gnss_ins import GnssInsLocalization
from vehicle_agent.localization.scan_map.fusion import ScanMapLocalization
from vehicle_agent.stacks.choice import build_car
from vehicle_agent.stacks.rooms import rear_slip_per_mps2

_PROFILE = Path(__file__).resolve().parents[2] / "vehicle_agent" / "profiles" / "snow-lion.toml"
# 95 % of a chi-square variable with two degrees of freedom.
_NEES_MAX = 5.99
_SETTLE_TICKS = 3_000
_TICKS_PER_10H = 10 * 3600 * 50


def scan_map_rows(road_map: RoadMap, km: float, runs: int, seed: int) -> tuple[list[Row], dict[str, float]]:
    """(rows, summary) of so many ways of so many km."""
    profile = load_profile(_PROFILE)
    gnss = build_car(profile, road_map).localization
    assert isinstance(gnss, GnssInsLocalization)
    room = ScanMapLocalization(gnss)
    rows: list[Row] = []
    for number in range(seed, seed + runs):
        rng = np.random.default_rng([number, 3])
        way = campus_way(road_map, km, min(3.5, profile.limits.speed_mps_max), rng)
        driven = trace(way, rear_slip_per_mps2(profile) * float(rng.uniform(0.5, 1.5))).until(1e3 * km)
        tiles = map_of_way(road_map, driven, number)
        print(f"scan map, seed {number}: mapped", flush=True)
        with ProcessPoolExecutor(len(SCAN_CONDITIONS)) as pool:
            works = [
                pool.submit(scan_drive, driven, room, tiles, road_map, conditions, number)
                for conditions in SCAN_CONDITIONS
            ]
            for conditions, work in zip(SCAN_CONDITIONS, works, strict=True):
                rows.append(_row(conditions, number, driven, work.result()))
                print(rows[-1], flush=True)
    return rows, _summary(rows)


def _row(conditions: ScanConditions, seed: int, way: Trace, one: ScanDrive) -> Row:
    drive, settled = one.drive, slice(min(_SETTLE_TICKS, len(one.lost) // 4), None)
    row: dict[str, float | int | str] = {
        "stack": "snow_lion",
        "conditions": conditions.name,
        "seed": seed,
        "km": round(float(way.odometer_m[-1]) / 1e3, 2),
        "p95_ms": round(1e3 * float(np.percentile(one.scan_cpu_s, 95)), 1),
        "tick_p95_ms": round(1e3 * float(np.percentile(drive.cpu_s, 95)), 3),
        "agreement_p1": round(float(np.percentile(one.agreement, 1)), 3),
    }
    if conditions.kidnaps:
        row |= {"kidnaps": len(one.kidnaps), "found": sum(one.kidnaps)}
        return row
    error_m, nees = drive.error_m[settled], drive.nees[settled]
    # A false alarm is a time of being lost that begins while the pose is right.
    begins = np.flatnonzero(np.diff(one.lost, prepend=0.0) > 0.0)
    way_m = way.odometer_m[: len(drive.error_m)]
    silent = np.array([is_outage(float(x), conditions.receiver) for x in way_m])
    silent[: settled.start] = False
    if silent.any():
        outage_m = drive.error_m[silent]
        row |= {"outage_rmse_m": round(float(np.sqrt(np.mean(outage_m**2))), 3)}
        row |= {"outage_nees_mean": round(float(drive.nees[silent].mean()), 2)}
    return row | {
        "rmse_m": round(float(np.sqrt(np.mean(error_m**2))), 3),
        "p99_m": round(float(np.percentile(error_m, 99)), 3),
        "worst_m": round(float(error_m.max()), 3),
        "nees_in_bounds_pct": round(100.0 * float(np.mean(nees <= _NEES_MAX)), 1),
        "full_speed_pct": round(100.0 * float(np.mean(drive.drivable[settled])), 1),
        "false_alarms": int((drive.error_m[begins] < 0.3).sum()),
        "ticks": len(drive.error_m),
    }


def _summary(rows: list[Row]) -> dict[str, float]:
    """The worst of each figure over all rows."""

    def worst(name: str) -> float:
        return max((float(row[name] or 0.0) for row in rows if name in row), default=0.0)

    kidnaps = sum(int(row.get("kidnaps") or 0) for row in rows)
    found = sum(int(row.get("found") or 0) for row in rows)
    ticks = sum(int(row.get("ticks") or 0) for row in rows)
    alarms = sum(int(row.get("false_alarms") or 0) for row in rows)
    bounds = [float(row["nees_in_bounds_pct"] or 0.0) for row in rows if "nees_in_bounds_pct" in row]
    found_pct = {"scan_map.lost_found_pct": round(100.0 * found / kidnaps, 1)} if kidnaps else {}
    return {
        "scan_map.rmse_m": worst("rmse_m"),
        "scan_map.outage_rmse_m": worst("outage_rmse_m"),
        "scan_map.p99_m": worst("p99_m"),
        "scan_map.p95_ms": worst("p95_ms"),
        "scan_map.nees_in_bounds_pct": min(bounds, default=0.0),
        "scan_map.false_alarms_per_10h": round(alarms * _TICKS_PER_10H / max(1, ticks), 2),
        **found_pct,
    }
