"""People who set off right before the shuttle: `python -m benchmarks.stepping_in --runs N --json F`.

Each run draws from its own seed: a winding way, the vehicle's dynamics, its tracker's noise and misses, and
four people who stand 0.3 to 1.3 m beside its side. Each walks into the way, straight or aslant, once the
bumper is 0.5 to 5.5 m before them, and heeds nothing. Crowds have few such moments; here every run has four.

A front contact while moving faster than 0.3 m/s is the shuttle's fault. It counts as avoidable if a vehicle
that brakes fully from 0.27 s after the first step would not have had it. The speed beside it shows what
care costs: `speed_at_step_mps` is that of the vehicle when people set off, `mean_mps` that of all drives.
"""

import argparse
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.reporting.report import Row, RunReport
from benchmarks.reporting.workers import add_worker_arguments, worker_campaign
from campusloop.scenes.drive import SceneDrive
from campusloop.scenes.stacks import perceiving, profile_of
from campusloop.scenes.stepping_in import stepping_in_scene, steps_in
from vehicle_agent.config import ProfileError


@dataclass(frozen=True, slots=True)
class SteppingInDrive:
    stack: str
    seed: int
    own_perception: bool = False


def drive(job: SteppingInDrive) -> Row:
    """One drive past four people."""
    profile = perceiving(profile_of(job.stack), job.own_perception)
    run = SceneDrive(stepping_in_scene(profile, job.seed)).run()
    met = [step for step in steps_in(run, profile.body) if step.begins_s is not None]
    hits = [step for step in met if step.impact_mps is not None]
    return {
        "stack": job.stack,
        "seed": job.seed,
        "steps": len(met),
        "contacts": len(hits),
        "avoidable_contacts": sum(step.least_mps is None for step in hits),
        "impact_mps_max": max(
            (step.impact_mps for step in hits if step.impact_mps is not None), default=None
        ),
        "speed_at_step_mps_sum": float(sum(step.speed_mps for step in met)),
        "reached": run.time_s is not None,
        "driven_m": run.driven_m,
        "time_s": float(run.trace.array()[-1, 0]),
    }


def summary(rows: list[Row]) -> Row:
    """Per stack."""
    out: dict[str, float | int | None] = {}
    for stack in dict.fromkeys(str(row["stack"]) for row in rows):
        mine = [row for row in rows if row["stack"] == stack]

        def total(key: str, of: list[Row] = mine) -> float:
            return float(np.sum([row[key] for row in of]))

        impacts = [value for row in mine if isinstance(value := row["impact_mps_max"], float)]
        steps = int(total("steps"))
        out[f"{stack}.steps"] = steps
        out[f"{stack}.contacts"] = int(total("contacts"))
        out[f"{stack}.avoidable_contacts"] = int(total("avoidable_contacts"))
        out[f"{stack}.impact_mps_max"] = max(impacts, default=None)
        out[f"{stack}.speed_at_step_mps"] = total("speed_at_step_mps_sum") / steps if steps else None
        out[f"{stack}.mean_mps"] = total("driven_m") / max(total("time_s"), 1e-9)
        out[f"{stack}.reached"] = int(total("reached"))
    return out


def main() -> None:
    report = RunReport()
    arguments = _arguments()
    stacks = tuple(arguments.stacks.split(","))
    try:
        for stack in stacks:
            profile_of(stack)
    except ProfileError as error:
        raise SystemExit(f"cannot drive: {error}") from error
    seeds = range(arguments.seed, arguments.seed + arguments.runs)
    own = arguments.perception == "own"
    jobs = [SteppingInDrive(stack, seed, own) for stack in stacks for seed in seeds]
    print(f"seeds {seeds.start} to {seeds.stop - 1}", flush=True)
    rows: list[Row] = []
    with worker_campaign(arguments) as campaign:
        workers = campaign.size
        for row in campaign.run(drive, jobs):
            rows.append(row)
            print(
                f"{row['stack']} seed {row['seed']}: {row['contacts']} contacts, {row['steps']} people,"
                f" {row['driven_m']:.0f} m in {row['time_s']:.0f} s",
                flush=True,
            )
    values: dict[str, float | int | str | bool | None] = {
        "runs": arguments.runs,
        "stacks": arguments.stacks,
        "perception": arguments.perception,
        "seed": arguments.seed,
        "workers": workers,
        "cluster": arguments.cluster or "",
    }
    report.write(arguments.json, "stepping_in", values, rows, summary(rows))


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="benchmarks.stepping_in", description=__doc__)
    parser.add_argument("--runs", type=int, default=20, help="of each stack, each with four people")
    parser.add_argument("--stacks", default="snow_lion", help="with commas between")
    parser.add_argument("--seed", type=int, default=1, help="of the first run; the next has the next")
    add_worker_arguments(parser)
    parser.add_argument("--json", type=Path, help="where to write the report")
    parser.add_argument(
        "--perception",
        choices=("tracker", "own"),
        default="tracker",
        help="road users by a tracker of the truth with noise, or found in simulated scans",
    )
    return parser.parse_args()


if __name__ == "__main__":
    main()
