"""Monte-Carlo localization with broken beams and no idea where: `python -m benchmarks.amcl LOG --json F`.

The map is built from the log by our SLAM, and its poses are the reference. The laser then starts at moments
spread over the log, anywhere in the map, and drives on while a share of all beams, drawn from the seed, is
replaced by random distances. Each start is one row.

found_s   from the start until the estimate is within 0.5 m and 10 degrees and says itself that it is not lost
found_pct of the starts that were found within 20 s
rmse_m    of the position at all moments since then, also where the pose was lost again
wrong_pct of these moments with an error above 0.5 m or 10 degrees
nees      mean normalised squared error of the pose where it was not wrong (3 is honest)
in_95_pct of these within the 95 % bound of that error
brier     of `lost` against being wrong, over all moments
p95_ms    wall time of one update with at most 500 particles; start_ms: of one search of the whole map
"""

import argparse
import time
from collections.abc import Sequence
from pathlib import Path

import msgspec
import numpy as np

from benchmarks.reporting.report import Row, RunReport
from contract.geometry import Array, BoolArray
from vehicle_agent.localization.laser.pose_arrays import between, composed, wrapped
from vehicle_agent.localization.monte_carlo.localization import MonteCarloLocalization
from workshop.carmen.laser_logs import LaserLog, read_laser_log
from workshop.laser_mapping.mapping import MappingParams, NoProgress, map_log

PARTICLES = 500
FOUND_WITHIN_S = 20.0
_NEAR_M, _NEAR_RAD = 0.5, np.radians(10.0)
_LOST = 0.5
_CHI2_95 = 7.815
# Broken beams end anywhere in this span.
_BROKEN_M = (0.2, 25.0)
# No start in the last part of a log, so that each has something to see.
_STARTS_UNTIL = 0.95


class Moments(msgspec.Struct, frozen=True):
    """One episode, a row for each scan: seconds since its start; error_m, error_rad; lost; nees; particles,
    cpu_s and wall_s of the update. start_s: of the search of the map."""

    since_s: Array
    error_m: Array
    error_rad: Array
    lost: Array
    nees: Array
    particles: Array
    cpu_s: Array
    wall_s: Array
    start_s: float

    @property
    def is_wrong(self) -> BoolArray:
        wrong: BoolArray = (self.error_m > _NEAR_M) | (self.error_rad > _NEAR_RAD)
        return wrong

    @property
    def found(self) -> int | None:
        """The first moment at which it is right and says so."""
        right = np.flatnonzero(~self.is_wrong & (self.lost < _LOST))
        return int(right[0]) if len(right) else None


def main() -> None:
    report = RunReport()
    arguments = _arguments()
    log = read_laser_log(arguments.log)
    laser_map = map_log(log, MappingParams(), NoProgress())
    localization = MonteCarloLocalization.in_map(laser_map.occupancy)
    # The first episode compiles the kernels.
    episode(localization, log, laser_map.poses, 0, 2.0, arguments.corrupted, arguments.seed)
    starts = np.linspace(0, _STARTS_UNTIL * (len(log) - 1), arguments.starts).astype(int)
    episodes, rows = [], []
    for number, start in enumerate(starts):
        seed = 1000 * arguments.seed + number
        moments = episode(
            localization, log, laser_map.poses, int(start), arguments.seconds, arguments.corrupted, seed
        )
        episodes.append(moments)
        rows.append({"start": number, "scan": int(start), **figures([moments])})
    given = {
        "log": str(arguments.log),
        "starts": arguments.starts,
        "seconds": arguments.seconds,
        "corrupted": arguments.corrupted,
        "seed": arguments.seed,
    }
    report.write(arguments.json, "amcl", given, rows, figures(episodes))


def episode(
    localization: MonteCarloLocalization,
    log: LaserLog,
    reference: Array,
    start: int,
    seconds: float,
    corrupted: float,
    seed: int,
) -> Moments:
    """From scan `start` on, for so many seconds of the log."""
    rng = np.random.default_rng(seed)
    angles_rad = log.beams.angles_rad
    mount = np.array([log.T_base_laser.x_m, log.T_base_laser.y_m, log.T_base_laser.yaw_rad])
    odometry = composed(log.odometry, mount)
    began_s = time.perf_counter()
    state = localization.anywhere(
        seed, broken(log.ranges_m[start], corrupted, rng), angles_rad, odometry[start]
    )
    start_s = time.perf_counter() - began_s
    rows = []
    for number in range(start, len(log)):
        since_s = log.stamps_s[number] - log.stamps_s[start]
        if since_s > seconds:
            break
        scan = broken(log.ranges_m[number], corrupted, rng)
        particles = len(state.poses)
        wall_s, cpu_s = time.perf_counter(), time.process_time()
        estimate, state = localization.step(state, scan, angles_rad, odometry[number])
        wall_s, cpu_s = time.perf_counter() - wall_s, time.process_time() - cpu_s
        error = between(reference[number], estimate.pose_map)
        away = estimate.pose_map - reference[number]
        away[2] = wrapped(away[2:])[0]
        nees = float(away @ np.linalg.solve(estimate.covariance, away))
        error_m = float(np.hypot(error[0], error[1]))
        rows.append((since_s, error_m, abs(error[2]), estimate.lost, nees, particles, cpu_s, wall_s))
    return Moments(*np.array(rows).T, start_s)


def broken(ranges_m: Array, share: float, rng: np.random.Generator) -> Array:
    """(m,) the scan with this share of its beams replaced by random distances."""
    out = ranges_m.copy()
    is_broken = rng.random(len(out)) < share
    out[is_broken] = rng.uniform(*_BROKEN_M, int(is_broken.sum()))
    return out


def figures(episodes: Sequence[Moments]) -> Row:
    """Of one or all episodes; None where there is nothing to take a mean of."""
    found = [moments.found for moments in episodes]
    found_s = [
        float(moments.since_s[at]) for moments, at in zip(episodes, found, strict=True) if at is not None
    ]
    pairs = [(moments, at) for moments, at in zip(episodes, found, strict=True) if at is not None]
    error_m = np.concatenate([moments.error_m[at:] for moments, at in pairs]) if pairs else np.zeros(0)
    wrong = np.concatenate([moments.is_wrong[at:] for moments, at in pairs]) if pairs else np.zeros(0, bool)
    nees = np.concatenate([moments.nees[at:] for moments, at in pairs])[~wrong] if pairs else np.zeros(0)
    lost = np.concatenate([moments.lost for moments in episodes])
    was_wrong = np.concatenate([moments.is_wrong for moments in episodes])
    few = np.concatenate([moments.particles for moments in episodes]) <= PARTICLES
    wall_ms = 1e3 * np.concatenate([moments.wall_s for moments in episodes])[few]
    cpu_ms = 1e3 * np.concatenate([moments.cpu_s for moments in episodes])[few]
    return {
        "rmse_m": float(np.sqrt(np.mean(error_m**2))) if len(error_m) else None,
        "found_pct": 100.0 * sum(s <= FOUND_WITHIN_S for s in found_s) / len(episodes),
        "found_s": float(np.median(found_s)) if found_s else None,
        "found_s_max": max(found_s) if found_s else None,
        "wrong_pct": 100.0 * float(wrong.mean()) if len(wrong) else None,
        "nees": float(nees.mean()) if len(nees) else None,
        "in_95_pct": 100.0 * float((nees <= _CHI2_95).mean()) if len(nees) else None,
        "brier": float(np.mean((lost - was_wrong) ** 2)),
        "p95_ms": float(np.percentile(wall_ms, 95)) if len(wall_ms) else None,
        "p95_cpu_ms": float(np.percentile(cpu_ms, 95)) if len(cpu_ms) else None,
        "start_ms": 1e3 * float(np.median([moments.start_s for moments in episodes])),
    }


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="benchmarks.amcl", description=__doc__)
    parser.add_argument("log", type=Path, help="CARMEN log, plain, .gz or .bz2")
    parser.add_argument("--starts", type=int, default=40, help="moments, spread over the log")
    parser.add_argument("--seconds", type=float, default=60.0, help="of the log after each start")
    parser.add_argument("--corrupted", type=float, default=0.3, help="share of the beams")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--json", type=Path, help="where to write the report")
    return parser.parse_args()


if __name__ == "__main__":
    main()
