"""The rows of the NUS stack with its planar laser: its error in outages, behind trucks, in a changed world,
after kidnappings, and beside each the same drive with GNSS, wheels and gyroscope alone."""

from pathlib import Path

import numpy as np

from benchmarks.localization.campus_way import campus_way
from benchmarks.localization.drive import is_outage
from benchmarks.localization.planar_drive import (
    PLANAR_CONDITIONS,
    PLANAR_DAY,
    PlanarConditions,
    PlanarDrive,
    planar_drive,
    recorded_day,
    tiles_of_way,
)
from benchmarks.localization.scan_rows import alarm_summary, kidnap_row, kidnap_summary
from benchmarks.mapping.campus_drive import Trace, trace
from benchmarks.reporting.report import Row
from contract.roads.model import RoadMap
from vehicle_agent.config import Profile, load_profile
from vehicle_agent.localization.planar_map.field_window import OccupancyTiles
from vehicle_agent.localization.planar_map.warm import warm_planar_map
from vehicle_agent.stacks.nus import planar_localization, planar_matcher
from vehicle_agent.stacks.rooms import rear_slip_per_mps2
from workshop.laser_mapping.site_mapping import SiteMap, SiteMappingParams

_PROFILE = Path(__file__).resolve().parents[2] / "vehicle_agent" / "profiles" / "nus-cart.toml"
# 95 % of a chi-square variable with two degrees of freedom.
_NEES_MAX = 5.99
_SETTLE_TICKS = 3_000
# Nearer to the truth than this an alarm is false.
_RIGHT_M = 0.3
# Further days have seeds of their own.
_DAYS_FROM = 5_000
_SITE = SiteMappingParams()


def planar_rows(
    road_map: RoadMap, km: float, runs: int, seed: int, days: int = 0
) -> tuple[list[Row], dict[str, float]]:
    """(rows, summary) of so many ways of so many km, each on the map of its own survey; each way is driven on
    so many further days."""
    profile = load_profile(_PROFILE)
    warm_planar_map()
    rows: list[Row] = []
    drives: list[tuple[PlanarConditions, PlanarDrive]] = []
    for number in range(seed, seed + runs):
        rng = np.random.default_rng([number, 3])
        way = campus_way(road_map, km, profile.limits.speed_mps_max, rng)
        driven = trace(way, rear_slip_per_mps2(profile) * float(rng.uniform(0.5, 1.5))).until(1e3 * km)
        site = tiles_of_way(road_map, driven, profile, number)
        print(f"planar laser, seed {number}: mapped, {site.residuals}", flush=True)
        works = [(conditions.on_day(number), number) for conditions in PLANAR_CONDITIONS]
        days_from = number + _DAYS_FROM
        works += [(PLANAR_DAY.on_day(days_from + day), days_from + day) for day in range(days)]
        for conditions, day in works:
            some, drive = _rows(road_map, profile, driven, site, conditions, day)
            rows += some
            drives.append((conditions, drive))
            print(some[0], flush=True)
    return rows, _summary(drives)


def _rows(
    road_map: RoadMap, profile: Profile, way: Trace, site: SiteMap, conditions: PlanarConditions, seed: int
) -> tuple[list[Row], PlanarDrive]:
    """With the laser, and the same day without it."""
    day, room = recorded_day(way, road_map, profile, conditions, seed), planar_localization(profile, road_map)
    tiles = OccupancyTiles(
        lambda ix, iy: site.tiles.get((ix, iy)), _SITE.tile_m, _SITE.occupancy.cell_m, tuple(site.tiles)
    )
    one = planar_drive(day, room, planar_matcher(profile, tiles, seed), seed)
    rows = [_row(conditions, "own", seed, way, one)]
    if conditions.kidnapping is None and seed < _DAYS_FROM:
        rows.append(_row(conditions, "GNSS/INS alone", seed, way, planar_drive(day, room, None, seed)))
    return rows, one


def _row(conditions: PlanarConditions, by: str, seed: int, way: Trace, one: PlanarDrive) -> Row:
    drive, settled = one.drive, slice(min(_SETTLE_TICKS, len(one.lost) // 4), None)
    row: dict[str, float | int | str] = {
        "stack": "nus",
        "conditions": f"{conditions.name}, {by}",
        "seed": seed,
        "km": round(float(way.odometer_m[-1]) / 1e3, 2),
        "tick_p95_ms": round(1e3 * float(np.percentile(drive.cpu_s, 95)), 3),
    }
    if len(one.scan_cpu_s):
        row |= {
            "p95_ms": round(1e3 * float(np.percentile(one.scan_cpu_s, 95)), 1),
            "worst_ms": round(1e3 * float(one.scan_cpu_s.max()), 1),
            "agreement_p1": round(float(np.percentile(one.agreement, 1)), 3),
        }
    if conditions.kidnapping is not None:
        return row | kidnap_row(one.kidnaps)
    error_m, nees = drive.error_m[settled], drive.nees[settled]
    silent = np.array(
        [is_outage(float(x), conditions.receiver) for x in way.odometer_m[: len(drive.error_m)]]
    )
    silent[: settled.start] = False
    if silent.any():
        row |= {"outage_rmse_m": round(float(np.sqrt(np.mean(drive.error_m[silent] ** 2))), 3)}
    return row | {
        "rmse_m": round(float(np.sqrt(np.mean(error_m**2))), 3),
        "p99_m": round(float(np.percentile(error_m, 99)), 3),
        "worst_m": round(float(error_m.max()), 3),
        "nees_in_bounds_pct": round(100.0 * float(np.mean(nees <= _NEES_MAX)), 1),
        "full_speed_pct": round(100.0 * float(np.mean(drive.drivable[settled])), 1),
        "false_alarms": _false_alarms(one),
        "ticks": len(drive.error_m),
    }


def _false_alarms(one: PlanarDrive) -> int:
    """Times of being lost that begin while the pose is right."""
    begins = np.flatnonzero(np.diff(one.lost, prepend=0.0) > 0.0)
    return int((one.drive.error_m[begins] < _RIGHT_M).sum())


def _summary(drives: list[tuple[PlanarConditions, PlanarDrive]]) -> dict[str, float]:
    """Over all ticks with the laser but those under an open sky, which is easy, and those of kidnappings."""
    free = [(conditions, one) for conditions, one in drives if conditions.kidnapping is None]
    hard = [one for conditions, one in free if not conditions.receiver.open_sky]
    settled = [slice(min(_SETTLE_TICKS, len(one.lost) // 4), None) for one in hard]
    errors = np.concatenate([one.drive.error_m[part] for one, part in zip(hard, settled, strict=True)])
    nees = np.concatenate([one.drive.nees[part] for one, part in zip(hard, settled, strict=True)])
    cpu_s = np.concatenate([one.scan_cpu_s for one in hard])
    return {
        "nus.rmse_m": round(float(np.sqrt(np.mean(errors**2))), 3),
        "nus.p99_m": round(float(np.percentile(errors, 99)), 3),
        "nus.p95_ms": round(1e3 * float(np.percentile(cpu_s, 95)), 1),
        "nus.nees_in_bounds_pct": round(100.0 * float(np.mean(nees <= _NEES_MAX)), 1),
        **alarm_summary(
            "nus", sum(_false_alarms(one) for _, one in free), sum(len(one.lost) for _, one in free)
        ),
        **kidnap_summary("nus", [one for _, drive in drives for one in drive.kidnaps]),
    }
