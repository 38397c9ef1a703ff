"""Tightness and time of proven lower bounds of dial-a-ride instances.

    python -m benchmarks.bound DIR --seconds 600 [--optima FILE] [--json FILE] [--solutions DIR]

Each instance gets the seconds of wall time, in one thread. Its bound is compared with the best known cost:
CSV with the columns instance and cost, by default best_known.csv in DIR or beside it; without one, with the
best solution found. `closed`: that cost is proven optimal, to the second decimal. `valid`: the bound is not
above it.
"""

import argparse
from pathlib import Path

from benchmarks.instances.published import (
    best_known,
    instances_in,
    published_name,
    write_routes,
)
from benchmarks.reporting.report import Row, RunReport
from campusloop.studies.bound.events import TooManyEvents
from campusloop.studies.bound.progress import CLOSED_WITHIN
from campusloop.studies.bound.warm import warm_kernels as warm_bound
from campusloop.studies.dispatch.bound_run import BoundRun, run_bound
from campusloop.studies.instances.instance import Instance, InstanceBroken
from server.dispatch.engine.warm import warm_kernels as warm_engine

# Best known costs are published with two decimals, some rounded up and some down.
_ROUNDED_BY = 0.01


def main() -> None:
    report = RunReport()
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path, metavar="DIR", help="instances, or one of them")
    parser.add_argument("--seconds", type=float, default=600.0, help="wall time an instance")
    parser.add_argument("--optima", type=Path, help="CSV: instance, cost")
    parser.add_argument("--solutions", type=Path, metavar="DIR", help="write the best routes here")
    parser.add_argument("--json", type=Path, metavar="FILE")
    args = parser.parse_args()
    instances = instances_in(args.folder)
    known = best_known(args.folder, args.optima, "cost")
    warm_engine()
    warm_bound()
    rows = []
    for instance in instances:
        optimum = known.get(published_name(instance.name), known.get(instance.name))
        rows.append(measured(instance, args.seconds, optimum, args.solutions))
        print(rows[-1], flush=True)
    gaps = [float(str(row["gap_pct"])) for row in rows if row["gap_pct"] is not None]
    report.write(
        args.json,
        "bound",
        {"folder": str(args.folder), "seconds": args.seconds},
        rows,
        {
            "closed": sum(row["closed"] is True for row in rows),
            "mean_gap_pct": sum(gaps) / len(gaps) if gaps else None,
            "worst_gap_pct": max(gaps) if gaps else None,
            "valid": sum(row["valid"] is True for row in rows),
            "instances": len(rows),
        },
    )


def measured(instance: Instance, seconds: float, optimum: float | None, solutions: Path | None) -> Row:
    try:
        run = run_bound(instance, seconds)
    except (InstanceBroken, TooManyEvents) as error:
        refused: Row = dict.fromkeys(
            ("bound", "optimum", "solution", "gap_pct", "closed", "valid", "limited_by", "wall_s", "cpu_s")
        )
        return {
            "instance": instance.name,
            **refused,
            "optimum": optimum,
            "closed": False,
            "limited_by": str(error),
        }
    write_routes(solutions, instance.name, run.best.routes)
    bound = run.proven.bound
    return {
        "instance": instance.name,
        "bound": round(bound, 4),
        "optimum": optimum,
        "solution": round(run.best.cost, 4) if run.best.routes else None,
        "gap_pct": _gap_pct(run, optimum),
        "closed": run.closed or (optimum is not None and bound > optimum - CLOSED_WITHIN),
        "valid": None if optimum is None else bound <= optimum + _ROUNDED_BY,
        "limited_by": run.limited_by,
        "rounds": run.proven.rounds,
        "cuts": run.proven.cuts,
        "nodes": run.proven.nodes,
        "wall_s": round(run.wall_s, 2),
        "cpu_s": round(run.cpu_s, 2),
    }


def _gap_pct(run: BoundRun, optimum: float | None) -> float | None:
    if optimum is None:
        return run.gap_pct
    return round(100.0 * max(0.0, optimum - run.proven.bound) / optimum, 4)


if __name__ == "__main__":
    main()
