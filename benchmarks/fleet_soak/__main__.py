"""An hour of a whole fleet on a real server, on each database; judged by the rules of the simulated service.

    python -m benchmarks.fleet_soak [--minutes 60] [--settle-minutes 25] [--database sqlite postgresql]
        [--vehicles 20] [--rides-per-hour 120] [--disturb-s 120] [--seed S] [--json FILE]

The vehicles are those of `campusloop simulate-service`, in real time: the agent's own mission, outbox
(flushed to disk) and link session, over websockets, with a point for a body. Passengers book, cancel, change
their destination and type codes at doors; operators resume, hold, recall and close roads. Now and then a
connection is cut, or a vehicle's computer loses its power. Exit 1 if a rule of the history is broken, a
standing task does not work at the end, or the server had to be started again.
"""

import argparse
import asyncio
import secrets
import sys
import tempfile
from contextlib import nullcontext
from pathlib import Path

import numpy as np

from benchmarks.bookings.postgresql import postgresql_server
from benchmarks.fleet_soak.campaign import Soak, SoakOptions, soak
from benchmarks.reporting.report import Row, RunReport


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--minutes", type=float, default=60.0, help="of bookings")
    parser.add_argument("--settle-minutes", type=float, default=25.0, help="without bookings, at the end")
    parser.add_argument(
        "--database", nargs="+", choices=["sqlite", "postgresql"], default=["sqlite", "postgresql"]
    )
    parser.add_argument("--vehicles", type=int, default=20)
    parser.add_argument("--rides-per-hour", type=float, default=120.0)
    parser.add_argument("--disturb-s", type=float, default=120.0, help="between two disturbances; 0: none")
    parser.add_argument("--seed", type=int, default=None)
    parser.add_argument("--json", type=Path)
    args = parser.parse_args()
    report = RunReport()
    seed = secrets.randbelow(2**32) if args.seed is None else args.seed
    options = SoakOptions(
        seed,
        args.vehicles,
        60.0 * args.minutes,
        60.0 * args.settle_minutes,
        args.rides_per_hour,
        args.disturb_s,
    )
    rows: list[Row] = []
    for database in args.database:
        print(f"{database}: {args.minutes:g} minutes, seed {seed}", flush=True)
        with (
            tempfile.TemporaryDirectory(prefix="campusloop-soak-") as folder,
            postgresql_server() if database == "postgresql" else nullcontext("") as url,
        ):
            done = asyncio.run(soak(url, Path(folder), options))
        rows.append(_row(done))
        for state, count in done.rides.items():
            print(f"{database}: {count} rides {state}")
        for violation in done.violations:
            print(
                f"{database}: {violation.at_s:.0f} s {violation.rule} {violation.subject}: {violation.text}"
            )
    keys = ("bookings", "events", "violations", "tasks_dead", "restarts", "deadlocks")
    summary: Row = {key: sum(value for row in rows if isinstance(value := row[key], int)) for key in keys}
    arguments = {name: str(value) for name, value in vars(args).items() if name != "json"}
    report.write(args.json, "fleet_soak", arguments | {"seed": str(seed)}, rows, summary)
    if summary["violations"] or summary["tasks_dead"] or summary["restarts"]:
        sys.exit("a rule of the history is broken, a task is dead, or the server ended")


def _row(done: Soak) -> Row:
    ms = 1e3 * np.array(done.answers_s or [0.0])
    return {
        "database": done.database,
        "bookings": done.bookings,
        "completed": done.rides.get("completed", 0),
        "events": done.events,
        "driven_km": round(done.driven_m / 1000.0, 1),
        "interventions": done.interventions,
        "cuts": done.cuts,
        "crashes": done.crashes,
        "dials": done.dials,
        "answered_500": done.answers.get("500", 0),
        "p50_ms": round(float(np.percentile(ms, 50)), 1),
        "p99_ms": round(float(np.percentile(ms, 99)), 1),
        "server_cpu_s": round(done.server_cpu_s, 1),
        "memory_early_mb": round(done.memory_mb[0], 1),
        "memory_end_mb": round(done.memory_mb[1], 1),
        "deadlocks": done.deadlocks,
        "restarts": done.server_starts - 1,
        "tasks_dead": len(done.sick),
        "violations": len(done.violations),
    }


if __name__ == "__main__":
    main()
