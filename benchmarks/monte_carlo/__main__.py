"""Random drives through crowds: `python -m benchmarks.monte_carlo --runs N [--recordings DIR] --json F`.

Each run draws from its own seed: a path (a lane of a shipped map, or a random curve), where the shuttle
starts on it, its dynamics (`simulator/vehicle/random_plant.py`), its tracker's noise and misses, and a crowd.
The crowd is reactive people of a random density, of whom some are inattentive, or recorded people from DIR
(drone clips and obsmat files), placed on the path.
A front contact while moving faster than 0.3 m/s is the shuttle's fault; others are counted separately. A
stall is a stand of more than 20 s with a free corridor 1.5 widths wide past all people ahead. In sparse
crowds (at most one person on 100 m2 of the path) and in dense ones (5 to 8) the mean speed is compared with
that of the same drive without people. How many people are around the vehicle is counted as it drives. They
are mostly fewer: a drive begins with nobody near, and the body takes some of the ground.
"""

import argparse
from pathlib import Path

import numpy as np

from benchmarks.monte_carlo.drives import MonteCarloDrive, drive, sources
from benchmarks.reporting.report import Row, RunReport
from benchmarks.reporting.run_logs import add_log_arguments, log_choice
from benchmarks.reporting.workers import add_worker_arguments, worker_campaign
from campusloop.scenes.random_crowds import DENSE_PER_100M2, SPARSE_PER_100M2
from campusloop.scenes.stacks import profile_of
from simulator.traffic.recordings import RecordingError
from vehicle_agent.config import ProfileError


def main() -> None:
    report = RunReport()
    arguments = _arguments()
    logs = log_choice(arguments)
    stacks = tuple(arguments.stacks.split(","))
    try:
        for stack in stacks:
            profile_of(stack)
        sources(arguments.recordings)
    except (RecordingError, ProfileError) as error:
        raise SystemExit(f"cannot drive: {error}") from error
    first = arguments.seed
    recordings, traces = (
        None if path is None else path.absolute() for path in (arguments.recordings, arguments.traces)
    )
    jobs = [
        MonteCarloDrive(
            stack,
            seed,
            recordings,
            traces,
            logs,
            seed if arguments.plants == "random" else None,
            arguments.perception == "own",
        )
        for stack in stacks
        for seed in range(first, first + arguments.runs)
    ]
    print(f"seeds {first} to {first + arguments.runs - 1}", flush=True)
    rows: list[Row] = []
    with worker_campaign(arguments, files=() if recordings is None else (recordings,)) as campaign:
        workers = campaign.size
        for row in campaign.run(drive, jobs):
            rows.append(row)
            print(_line(row), flush=True)
    report.write(
        arguments.json,
        "monte_carlo",
        {
            "runs": arguments.runs,
            "stacks": arguments.stacks,
            "perception": arguments.perception,
            "seed": first,
            "plants": arguments.plants,
            "recordings": str(arguments.recordings or ""),
            "workers": workers,
            "cluster": arguments.cluster or "",
        },
        rows,
        summary(rows),
    )


def summary(rows: list[Row]) -> Row:
    """Per stack; a speed ratio is the mean of the drives' ratios to the same drives without people."""
    out: dict[str, float | int | None] = {
        "sparse_per_100m2_max": SPARSE_PER_100M2,
        "dense_per_100m2_min": DENSE_PER_100M2,
    }
    for stack in dict.fromkeys(str(row["stack"]) for row in rows):
        mine = [row for row in rows if row["stack"] == stack]
        sparse = [row for row in mine if _number(row["people_per_100m2"]) <= SPARSE_PER_100M2]
        dense = [row for row in mine if _number(row["people_per_100m2"]) >= DENSE_PER_100M2]
        clear = [_number(row["clearance_m"]) for row in mine if row["clearance_m"] is not None]
        out[f"{stack}.runs"] = len(mine)
        out[f"{stack}.contacts"] = int(sum(_number(row["contacts"]) for row in mine))
        out[f"{stack}.runs_with_contact"] = sum(_number(row["contacts"]) > 0 for row in mine)
        out[f"{stack}.other_contacts"] = int(sum(_number(row["other_contacts"]) for row in mine))
        out[f"{stack}.mean_speed_ratio"] = _speed_ratio(sparse)
        out[f"{stack}.dense_runs"] = len(dense)
        out[f"{stack}.dense_speed_ratio"] = _speed_ratio(dense)
        out[f"{stack}.dense_people_met_per_100m2"] = _mean(
            [_number(r["people_met_per_100m2"]) for r in dense]
        )
        out[f"{stack}.stalls"] = int(sum(_number(row["stalls"]) for row in mine))
        out[f"{stack}.reached"] = sum(bool(row["reached"]) for row in mine)
        out[f"{stack}.mean_mps"] = float(np.mean([_number(row["mean_mps"]) for row in mine]))
        out[f"{stack}.clearance_median_m"] = float(np.median(clear)) if clear else None
    out["people.removed"] = int(sum(_number(row["people_removed"]) for row in rows))
    return out


def _speed_ratio(rows: list[Row]) -> float | None:
    ratios = [_number(row["mean_mps"]) / max(_number(row["free_mps"]), 1e-9) for row in rows]
    return _mean(ratios)


def _mean(values: list[float]) -> float | None:
    return float(np.mean(values)) if values else None


def _number(value: object) -> float:
    assert isinstance(value, int | float)
    return float(value)


def _line(row: Row) -> str:
    return (
        f"{row['stack']} seed {row['seed']} {row['path']} {row['crowd']} {row['people_per_100m2']:.1f}: "
        f"{row['driven_m']:.0f} m in {row['time_s']:.0f} s, "
        f"contacts {row['contacts']}+{row['other_contacts']}, {row['people_removed']} people removed, "
        f"stalls {row['stalls']}, {row['limited_by']}"
    )


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="benchmarks.monte_carlo", description=__doc__)
    parser.add_argument("--runs", type=int, default=20, help="of each stack")
    parser.add_argument("--stacks", default="snow_lion,gem", help="with commas between")
    parser.add_argument("--seed", type=int, default=1, help="of the first run; the next has the next")
    parser.add_argument("--recordings", type=Path, help="folder of drone clips and obsmat files")
    add_worker_arguments(parser)
    parser.add_argument("--json", type=Path, help="where to write the report")
    parser.add_argument("--traces", type=Path, help="folder for two CSV files a run")
    parser.add_argument(
        "--plants",
        choices=("random", "nominal"),
        default="random",
        help="the vehicle's dynamics: drawn from the run's seed, or those of its profile",
    )
    parser.add_argument(
        "--perception",
        choices=("tracker", "own"),
        default="tracker",
        help="road users by a tracker of the truth with noise, or found in simulated scans",
    )
    add_log_arguments(parser)
    return parser.parse_args()


if __name__ == "__main__":
    main()
