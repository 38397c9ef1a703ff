"""The rows of scan-to-map localization: its error in outages, in a changed world, and after kidnappings."""

import math
import os
from concurrent.futures import ProcessPoolExecutor

import numpy as np
from scipy.stats import chi2

from benchmarks.localization.campus_way import beside, campus_way
from benchmarks.localization.drive import is_outage
from benchmarks.localization.scan_drive import (
    DAY,
    SCAN_CONDITIONS,
    TRUCKS,
    ScanConditions,
    ScanDrive,
    map_of_way,
    scan_drive,
)
from benchmarks.localization.sensed_drive import Kidnapped
from benchmarks.mapping.campus_drive import MOUNT_M, Trace, trace
from benchmarks.reporting.report import Row
from contract.roads.model import RoadMap
from vehicle_agent.config import Profile
from vehicle_agent.localization.gnss_ins import GnssInsLocalization
from vehicle_agent.localization.scan_map.fusion import ScanMapLocalization
from vehicle_agent.stacks.choice import build_car
from vehicle_agent.stacks.rooms import rear_slip_per_mps2

# 95 % of a chi-square variable with two degrees of freedom.
_NEES_MAX = 5.99
_SETTLE_TICKS = 3_000
_TICKS_PER_H = 3600 * 50
# Nearer to the truth than this an alarm is false.
_RIGHT_M = 0.3
# From one lane's middle to the other's.
_LANE_M = 3.2
# Further days have seeds of their own.
_DAYS_FROM = 5_000


def scan_map_rows(
    stack: str, profile: Profile, road_map: RoadMap, km: float, runs: int, seed: int, days: int = 0,
    *, trucks: bool = False,
) -> tuple[list[Row], dict[str, float]]:  # fmt: skip
    """(rows, summary) of so many ways of so many km; each way is driven on so many further days.

    The map is the one that a Snow Lion's lidar made, whatever vehicle compares its scans with it.
    """
    mount_m = MOUNT_M if stack == "snow_lion" else (profile.lidar.x_m, profile.lidar.y_m, profile.lidar.z_m)
    gnss = build_car(profile, road_map).localization
    assert isinstance(gnss, GnssInsLocalization)
    room = ScanMapLocalization(gnss)
    rows: list[Row] = []
    drives: list[tuple[ScanConditions, ScanDrive]] = []
    for number in range(seed, seed + runs):
        rng = np.random.default_rng([number, 3])
        way = campus_way(road_map, km, min(3.5, profile.limits.speed_mps_max), rng)
        slip = rear_slip_per_mps2(profile) * float(rng.uniform(0.5, 1.5))
        lanes = {
            "same": trace(way, slip).until(1e3 * km),
            "other": trace(beside(way, 1e3 * km, _LANE_M, back=False), slip),
            "opposite": trace(beside(way, 1e3 * km, _LANE_M, back=True), slip),
        }
        tiles = map_of_way(road_map, lanes["same"], number)
        print(f"{stack}, scan map, seed {number}: mapped", flush=True)
        wanted = [
            conditions.on_day(number) for conditions in (*SCAN_CONDITIONS, *([TRUCKS] if trucks else []))
        ]
        works = [(conditions, number) for conditions in wanted]
        works += [(DAY.on_day(number + _DAYS_FROM + day), number + _DAYS_FROM + day) for day in range(days)]
        with ProcessPoolExecutor(max(1, min(len(works), len(os.sched_getaffinity(0))))) as pool:
            futures = [
                pool.submit(
                    scan_drive, lanes[conditions.lane], room, tiles, road_map, conditions, day, mount_m
                )
                for conditions, day in works
            ]
            for (conditions, day), future in zip(works, futures, strict=True):
                one = future.result()
                drives.append((conditions, one))
                rows.append(_row(stack, conditions, day, lanes[conditions.lane], one))
                print(rows[-1], flush=True)
    return rows, _summary(stack, drives)


def _row(stack: str, conditions: ScanConditions, seed: int, way: Trace, one: ScanDrive) -> Row:
    drive, settled = one.drive, _settled(one)
    row: dict[str, float | int | str] = {
        "stack": stack,
        "conditions": conditions.name,
        "seed": seed,
        "km": round(float(way.odometer_m[-1]) / 1e3, 2),
        "p95_ms": round(1e3 * float(np.percentile(one.scan_cpu_s, 95)), 1),
        "tick_p95_ms": round(1e3 * float(np.percentile(drive.cpu_s, 95)), 3),
        "agreement_p1": round(float(np.percentile(one.agreement, 1)), 3),
    }
    if conditions.kidnapping is not None:
        return row | kidnap_row(one.kidnaps)
    error_m, nees = drive.error_m[settled], drive.nees[settled]
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
        "false_alarms": _false_alarms(one),
        "doubt_max": round(float(one.doubt[settled].max()), 2),
        "ticks": len(drive.error_m),
    }


def _settled(one: ScanDrive) -> slice:
    return slice(min(_SETTLE_TICKS, len(one.lost) // 4), None)


def _false_alarms(one: ScanDrive) -> int:
    """Times of being lost that begin while the pose is right."""
    begins = np.flatnonzero(np.diff(one.lost, prepend=0.0) > 0.0)
    return int((one.drive.error_m[begins] < _RIGHT_M).sum())


def _summary(stack: str, drives: list[tuple[ScanConditions, ScanDrive]]) -> dict[str, float]:
    """Of all drives together; errors, deviations and alarms without the kidnapped drives."""
    free = [one for conditions, one in drives if conditions.kidnapping is None]
    errors = np.concatenate([one.drive.error_m[_settled(one)] for one in free])
    nees = np.concatenate([one.drive.nees[_settled(one)] for one in free])
    kidnaps = [one for _, drive in drives for one in drive.kidnaps]
    alarms = sum(map(_false_alarms, free))
    summary = {
        f"{stack}.rmse_m": round(float(np.sqrt(np.mean(errors**2))), 3),
        f"{stack}.p99_m": round(float(np.percentile(errors, 99)), 3),
        f"{stack}.p95_ms": round(1e3 * max(float(np.percentile(one.scan_cpu_s, 95)) for _, one in drives), 1),
        f"{stack}.nees_in_bounds_pct": round(100.0 * float(np.mean(nees <= _NEES_MAX)), 1),
    }
    summary |= alarm_summary(stack, alarms, sum(len(one.lost) for one in free))
    return summary | kidnap_summary(stack, kidnaps)


def kidnap_row(kidnaps: tuple[Kidnapped, ...]) -> dict[str, float | int | str]:
    right_s = sorted(one.right_s for one in kidnaps)
    return {
        "kidnaps": len(kidnaps),
        "noticed": sum(one.is_noticed for one in kidnaps),
        "right": sum(math.isfinite(one.right_s) for one in kidnaps),
        "right_median_s": right_s[len(right_s) // 2] if right_s else math.nan,
    }


def kidnap_summary(name: str, kidnaps: list[Kidnapped]) -> dict[str, float]:
    """lost_found_pct: slow or right within 2 s; right_pct: right again within 20 s."""
    if not kidnaps:
        return {}
    return {
        f"{name}.kidnaps": len(kidnaps),
        f"{name}.lost_found_pct": round(100.0 * float(np.mean([one.is_noticed for one in kidnaps])), 1),
        f"{name}.right_pct": round(
            100.0 * float(np.mean([math.isfinite(one.right_s) for one in kidnaps])), 1
        ),
    }


def alarm_summary(name: str, alarms: int, ticks: int) -> dict[str, float]:
    """Of so many false alarms in so many ticks; max95 one-sided, of a Poisson process: what they can show."""
    hours = ticks / _TICKS_PER_H
    return {
        f"{name}.hours": round(hours, 2),
        f"{name}.false_alarms": alarms,
        f"{name}.false_alarms_per_10h": round(10.0 * alarms / hours, 2),
        f"{name}.false_alarms_per_10h_max95": round(5.0 * float(chi2.ppf(0.95, 2 * alarms + 2)) / hours, 1),
    }
