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

from benchmarks.bookings.nats import Nats, a_nats
from benchmarks.bookings.postgresql import PostgreSql, a_postgresql
from benchmarks.faults.installation import an_installation
from benchmarks.faults.kinds import (
    board,
    buses,
    clients,
    databases,
    files,
    networks,
    processes,
    receivers,
    vehicles,
)
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
    databases.long_reader,
    processes.server_stopped_for_long,
    processes.server_replaced_in_order,
    processes.out_of_descriptors,
    vehicles.vehicle_clock_jumps,
    vehicles.gaps_and_repeats,
    vehicles.vehicle_that_does_not_read,
    networks.connection_forgotten_by_nat,
    networks.backlog_of_a_day,
    board.agent_killed,
    board.server_killed_with_a_backlog,
    receivers.webhook_that_hangs,
)
# They do not touch the database: once is enough.
ON_FIRST: tuple[Fault, ...] = (
    networks.proxy_without_a_server,
    networks.frames_byte_by_byte,
    board.disk_full_on_board,
    board.power_cut_on_board,
    receivers.webhook_without_an_end,
    receivers.webhook_that_fails,
    files.certificate_unreadable,
    files.ticket_key_unreadable,
    files.ticket_key_exchanged,
    files.segment_store_gone,
    files.corrupt_segment,
)
# With a NATS server, as several replicas have one.
ON_BROKER: tuple[Fault, ...] = (
    buses.broker_killed,
    buses.broker_frozen,
    buses.slow_consumer,
    buses.nonsense_on_the_bus,
)
ON_SQLITE: tuple[Fault, ...] = (
    databases.disk_full,
    databases.database_backed_up,
    databases.second_server_on_one_file,
)
ON_POSTGRESQL: tuple[Fault, ...] = (
    databases.connections_killed,
    databases.database_killed,
    databases.database_away,
    databases.database_read_only,
    databases.connections_used_up,
)


def main() -> None:
    report = RunReport()
    parser = argparse.ArgumentParser(prog="benchmarks.faults")
    parser.add_argument(
        "--database", nargs="+", choices=["sqlite", "postgresql"], default=["sqlite", "postgresql"]
    )
    known = sorted(
        {fault.__name__ for fault in (*ON_BOTH, *ON_FIRST, *ON_BROKER, *ON_SQLITE, *ON_POSTGRESQL)}
    )
    parser.add_argument(
        "--only", nargs="+", metavar="NAME", choices=known, help=f"these faults: {', '.join(known)}"
    )
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--json", type=Path)
    args = parser.parse_args()
    rows: list[Row] = []
    for database in args.database:
        own = ON_SQLITE if database == "sqlite" else ON_POSTGRESQL
        once = (*ON_FIRST, *ON_BROKER) if database == args.database[0] else ()
        for fault in (*ON_BOTH, *own, *once):
            if args.only and fault.__name__ not in args.only:
                continue
            rows.append(_tried(fault, database, args.seed))
            print(rows[-1], flush=True)
    summary: Row = {
        "faults_tried": len(rows),
        "kinds": len({row["fault"] for row in rows}),
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
    with (
        a_postgresql() if database == "postgresql" else nullcontext() as postgresql,
        a_nats() if fault in ON_BROKER else nullcontext() as nats,
        tempfile.TemporaryDirectory(prefix="campusloop-faults-") as folder,
    ):
        return asyncio.run(_try(fault, database, Path(folder), postgresql, nats, seed))


async def _try(
    fault: Fault, database: str, folder: Path, postgresql: PostgreSql | None, nats: Nats | None, seed: int
) -> Row:
    begun = time.monotonic()
    problem, lost, doubled, recovered_s = "", 0, 0, 0.0
    sick: tuple[str, ...] = ()
    url = "" if postgresql is None else postgresql.url
    variables = {"CAMPUSLOOP_WEBHOOK_ALLOWED_NETWORKS": "127.0.0.0/8"}
    if nats is not None:
        variables["CAMPUSLOOP_BUS_URL"] = nats.url
    async with (
        an_installation(folder, url, variables=variables) as installation,
        a_stage(installation, seed, postgresql, nats) as stage,
    ):
        try:
            await fault(stage)
            recovered_s = await installation.until_ready()
            await _book_one_more(stage)
            lost, doubled = await stage.riders.lost_and_doubled()
            lost += len(stage.lost_events())
        except (FaultNotHandled, TimeoutError, httpx.HTTPError) as error:
            problem = f"{type(error).__name__}: {error}"
        sick = (await installation.readiness()).sick
    failed = len(stage.riders.failures)
    if failed and not problem:
        problem = f"a booking was answered with {stage.riders.failures[0]}"
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
