"""SIGKILL again and again, and nothing acknowledged may be lost: `make soak-kill N=500`.

    python -m benchmarks.kills [--kills 500] [--minutes M] [--database sqlite postgresql] [--seed S]
        [--json FILE]

One server, its database, a NATS server, a vehicle's link process with its outbox, and riders who book: each
is killed at random moments and at named points of the protocol (`benchmarks/kills/points.py`), and started
again while the others go on. The kills are shared out among the databases. Afterwards the history is judged
by the rules that `campusloop simulate-service` has. The seed is drawn if none is given, and printed.
"""

import argparse
import asyncio
import secrets
import sys
import tempfile
import time
from pathlib import Path

from benchmarks.kills.campaign import Campaign, kill_often
from benchmarks.reporting.report import Row, RunReport


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--kills", type=int, default=500, help="on all databases together")
    parser.add_argument(
        "--database", nargs="+", choices=["sqlite", "postgresql"], default=["sqlite", "postgresql"]
    )
    parser.add_argument("--minutes", type=float, default=24 * 60.0, help="no further kill after this time")
    parser.add_argument("--seed", type=int, default=None)
    parser.add_argument("--json", type=Path)
    args = parser.parse_args()
    report = RunReport()
    seed = secrets.randbelow(2**32) if args.seed is None else args.seed
    rows: list[Row] = []
    for number, database in enumerate(args.database):
        kills = args.kills // len(args.database) + (number < args.kills % len(args.database))
        print(f"{database}: {kills} kills, seed {seed}", flush=True)
        begun_s = time.monotonic()
        with tempfile.TemporaryDirectory(prefix="campusloop-kills-") as folder:
            within_s = 60.0 * args.minutes / len(args.database)
            done = asyncio.run(kill_often(database, kills, within_s, seed, Path(folder)))
        rows.append(_row(done, time.monotonic() - begun_s))
        for point, count in sorted(done.kills.items()):
            print(f"{database}: {count} x {point}")
        for violation in done.violations:
            print(f"{database}: {violation}")
    summary: Row = {
        name: sum(value for row in rows if isinstance(value := row[name], int))
        for name in ("kills", "bookings", "events", "lost", "doubled", "violations", "tasks_dead", "orphans")
    }
    report.write(args.json, "kills", {"kills": args.kills, "seed": seed}, rows, summary)
    if (
        summary["violations"]
        or summary["tasks_dead"]
        or summary["orphans"]
        or any(row["ended"] for row in rows)
    ):
        sys.exit("the history breaks a rule, a killed server left processes, or the campaign ended early")


def _row(done: Campaign, took_s: float) -> Row:
    rules = [violation.rule for violation in done.violations]
    return {
        "database": done.database,
        "seed": done.seed,
        "kills": done.kills.total(),
        "points_missed": done.missed,
        "bookings": done.bookings,
        "bookings_failed": done.failures,
        "events": done.events,
        "lost": sum(rule in ("booking_lost", "event_lost") for rule in rules),
        "doubled": sum(rule in ("booking_doubled", "ride_planned_twice", "event_doubled") for rule in rules),
        "violations": len(rules) + done.failures,
        "tasks_dead": len(done.sick),
        "orphans": done.orphans,
        "slowest_s": round(done.slowest_s, 1),
        "took_s": round(took_s, 1),
        "ended": done.ended,
    }


if __name__ == "__main__":
    main()
