"""How well the waypoint follower keeps its path: `python -m benchmarks.tracking --json F [LOOP.csv ...]`.

The GEM paper's figure of eight at 3 m/s had a peak cross-track error of 12 cm. Here it is a lemniscate with
the least radius that the paper's own 0.5 m/s2 allows at that speed, 18 m. Waypoints are recorded by driving
it with the same sensor noise; the error is the rear-axle centre's distance from the curve itself.
"""

import argparse
import csv
import math
import tempfile
from dataclasses import dataclass
from pathlib import Path

import msgspec
import numpy as np

from benchmarks.reference_paths import ReferencePath, lemniscate, recorded_path
from benchmarks.report import Row, write_report
from benchmarks.waypoint_drive import Drive, follow, record
from simulator.sensors.gnss import GnssNoise
from vehicle_agent.config import Profile, load_profile
from vehicle_agent.control.gem import WaypointControl
from vehicle_agent.stacks.gem import control

_TRACE = ["t_s", "x_m", "y_m", "yaw_rad", "v_mps", "a_mps2", "steer_rad"]
_PROFILES = Path(__file__).resolve().parent.parent / "vehicle_agent" / "profiles"


def main() -> None:
    arguments = _arguments()
    noise = GnssNoise(arguments.position_noise_m, math.radians(arguments.heading_noise_deg))
    profile, loop_profile = load_profile(arguments.profile), load_profile(arguments.loop_profile)
    rows: list[Row] = []
    paths = [(lemniscate(arguments.least_radius_m, arguments.laps), profile)]
    paths += [(recorded_path(file), loop_profile) for file in arguments.waypoints]
    for path, vehicle in paths:
        for follower, hands in (("ours", control(vehicle)), ("paper", _as_in_the_paper(control(vehicle)))):
            for seed in range(1, arguments.seeds + 1):
                task = Following(path, vehicle, follower, hands, arguments.speed_mps, seed)
                rows.append(_run(task, noise, arguments.traces))
    write_report(arguments.json, "tracking", _plain(arguments), rows, _summary(rows, paths[0][0].name))


@dataclass(frozen=True, slots=True)
class Following:
    """One drive to be made."""

    path: ReferencePath
    profile: Profile
    follower: str
    hands: WaypointControl
    speed_mps: float
    seed: int


def _as_in_the_paper(hands: WaypointControl) -> WaypointControl:
    """One gain at every speed, aimed from where the vehicle is now and not where it will be."""
    follower = msgspec.structs.replace(hands.follower, heading_gain_1ps=2.0, gain_speed_mps=0.0)
    return msgspec.structs.replace(hands, follower=follower, steer_delay_s=0.0)


def _run(task: Following, noise: GnssNoise, traces: Path | None) -> Row:
    path = task.path
    with tempfile.TemporaryDirectory() as folder:
        file = record(path, task.profile, task.speed_mps, Path(folder), task.seed, noise)
        drive = follow(path, file, task.profile, task.hands, task.speed_mps, task.seed, noise)
    if traces is not None:
        _write_trace(traces, f"{path.name.replace(' ', '-')}-{task.follower}-seed{task.seed}", drive)
    return _row(task, drive)


def _row(task: Following, drive: Drive) -> Row:
    off_m = np.abs(task.path.cross_track_m(drive.trace[:, 1:3]))
    return {
        "path": task.path.name,
        "vehicle": task.profile.name,
        "follower": task.follower,
        "seed": task.seed,
        "finished": drive.finished,
        "peak_cross_track_m": float(off_m.max()),
        "mean_cross_track_m": float(off_m.mean()),
        "p95_cross_track_m": float(np.percentile(off_m, 95)),
        "mean_speed_mps": float(drive.trace[:, 4].mean()),
        "max_speed_mps": float(drive.trace[:, 4].max()),
        "duration_s": float(drive.trace[-1, 0]),
        "cpu_us_per_tick": 1e6 * drive.cpu_s / drive.ticks,
    }


def _summary(rows: list[Row], figure_eight: str) -> Row:
    """Ours; the worst seed counts. A drive that did not come to its end has no peak worth telling."""
    summary: dict[str, float | None] = {}
    for row in rows:
        if row["follower"] != "ours":
            continue
        name = "gem" if row["path"] == figure_eight else f"gem.{row['path']}"
        key = f"{name}.peak_cross_track_m"
        peak = row["peak_cross_track_m"]
        assert isinstance(peak, float)
        known = summary.get(key, 0.0)
        summary[key] = max(known, peak) if row["finished"] and known is not None else None
    return summary


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
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--laps", type=int, default=2)
    parser.add_argument("--least-radius-m", type=float, default=18.0)
    parser.add_argument("--speed-mps", type=float, default=3.0)
    parser.add_argument("--position-noise-m", type=float, default=0.02)
    parser.add_argument("--heading-noise-deg", type=float, default=0.3)
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
