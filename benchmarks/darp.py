"""Static dial-a-ride with ride-time limits, on published instances: cost against the best known.

    python -m benchmarks.darp DIR --seconds 10 [--best-known FILE] [--solutions DIR] [--json FILE]

Each instance gets the seconds of wall time on one core. Every solution is scored again from the
instance's rows
(instances/rescore.py). Best known costs come from best_known.csv in DIR or beside it; the published
files R1a to
R10b are the instances pr01 to pr20 of 2003.
"""

import time
from pathlib import Path

from benchmarks.instances.published import (
    arguments,
    best_known,
    instances_in,
    published_name,
    write_routes,
)
from benchmarks.instances.rescore import RouteBroken, rescored
from benchmarks.reporting.report import Row, RunReport
from campusloop.studies.instances.instance import Instance
from campusloop.studies.instances.task import node_routes, task_of
from server.dispatch.engine.search.optimise import Optimiser

_OPTIMAL_WITHIN = 0.006
# Part of the time that is kept for the last set partitioning.
_RESERVE = 0.05


def main() -> None:
    report = RunReport()
    parser = arguments(__doc__)
    parser.add_argument("--seconds", type=float, default=10.0)
    args = parser.parse_args()
    instances = instances_in(args.folder)
    known = best_known(args.folder, args.best_known, "cost")
    warm(instances[0])
    rows = []
    for instance in instances:
        rows.append(measured(instance, args.seconds, args.seed, known, args.solutions))
        print(rows[-1], flush=True)
    gaps = [float(str(row["gap_pct"])) for row in rows if row["gap_pct"] is not None]
    report.write(
        args.json,
        "darp",
        {"folder": str(args.folder), "seconds": args.seconds, "seed": args.seed},
        rows,
        {
            "mean_gap_pct": sum(gaps) / len(gaps) if gaps else None,
            "worst_gap_pct": max(gaps) if gaps else None,
            "optimal": sum(row["optimal"] is True for row in rows),
            "feasible": sum(row["feasible"] is True for row in rows),
            "instances": len(rows),
        },
    )


def warm(instance: Instance) -> None:
    """Load the compiled kernels, so that their loading is not in an instance's time."""
    optimiser = Optimiser(task_of(instance), 1)
    optimiser.run_slice()
    optimiser.put_together()


def measured(
    instance: Instance, seconds: float, seed: int, known: dict[str, float], solutions: Path | None
) -> Row:
    wall, cpu = time.perf_counter(), time.process_time()
    optimiser = Optimiser(task_of(instance), seed)
    reserve = _RESERVE * seconds
    while True:
        began = time.perf_counter()
        optimiser.run_slice()
        took = time.perf_counter() - began
        if optimiser.at_rest:
            reserve = max(reserve, took)
        if time.perf_counter() - wall + took + reserve > seconds:
            break
    optimiser.put_together()
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    routes = node_routes(instance, optimiser.best)
    write_routes(solutions, instance.name, routes)
    best = known.get(published_name(instance.name), known.get(instance.name))
    try:
        cost, broken = rescored(instance, routes), ""
    except RouteBroken as error:
        cost, broken = optimiser.cost, str(error)
    gap = None if best is None else 100.0 * (cost / best - 1.0)
    return {
        "instance": instance.name,
        "requests": len(instance.pairs),
        "vehicles": instance.vehicles,
        "cost": round(cost, 4),
        "best_known": best,
        "gap_pct": None if gap is None else round(gap, 4),
        "optimal": None if best is None else not broken and cost <= best + _OPTIMAL_WITHIN,
        "feasible": not broken,
        "broken": broken,
        "slices": optimiser.slices,
        "wall_s": round(wall, 2),
        "cpu_s": round(cpu, 2),
    }


if __name__ == "__main__":
    main()
