"""How well each stack knows where it is: `python -m benchmarks.localization --json F`.

A vehicle is driven exactly along the ways of a shipped campus. Its receiver sees the sky between the
buildings (`simulator/sensors/sky.py`), its wheels have a scale error and a coarse report, its gyroscope a
bias that walks and a scale error, its rear axle slips. Each stack's own localization says where it is.

`lost_found_pct`: jumps of the receiver by 1 to 30 m, of which the receiver says nothing. One counts as found
when the vehicle stays within 0.5 m of the truth, or says within 2 s that it is not sure.
`false_alarms_per_10h`: times when it says so, under an open sky, while it is within 0.1 m.
The Snow Lion and GEM stacks have lidar scans on a map, on ways of --scan-km. The map is made as
`campusloop workshop map --clouds` does, of a drive of the same way on another day: other noise, traffic,
parked cars and receiver. In most rows the world has changed since; in some the estimate is kidnapped now
and then by 1 to 8 m, without GNSS. `snow_lion.lost_found_pct` is of these: slow, or right again, within 2
s; `right_pct`: right within 20 s. Its `p95_ms` is the worker's, of the slowest row. `snow_lion_gnss` and
`gem_gnss` are the same stacks without scans: the GEM paper's vehicle has GNSS/INS alone. --trucks adds a
row among trucks, --days further days in a changed world for each map, for the rate of false alarms:
`false_alarms` in `hours`, and the greatest rate that they leave possible (95 %).
The NUS stack has a planar laser on an occupancy map that its own survey made, on ways of --laser-km; rows of
GNSS/INS alone stand beside its own. It is kidnapped by 2 to 30 m, and in a third of the cases turned by any
angle. `nus.p95_ms` is the worker's; `nus_gnss` is the same stack without scans.
`lost_found_pct`, `false_alarms_per_10h` and `nees_in_bounds_pct` without a stack's name are of the worst one.
`nees_in_bounds_pct`: ticks whose squared error over the stated covariance is within the 95 % bound of two
degrees of freedom.
"""

import argparse
from pathlib import Path

import numpy as np

from benchmarks.localization.campus_way import campus_way, truths
from benchmarks.localization.drive import CONDITIONS, Conditions, Drive, drive
from benchmarks.localization.planar_rows import planar_rows
from benchmarks.localization.scan_rows import scan_map_rows
from benchmarks.reporting.report import Row, RunReport
from campusloop.shipped import DEFAULT_MAP
from contract.geometry import Array
from contract.roads.load import load_map
from vehicle_agent.config import load_profile
from vehicle_agent.stacks.choice import build_car
from vehicle_agent.stacks.rooms import rear_slip_per_mps2

PROFILES = Path(__file__).resolve().parents[2] / "vehicle_agent" / "profiles"
# A profile of each stack.
STACKS = {"snow_lion": "snow-lion", "gem": "gem-e2", "nus": "nus-cart"}
# 95 % of a chi-square variable with two degrees of freedom.
NEES_MAX = 5.99
TICK_S = 0.02
FOUND_WITHIN_S = 2.0
STILL_GOOD_M, GOOD_M = 0.5, 0.1
_WITHOUT_SCANS = tuple(f"{stack}_gnss." for stack in STACKS)
# Until the filter knows its sensors.
SETTLE_S = 60.0


def main() -> None:
    report = RunReport()
    arguments = _arguments()
    road_map = load_map(arguments.map)
    rows: list[Row] = []
    summary: dict[str, float] = {}
    for stack in arguments.stacks:
        profile = load_profile(PROFILES / f"{STACKS[stack]}.toml")
        room = build_car(profile, road_map).localization
        drives: dict[str, list[Drive]] = {}
        for conditions in CONDITIONS:
            for seed in range(arguments.seed, arguments.seed + arguments.runs):
                rng = np.random.default_rng([seed, 3])
                way = campus_way(road_map, arguments.km, min(3.5, profile.limits.speed_mps_max), rng)
                slip = rear_slip_per_mps2(profile) * float(rng.uniform(0.5, 1.5))
                one = drive(truths(way, slip), room, road_map, conditions, seed)
                drives.setdefault(conditions.name, []).append(one)
                rows.append(_row(stack, conditions, seed, way.length_m / 1e3, one))
                print(f"{stack}, {conditions.name}, seed {seed}: done", flush=True)
        summary |= _summary(_name(stack), drives)
    has_scans = arguments.scan_map is not False
    for stack in _on_map_of_scans(arguments) if has_scans else ():
        scan_rows, scan_summary = scan_map_rows(
            stack, load_profile(PROFILES / f"{STACKS[stack]}.toml"), road_map,
            min(arguments.km, arguments.scan_km), arguments.runs, arguments.seed, arguments.days,
            trucks=arguments.trucks,
        )  # fmt: skip
        rows += scan_rows
        summary |= scan_summary
    if "nus" in arguments.stacks and arguments.laser_km > 0.0:
        laser = planar_rows(road_map, arguments.laser_km, arguments.runs, arguments.seed, arguments.days)
        # The stack's own localization; what GNSS/INS alone does is in the rows.
        rows, summary = rows + laser[0], summary | laser[1]
    summary |= of_the_worst(summary)
    report.write(
        arguments.json,
        "localization",
        {
            "map": str(arguments.map),
            "km": arguments.km,
            "runs": arguments.runs,
            "seed": arguments.seed,
            "scan_map": has_scans,
            "scan_km": arguments.scan_km,
            "days": arguments.days,
            "laser_km": arguments.laser_km,
        },
        rows,
        summary,
    )


def _on_map_of_scans(arguments: argparse.Namespace) -> list[str]:
    """The stacks that get rows of scans on a map of surfaces; those without any other, too, if asked for."""
    wanted = [stack for stack in arguments.stacks if stack != "nus"]
    return wanted or (["snow_lion"] if arguments.scan_map else [])


def _name(stack: str) -> str:
    """Of rows without scans: each stack has others with them."""
    return f"{stack}_gnss"


def _row(stack: str, conditions: Conditions, seed: int, km: float, one: Drive) -> Row:
    error_m = one.error_m[_settled(one)]
    return {
        "stack": _name(stack),
        "conditions": conditions.name,
        "seed": seed,
        "km": round(km, 2),
        "rmse_m": round(float(np.sqrt(np.mean(error_m**2))), 3),
        "p99_m": round(float(np.percentile(error_m, 99)), 3),
        "worst_m": round(float(error_m.max()), 3),
        "nees_in_bounds_pct": round(100.0 * float(np.mean(one.nees[_settled(one)] <= NEES_MAX)), 1),
        "full_speed_pct": round(100.0 * float(np.mean(one.drivable[_settled(one)])), 1),
        "p95_ms": round(1e3 * float(np.percentile(one.cpu_s, 95)), 3),
    }


def _summary(stack: str, drives: dict[str, list[Drive]]) -> dict[str, float]:
    """Error and deviation over every condition but the open sky, which is the easy one."""
    hard = [one for name, some in drives.items() if name != "open sky" for one in some]
    errors = np.concatenate([one.error_m[_settled(one)] for one in hard])
    nees = np.concatenate([one.nees[_settled(one)] for one in hard])
    cpu_s = np.concatenate([one.cpu_s for one in hard])
    found = [is_found for one in drives["jumps"] for is_found in jumps_found(one)]
    easy = drives["open sky"]
    hours = sum(len(one.error_m) for one in easy) * TICK_S / 3600.0
    return {
        f"{stack}.rmse_m": round(float(np.sqrt(np.mean(errors**2))), 3),
        f"{stack}.p99_m": round(float(np.percentile(errors, 99)), 3),
        f"{stack}.p95_ms": round(1e3 * float(np.percentile(cpu_s, 95)), 3),
        f"{stack}.lost_found_pct": round(100.0 * float(np.mean(found)), 1),
        f"{stack}.false_alarms_per_10h": round(sum(map(false_alarms, easy)) * 10.0 / hours, 2),
        f"{stack}.nees_in_bounds_pct": round(100.0 * float(np.mean(nees <= NEES_MAX)), 1),
    }


def of_the_worst(summary: dict[str, float]) -> dict[str, float]:
    """Of all stacks together; where a stack has scans, what it does without them does not count."""
    worst = {}
    for name, choose in (("lost_found_pct", min), ("false_alarms_per_10h", max), ("nees_in_bounds_pct", min)):
        every = {key: value for key, value in summary.items() if key.endswith(f".{name}")}
        own = {key: value for key, value in every.items() if not key.startswith(_WITHOUT_SCANS)}
        if every:
            worst[name] = choose((own or every).values())
    return worst


def _settled(one: Drive) -> slice:
    return slice(min(round(SETTLE_S / TICK_S), len(one.error_m) // 2), None)


def jumps_found(one: Drive) -> list[bool]:
    """For each jump of the receiver: the vehicle was not led astray by it, or soon said that it may be."""
    begins, ends = _episodes(one.wrong > 0)
    within = round(FOUND_WITHIN_S / TICK_S)
    found = []
    for begin, end in zip(begins, ends, strict=True):
        astray = np.flatnonzero(one.error_m[begin : end + within] > STILL_GOOD_M)
        if len(astray) == 0:
            found.append(True)
            continue
        first = begin + int(astray[0])
        found.append(bool((one.drivable[first : first + within] == 0).any()))
    return found


def false_alarms(one: Drive) -> int:
    """How often the vehicle says that it is not sure while it is near the truth."""
    begins, ends = _episodes(one.drivable == 0)
    return sum(
        bool(np.nanmax(one.error_m[begin:end]) < GOOD_M)
        for begin, end in zip(begins, ends, strict=True)
        if begin > 0 and np.isfinite(one.error_m[begin:end]).any()
    )


def _episodes(true: Array) -> tuple[list[int], list[int]]:
    """First ticks, and ticks after the last, of the stretches that are true."""
    edges = np.diff(np.concatenate(([0], np.asarray(true, dtype=np.int8), [0])))
    return np.flatnonzero(edges == 1).tolist(), np.flatnonzero(edges == -1).tolist()


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--map", type=Path, default=DEFAULT_MAP)
    parser.add_argument("--stacks", nargs="*", choices=STACKS, default=list(STACKS))
    parser.add_argument("--km", type=float, default=2.0, help="of each drive")
    parser.add_argument("--runs", type=int, default=1, help="drives for each stack and condition")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument(
        "--scan-map", action=argparse.BooleanOptionalAction, help="with or without the rows of scans on a map"
    )
    parser.add_argument("--scan-km", type=float, default=0.6, help="of each drive with scans")
    parser.add_argument("--trucks", action="store_true", help="a row of scans among parked trucks")
    parser.add_argument(
        "--days", type=int, default=0, help="further days with scans, and with the laser, for each map"
    )
    parser.add_argument(
        "--laser-km", type=float, default=0.6, help="of each drive of the NUS stack's laser; 0: none"
    )
    parser.add_argument("--json", type=Path)
    return parser.parse_args()


if __name__ == "__main__":
    main()
