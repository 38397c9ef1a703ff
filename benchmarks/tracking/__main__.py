"""Path tracking of each stack: `python -m benchmarks.tracking --json F [LOOP.csv ...]`.

The GEM paper's figure of eight at 3 m/s had a peak cross-track error of 12 cm. Here it is a lemniscate with
the least radius that the paper's own 0.5 m/s2 allows at that speed, 18 m, and two laps of it. The error is
the rear-axle centre's distance from the curve itself.

Every stack drives it on a shuttle with tyres (`simulator/vehicle/tyres.py`), a steering bias of 0.6 degrees,
a steering delay of 0.25 s and a lag, at its nominal weight and 20 % more and less, with localization noise
and with perfect localization. The `gem` stack follows waypoints, which are recorded with the same noise. It
is also driven on the kinematic vehicle: this gives its `peak_cross_track_m`, the other its
`disturbed_peak_cross_track_m`. The `nus` stack's pure pursuit follows the same waypoints at 2 m/s, for which
its look-ahead is set. Stacks that follow trajectories get timed rows of the curve. The reference time is
defined in `benchmarks/tracking/stacks.py`. --plants vehicles are drawn from seeds
(`simulator/vehicle/random_plant.py`); of these a stack knows the profile alone that was identified from one
drive of five minutes (`benchmarks.identify`). Recorded loops are for the `gem` stack.

With --by-scans the known vehicle also drives the curve on a place of a shipped campus, by the stack's own
localization: a lidar's scans on a map of surfaces, for `nus` a planar scanner's on an occupancy map. The maps
are of another day's survey, with other parked vehicles, and the receiver falls silent after a minute. Lidars
are mounted as in the profile.
"""

import argparse
import csv
import math
from pathlib import Path

import numpy as np

from benchmarks.identify.plant_drives import drive_plants
from benchmarks.reporting.report import Row, RunReport
from benchmarks.tracking.reference_paths import ReferencePath, lemniscate, recorded_path
from benchmarks.tracking.scan_sensing import ScannedCurve
from benchmarks.tracking.stacks import (
    KINEMATIC_STACKS,
    STACKS,
    Conditions,
    FollowTask,
    TrackingResult,
)
from benchmarks.tracking.waypoint_drive import Drive
from simulator.sensors.gnss import GnssNoise
from simulator.vehicle.plant import PlantParams, plant_params
from simulator.vehicle.random_plant import random_plant
from vehicle_agent.config import Profile, load_profile
from vehicle_agent.identification.identify import identify

_TRACE = ["t_s", "x_m", "y_m", "yaw_rad", "v_mps", "a_mps2", "steer_rad"]
_PROFILES = Path(__file__).resolve().parents[2] / "vehicle_agent" / "profiles"
_KINEMATIC = "kinematic"
_PERFECT = "perfect localization"
_PLANT = "plant"
_BY_SCANS = "own scans, GNSS silent"
# Of the identification drive before.
_IDENTIFIED_S = 300.0


def main() -> None:
    report = RunReport()
    arguments = _arguments()
    noise = GnssNoise(arguments.position_noise_m, math.radians(arguments.heading_noise_deg))
    profile, loop_profile = load_profile(arguments.profile), load_profile(arguments.loop_profile)
    curve = lemniscate(arguments.least_radius_m, arguments.laps)
    rows: list[Row] = []
    for stack in arguments.stacks if not arguments.plants_only else ():
        for conditions in _conditions(stack, profile, noise, arguments):
            # Perfect localization leaves nothing to chance.
            seeds = 1 if conditions.noise is None else arguments.seeds
            for seed in range(1, seeds + 1):
                task = FollowTask(curve, profile, arguments.speed_mps, seed, conditions)
                rows += _follow(stack, task, arguments.traces)
    if arguments.by_scans:
        rows += _by_scans(curve, profile, noise, arguments)
    seeds = range(arguments.first_plant, arguments.first_plant + arguments.plants)
    for plant_seed, plant, known in _unknown_vehicles(profile, tuple(seeds), arguments.unidentified):
        for stack in arguments.stacks:
            conditions = Conditions(f"{_PLANT} {plant_seed}", plant, noise)
            task = FollowTask(curve, known, arguments.speed_mps, plant_seed, conditions)
            rows += _follow(stack, task, arguments.traces)
    for file in arguments.waypoints if "gem" in arguments.stacks else ():
        for seed in range(1, arguments.seeds + 1):
            kinematic = Conditions(_KINEMATIC, None, noise)
            task = FollowTask(recorded_path(file), loop_profile, arguments.speed_mps, seed, kinematic)
            rows += _follow("gem", task, arguments.traces)
    report.write(arguments.json, "tracking", _plain(arguments), rows, _summary(rows, curve.name))


def _by_scans(
    curve: ReferencePath, profile: Profile, noise: GnssNoise, arguments: argparse.Namespace
) -> list[Row]:
    """The known vehicle on a campus, where each stack's own scans say where it is."""
    print("mapping the curve's place on the campus", flush=True)
    scanned = ScannedCurve(curve, profile, arguments.stacks)
    conditions = Conditions(_BY_SCANS, _plant(profile, 0.0, arguments), noise, scanned)
    rows: list[Row] = []
    for stack in arguments.stacks:
        for seed in range(1, arguments.seeds + 1):
            task = FollowTask(scanned.path, profile, arguments.speed_mps, seed, conditions)
            rows += _follow(stack, task, arguments.traces)
            print(rows[-1], flush=True)
    return rows


def _conditions(
    stack: str, profile: Profile, noise: GnssNoise, arguments: argparse.Namespace
) -> list[Conditions]:
    """The conditions in which a stack drives the curve."""
    found = [Conditions(_KINEMATIC, None, noise)] if stack in KINEMATIC_STACKS else []
    for share in (0.0, arguments.load_ratio, -arguments.load_ratio):
        found.append(Conditions(f"load {100.0 * share:+.0f} %", _plant(profile, share, arguments), noise))
    found.append(Conditions(_PERFECT, _plant(profile, 0.0, arguments), None))
    return found


def _unknown_vehicles(
    profile: Profile, seeds: tuple[int, ...], unidentified: bool
) -> list[tuple[int, PlantParams, Profile]]:
    """(seed, plant, all that is known of it: the profile identified from one drive) of each seed."""
    plants = tuple(random_plant(profile, seed) for seed in seeds)
    if unidentified or not plants:
        return [(seed, plant, profile) for seed, plant in zip(seeds, plants, strict=True)]
    drives = drive_plants(profile, plants, seeds, _IDENTIFIED_S)
    return [
        (seed, plant, identify(drive, profile).profile)
        for seed, plant, drive in zip(seeds, plants, drives, strict=True)
    ]


def _plant(profile: Profile, load_ratio: float, arguments: argparse.Namespace) -> PlantParams:
    """The profile's vehicle with tyres, load and a steering bias."""
    base = plant_params(profile)
    fields = {name: getattr(base, name) for name in base.__slots__}
    fields |= {
        "tyres": True,
        "steer_bias_rad": math.radians(arguments.steering_bias_deg),
        "load_kg": load_ratio * base.mass_kg,
        "cog_ratio": profile.tyres.cog_ratio,
        "yaw_inertia_kgm2": profile.tyres.yaw_inertia_kgm2,
        "cornering_front_npr": profile.tyres.cornering_front_npr,
        "cornering_rear_npr": profile.tyres.cornering_rear_npr,
    }
    return PlantParams(**fields)


def _follow(stack: str, task: FollowTask, traces: Path | None) -> list[Row]:
    """One row for each of the stack's followers."""
    rows = []
    for follower, drive_by in STACKS[stack].items():
        result = drive_by(task)
        if traces is not None:
            name = f"{task.path.name}-{stack}-{follower}-{task.conditions.name}-seed{task.seed}"
            _write_trace(traces, name.replace(" ", "-").replace("%", "pct"), result.drive)
        rows.append(_row(stack, follower, task, result))
    return rows


def _row(stack: str, follower: str, task: FollowTask, result: TrackingResult) -> Row:
    drive = result.drive
    off_m = np.abs(task.path.cross_track_m(drive.trace[:, 1:3]))
    return {
        "path": task.path.name,
        "vehicle": task.profile.name,
        "stack": stack,
        "follower": follower,
        "conditions": task.conditions.name,
        "seed": task.seed,
        "finished": drive.finished,
        "peak_cross_track_m": float(off_m.max()),
        "mean_cross_track_m": float(off_m.mean()),
        "p95_cross_track_m": float(np.percentile(off_m, 95)),
        "mean_speed_mps": float(drive.trace[:, 4].mean()),
        "max_speed_mps": float(drive.trace[:, 4].max()),
        "duration_s": result.driven_s,
        "reference_s": result.reference_s,
        "time_ratio": result.driven_s / result.reference_s,
        "cpu_us_per_tick": 1e6 * drive.cpu_s / drive.ticks,
    }


def _summary(rows: list[Row], curve: str) -> Row:
    """The figures of the followers "ours"; the worst row counts. An unfinished drive has no figure."""
    summary: dict[str, float | None] = {}
    for row in rows:
        if row["follower"] == "ours":
            for key, value in _figures(row, curve):
                known = summary.get(key, 0.0)
                summary[key] = max(known, value) if row["finished"] and known is not None else None
    return summary


def _figures(row: Row, curve: str) -> list[tuple[str, float]]:
    stack, conditions = row["stack"], row["conditions"]
    peak, ratio = row["peak_cross_track_m"], row["time_ratio"]
    assert isinstance(peak, float)
    assert isinstance(ratio, float)
    if row["path"] != curve:
        return [(f"{stack}.{row['path']}.peak_cross_track_m", peak)]
    if str(conditions).startswith(_PLANT):
        return [
            (f"{stack}.unknown_vehicle_peak_cross_track_m", peak),
            (f"{stack}.unknown_vehicle_time_ratio", ratio),
        ]
    if conditions == _BY_SCANS:
        return [(f"{stack}.by_scans_peak_cross_track_m", peak), (f"{stack}.by_scans_time_ratio", ratio)]
    if conditions == _PERFECT:
        return [(f"{stack}.perfect_localization_peak_m", peak)]
    judged_kinematic = stack in KINEMATIC_STACKS
    if judged_kinematic and conditions != _KINEMATIC:
        return [(f"{stack}.disturbed_peak_cross_track_m", peak)]
    return [(f"{stack}.peak_cross_track_m", peak), (f"{stack}.time_ratio", ratio)]


def _write_trace(folder: Path, name: str, drive: Drive) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / f"{name}.csv").open("w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow(_TRACE)
        rows.writerows([f"{value:.6f}" for value in row] for row in drive.trace)


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="benchmarks.tracking", description=__doc__)
    parser.add_argument("waypoints", nargs="*", type=Path, help="recorded loops: CSV of x, y in metres, ...")
    parser.add_argument("--json", type=Path, help="where to write the report")
    parser.add_argument("--traces", type=Path, help="folder for one CSV a run")
    parser.add_argument("--stacks", nargs="+", choices=list(STACKS), default=list(STACKS))
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--laps", type=int, default=2)
    parser.add_argument("--least-radius-m", type=float, default=18.0)
    parser.add_argument("--speed-mps", type=float, default=3.0)
    parser.add_argument("--position-noise-m", type=float, default=0.02)
    parser.add_argument("--heading-noise-deg", type=float, default=0.3)
    parser.add_argument("--steering-bias-deg", type=float, default=0.6)
    parser.add_argument("--load-ratio", type=float, default=0.2, help="of the weight, more and less")
    parser.add_argument("--plants", type=int, default=5, help="vehicles of which nothing is known")
    parser.add_argument("--first-plant", type=int, default=100, help="seed of the first of them")
    parser.add_argument("--by-scans", action="store_true", help="also by each stack's own scans on a map")
    parser.add_argument("--plants-only", action="store_true", help="leave the known vehicles out")
    parser.add_argument("--unidentified", action="store_true", help="drive them with the nominal profile")
    parser.add_argument("--profile", type=Path, default=_PROFILES / "campus-shuttle.toml")
    parser.add_argument("--loop-profile", type=Path, default=_PROFILES / "gem-e2.toml")
    return parser.parse_args()


def _plain(arguments: argparse.Namespace) -> dict[str, str | int | float | list[str] | None]:
    """The arguments as JSON can hold them."""
    plain: dict[str, str | int | float | list[str] | None] = {}
    for name, value in vars(arguments).items():
        if isinstance(value, list):
            plain[name] = [str(item) for item in value]
        else:
            plain[name] = str(value) if isinstance(value, Path) else value
    return plain


if __name__ == "__main__":
    main()
