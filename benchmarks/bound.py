"""How tight and how quick the proven lower bounds of dial-a-ride instances are.

    python -m benchmarks.bound DIR --seconds 600 [--best-known FILE] [--json F]

Every instance (*.txt) of DIR on one core, against the best known cost: CSV with the columns instance, cost, status,
by default best_known.csv in DIR or beside it. `closed`: the bound is the best known cost to the second decimal, or
a solution was found that is as cheap as the bound.
"""

import argparse
import csv
import os
from pathlib import Path

from benchmarks.report import Row, write_report
from campusloop.bound_run import BoundRun, run_bound
from server.dispatch.bound.events import TooManyEvents
from server.dispatch.instance import InstanceBroken
from server.feeds.instances.load import load_instance

CENT = 0.01  # best known costs are published with two decimals


def main() -> None:
    arguments = _arguments()
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    known_path = arguments.best_known or _beside(arguments.folder)
    best_known = _best_known(known_path) if known_path else {}
    rows = []
    for path in sorted(arguments.folder.glob(arguments.only)):
        row = _row(path, best_known.get(path.stem), arguments.seconds)
        print(row, flush=True)
        rows.append(row)
    gaps = [gap for row in rows if isinstance(gap := row["gap_pct"], float)]
    summary: Row = {
        "worst_gap_pct": max(gaps, default=None),
        "closed": sum(row["closed"] is True for row in rows),
        "instances": len(rows),
        "valid": all(row["valid"] is not False for row in rows),
        "wall_s_max": max((w for row in rows if isinstance(w := row["wall_s"], float)), default=None),
    }
    write_report(
        arguments.json,
        "bound",
        {
            "folder": str(arguments.folder),
            "only": arguments.only,
            "seconds": arguments.seconds,
            "best_known": str(known_path) if known_path else None,
            "cores_used": 1,
        },
        rows,
        summary,
    )


def _row(path: Path, best: float | None, seconds: float) -> Row:
    """One instance. gap_pct: to the best known cost, to the best solution found where none is known."""
    try:
        run = run_bound(load_instance(path), seconds)
    except (InstanceBroken, TooManyEvents) as error:
        return {"instance": path.stem, "best_known": best, "gap_pct": None, "wall_s": None, "closed": False} | {
            "valid": None,
            "refused": str(error),
        }
    bound = run.proven.bound
    return {
        "instance": path.stem,
        "bound": round(bound, 4),
        "best_known": best,
        "solution": round(run.proven.upper, 4) if run.proven.solution else None,
        "gap_pct": run.gap_pct if best is None else 100.0 * max(0.0, best - bound) / best,
        "closed": _closed(run, best),
        "valid": None if best is None else bound <= best + CENT,
        "wall_s": run.wall_s,
        "cpu_s": run.cpu_s,
    }


def _closed(run: BoundRun, best: float | None) -> bool:
    return run.proven.closed or (best is not None and run.proven.bound > best - CENT / 2)


def _beside(folder: Path) -> Path | None:
    candidates = (folder / "best_known.csv", folder.resolve().parent / "best_known.csv")
    return next((path for path in candidates if path.exists()), None)


def _best_known(path: Path) -> dict[str, float]:
    with path.open(encoding="utf-8", newline="") as lines:
        return {row["instance"]: float(row["cost"]) for row in csv.DictReader(lines)}


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("folder", type=Path, metavar="DIR", help="instances in Cordeau's format")
    parser.add_argument("--seconds", type=float, default=600.0, help="wall time an instance")
    parser.add_argument("--best-known", type=Path, help="CSV: instance, cost, status")
    parser.add_argument("--only", default="*.txt", help="which files of DIR")
    parser.add_argument("--json", type=Path, help="write the report here")
    return parser.parse_args()


if __name__ == "__main__":
    main()
