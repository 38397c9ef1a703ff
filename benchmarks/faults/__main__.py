"""Faults on real processes: `python -m benchmarks.faults [--database sqlite postgresql] [--only NAME ...]`.

Each fault meets a served campus of its own, with two shuttles on the link and riders who book. Afterwards
the server must say that all of it works, a new booking must be answered, and every acknowledged ride must be
there.
"""

import argparse
import asyncio
import random
import sys
import tempfile
import time
from collections.abc import Awaitable, Callable, Sequence
from contextlib import nullcontext
from pathlib import Path

import httpx

from benchmarks.bookings.postgresql import postgresql_server
from benchmarks.faults.installation import an_installation
from benchmarks.faults.kinds import clients, databases, processes, vehicles
from benchmarks.faults.stage import FaultNotHandled, Stage, a_stage
from benchmarks.reporting.report import Row, RunReport

Fault = Callable[[Stage], Awaitable[None]]

ON_BOTH: tuple[Fault, ...] = (
    databases.database_locked,
    processes.server_killed,
    processes.server_stopped_for_a_while,
    processes.solver_killed,
    vehicles.mad_seats,
    vehicles.mad_speed,
    vehicles.mad_stamp,
    vehicles.far_position,
    vehicles.forged_boarding,
    vehicles.two_agents_with_one_key,
    vehicles.frames_that_are_no_messages,
    vehicles.flood_of_frames,
    vehicles.connections_cut,
    clients.endless_header,
    clients.half_heads,
    clients.readers_of_the_map,
    clients.wrong_logins,
    clients.odd_questions,
    clients.revoked_token,
    clients.signed_out,
    clients.frozen_viewers,
)
ON_SQLITE: tuple[Fault, ...] = (
    databases.disk_full,
    databases.database_backed_up,
    databases.second_server_on_one_file,
)
ON_POSTGRESQL: tuple[Fault, ...] = (databases.connections_killed,)


def main() -> None:
    report = RunReport()
    parser = argparse.ArgumentParser(prog="benchmarks.faults")
    parser.add_argument(
        "--database", nargs="+", choices=["sqlite", "postgresql"], default=["sqlite", "postgresql"]
    )
    parser.add_argument("--only", nargs="+", metavar="NAME", help="these faults")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--json", type=Path)
    args = parser.parse_args()
    rows: list[Row] = []
    for database in args.database:
        for fault in (*ON_BOTH, *(ON_SQLITE if database == "sqlite" else ON_POSTGRESQL)):
            if args.only and fault.__name__ not in args.only:
                continue
            rows.append(_tried(fault, database, args.seed))
            print(rows[-1], flush=True)
    summary: Row = {
        "faults_tried": len(rows),
        "faults_survived": _sum(rows, "survived"),
        "acknowledged": _sum(rows, "acknowledged"),
        "acknowledged_lost": _sum(rows, "lost"),
        "loops_dead": _sum(rows, "loops_dead"),
        "poisoned_bookings_failed": _sum(rows, "bookings_failed"),
    }
    report.write(args.json, "faults", {"database": args.database, "seed": args.seed}, rows, summary)
    if summary["faults_survived"] != summary["faults_tried"]:
        sys.exit("not every fault was survived")


def _sum(rows: Sequence[Row], column: str) -> int:
    return sum(value for row in rows if isinstance(value := row[column], int))


def _tried(fault: Fault, database: str, seed: int) -> Row:
    opened = postgresql_server() if database == "postgresql" else nullcontext("")
    with opened as url, tempfile.TemporaryDirectory(prefix="campusloop-faults-") as folder:
        return asyncio.run(_try(fault, database, Path(folder), url, seed))


async def _try(fault: Fault, database: str, folder: Path, url: str, seed: int) -> Row:
    begun = time.monotonic()
    problem, lost, doubled, recovered_s = "", 0, 0, 0.0
    sick: tuple[str, ...] = ()
    async with an_installation(folder, url) as installation, a_stage(installation, seed) as stage:
        try:
            await fault(stage)
            recovered_s = await installation.until_ready()
            await _book_one_more(stage)
            lost, doubled = await stage.riders.lost_and_doubled()
        except (FaultNotHandled, TimeoutError, httpx.HTTPError) as error:
            problem = f"{type(error).__name__}: {error}"
        sick = (await installation.readiness()).sick
    failed = len(stage.riders.failures)
    return {
        "fault": fault.__name__,
        "database": database,
        "survived": not problem and not lost and not doubled and not sick and not failed,
        "acknowledged": len(stage.riders.acknowledged),
        "lost": lost,
        "doubled": doubled,
        "loops_dead": len(sick),
        "bookings_failed": failed,
        "slowest_booking_s": round(max(stage.riders.answers_s, default=0.0), 2),
        "recovered_s": round(recovered_s, 1),
        "starts": installation.starts,
        "took_s": round(time.monotonic() - begun, 1),
        "problem": problem[:200],
    }


async def _book_one_more(stage: Stage) -> None:
    async with httpx.AsyncClient(
        base_url=f"{stage.installation.origin}/api/v1", trust_env=False, timeout=20.0
    ) as http:
        async with asyncio.timeout(30.0):
            await stage.riders.book(http, random.Random(0))


if __name__ == "__main__":
    main()
