"""Consumer-test cells with people and cyclists: `python -m benchmarks.ncap --json F [--traces DIR]`.

Crossing, running, an occluded child, turning and longitudinal, at 5 to 20 km/h, by day and by night. The
shuttle drives each cell with its whole onboard loop. It is compared with an oracle that brakes as hard as it
can as soon as the target is in sight (0.27 s, 5.6 m/s2): a contact that it avoids is avoidable. Needless hard
stops (3 m/s2 and more) are counted over --street-km of a street where people walk and stand beside the path.
"""

import argparse
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np

from benchmarks.reporting.report import Row, RunReport
from benchmarks.reporting.run_logs import LogChoice, add_log_arguments, log_choice
from campusloop.scenes.braking_oracle import best_braking
from campusloop.scenes.drive import SceneDrive
from campusloop.scenes.protection_cells import Cell, cells
from campusloop.scenes.quiet_street import quiet_street
from vehicle_agent.config import Profile, load_profile

_PROFILE = Path(__file__).resolve().parent.parent / "vehicle_agent" / "profiles" / "snow-lion.toml"
HARD_MPS2 = -3.0
_STREET_M = 500.0


def main() -> None:
    report = RunReport()
    arguments = _arguments()
    logs = log_choice(arguments)
    profile = load_profile(arguments.profile)
    chosen = list(cells(profile.body))[:: arguments.every]
    tasks = [(cell, profile, arguments.seed, arguments.traces, logs, arguments.plant_seed) for cell in chosen]
    streets = [
        (profile, arguments.seed + k, arguments.plant_seed)
        for k in range(round(1e3 * arguments.street_km / _STREET_M))
    ]
    with ProcessPoolExecutor(arguments.workers, mp_context=get_context("spawn")) as pool:
        rows = list(pool.map(_run, tasks, chunksize=4))
        stops = list(pool.map(_street, streets))
    report.write(
        arguments.json,
        "ncap",
        {"profile": str(arguments.profile), "every": arguments.every, "seed": arguments.seed}
        | {"plant_seed": arguments.plant_seed},
        rows,
        _summary(rows, stops),
    )


def _run(task: tuple[Cell, Profile, int, Path | None, LogChoice, int | None]) -> Row:
    cell, profile, seed, traces, logs, plant_seed = task
    best = best_braking(cell, profile.body, profile.lidar.x_m)
    run = SceneDrive(cell.scene(profile, seed).with_plant(plant_seed), logs.of(cell.name)).run()
    if traces is not None:
        run.trace.write(traces, cell.name)
    hits = [speed_mps for _, number, speed_mps in run.metrics.front_contacts if number == 1]
    return {
        "cell": cell.name,
        "kind": cell.kind,
        "light": cell.light,
        "speed_kmh": cell.speed_mps * 3.6,
        "avoidable": best.impact_mps is None,
        "avoided": not hits,
        "impact_mps": hits[0] if hits else None,
        "least_impact_mps": best.impact_mps,
        "clearance_m": run.metrics.clearance_m if np.isfinite(run.metrics.clearance_m) else None,
        "passed": run.time_s is not None,
    }


def _street(task: tuple[Profile, int, int | None]) -> tuple[int, float, float]:
    """(hard stops, metres, seconds) of one street."""
    profile, seed, plant_seed = task
    run = SceneDrive(quiet_street(profile, _STREET_M, seed).with_plant(plant_seed)).run()
    accel = run.trace.array()[:, 5]
    hard = accel < HARD_MPS2
    return int((hard[1:] & ~hard[:-1]).sum()), run.driven_m, float(run.trace.array()[-1, 0])


def _summary(rows: list[Row], streets: list[tuple[int, float, float]]) -> Row:
    avoidable = [row for row in rows if row["avoidable"]]
    avoided = sum(bool(row["avoided"]) for row in avoidable)
    worse = 0
    for row in rows:
        least, ours = row["least_impact_mps"], row["impact_mps"]
        worse += isinstance(least, float) and isinstance(ours, float) and ours > 1.1 * least
    driven_m = sum(metres for _, metres, _ in streets)
    seconds = sum(s for _, _, s in streets)
    return {
        "cells": len(rows),
        "avoidable_cells": len(avoidable),
        "avoidable_avoided_pct": 100.0 * avoided / len(avoidable) if avoidable else None,
        "unavoidable_avoided": sum(bool(row["avoided"]) for row in rows if not row["avoidable"]),
        "unavoidable_worse_than_10_pct": worse,
        "passed_pct": 100.0 * sum(bool(row["passed"]) for row in rows) / len(rows),
        "false_stops": sum(stops for stops, _, _ in streets),
        "street_km": driven_m / 1e3,
        "street_mean_kmh": 3.6 * driven_m / seconds if seconds else None,
    }


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="benchmarks.ncap", description=__doc__)
    parser.add_argument("--json", type=Path, help="where to write the report")
    parser.add_argument("--traces", type=Path, help="folder for two CSV files a cell")
    parser.add_argument("--profile", type=Path, default=_PROFILE)
    parser.add_argument("--every", type=int, default=1, help="every Nth cell only")
    parser.add_argument("--street-km", type=float, default=10.0, help="driven for needless hard stops")
    parser.add_argument("--workers", type=int, default=2, help="processes")
    parser.add_argument("--seed", type=int, default=1, help="of sensor noise")
    parser.add_argument("--plant-seed", type=int, help="of the vehicle's dynamics; nominal without it")
    add_log_arguments(parser)
    return parser.parse_args()


if __name__ == "__main__":
    main()
