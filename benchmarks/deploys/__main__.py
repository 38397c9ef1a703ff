"""Rolling deploys under a fleet: what vehicles and riders notice when every server is replaced.

    python -m benchmarks.deploys [--vehicles 1000] [--deploys 10] [--events-hz 0.05] [--status-hz 1]
        [--riders 4] [--seed 1] [--json FILE]

Two replicas share a PostgreSQL and a NATS server; a switch with health checks stands before them. A deploy
replaces one server after the other: SIGTERM, the drain, a new process, until it is ready. The vehicles hold
their links and report events. Those that stand at resting places take rides: they report their status and
accept orders. They dial
again by the agent's own rule (`vehicle_agent.link.redial`). Riders repeat a booking with its key until it is
answered. Afterwards the database must have every acknowledged event, once, and every acknowledged ride.

A gap is a vehicle's time without a live link: from the last frame of one session, the farewell included, to
the welcome of the next.
"""

import argparse
import asyncio
import os
import sys
import tempfile
import threading
import time
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.bookings.nats import nats_server
from benchmarks.bookings.postgresql import postgresql_server
from benchmarks.deploys.fleet import Fleet
from benchmarks.faults.installation import Installation, an_installation, free_port
from benchmarks.faults.riders import Riders
from benchmarks.ingest.city import places, resting_places, write_city
from benchmarks.ingest.fleet_keys import enrol_fleet
from benchmarks.ingest.readback import Readback, read_back
from benchmarks.ingest.served import allow_many_files
from benchmarks.reporting.report import Row, RunReport
from contract.roads.load import load_map
from contract.roads.network import RoadNetwork

_APART_M = 48.0
_ALL_OPEN_WITHIN_S = 120.0
_BETWEEN_S = 2.0
_DRAIN_S = 60.0


@dataclass(frozen=True, slots=True)
class _Campaign:
    fleet: Fleet
    riders: Riders
    found: Readback
    lost_rides: int
    doubled_rides: int
    replaced_s: list[float]


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--vehicles", type=int, default=1000)
    parser.add_argument("--deploys", type=int, default=10)
    parser.add_argument("--events-hz", type=float, default=0.05, help="events of a vehicle a second")
    parser.add_argument("--status-hz", type=float, default=1.0, help="of the vehicles that take rides")
    parser.add_argument("--riders", type=int, default=4)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--json", type=Path)
    args = parser.parse_args()
    report = RunReport()
    allow_many_files()
    with (
        tempfile.TemporaryDirectory(prefix="campusloop-deploys-") as name,
        postgresql_server() as url,
        nats_server() as bus,
    ):
        done = asyncio.run(_deploy_often(args, Path(name), url, bus))
    row = _row(args, done)
    arguments = {name: str(value) for name, value in vars(args).items() if name != "json"}
    summary = {name: row[name] for name in ("deploys", "lost", "doubled", "gap_p50_s", "gap_p99_s")}
    summary["failed_bookings"] = row["failed_bookings"]
    report.write(args.json, "deploys", arguments, [row], summary)
    if row["lost"] or row["doubled"] or row["failed_bookings"]:
        sys.exit("something acknowledged was lost or doubled, or a booking failed")


def _row(args: argparse.Namespace, done: _Campaign) -> Row:
    gaps_s = np.array(done.fleet.gaps_s or [0.0])
    return {
        "vehicles": args.vehicles,
        "deploys": args.deploys,
        "events": done.found.stored,
        "unacknowledged": done.fleet.ledger.unacknowledged,
        "bookings": len(done.riders.acknowledged),
        "lost": done.found.lost + done.found.altered + done.lost_rides,
        "doubled": done.found.doubled + done.doubled_rides,
        "gaps": len(done.fleet.gaps_s),
        "gap_p50_s": round(float(np.percentile(gaps_s, 50)), 3),
        "gap_p99_s": round(float(np.percentile(gaps_s, 99)), 3),
        "gap_max_s": round(float(gaps_s.max()), 3),
        "failed_dials": done.fleet.failed_dials,
        "failed_bookings": len(done.riders.failures),
        "repeated_bookings": done.riders.unanswered,
        "slowest_booking_s": round(max(done.riders.answers_s, default=0.0), 2),
        "replaced_p50_s": round(float(np.percentile(done.replaced_s, 50)), 1),
        "load_average": round(os.getloadavg()[0], 2),
    }


async def _deploy_often(args: argparse.Namespace, folder: Path, url: str, bus: str) -> _Campaign:
    write_city(folder / "city.json", args.vehicles, _APART_M)
    road_map = load_map(folder / "city.json")
    resting = resting_places(road_map, RoadNetwork(road_map))
    where = [*resting, *places(road_map, args.vehicles - len(resting))]
    variables = {"CAMPUSLOOP_BUS_URL": bus, "CAMPUSLOOP_TICKET_KEY_FILE": str(folder / "ticket.key")}
    enrolling = Installation(folder / "enrolling", url, folder / "city.json", variables)
    await enrolling.http.aclose()
    await asyncio.to_thread(
        enrol_fleet,
        enrolling.environment() | {"CAMPUSLOOP_MAP_PATH": str(folder / "city.json")},
        args.vehicles,
        len(resting),
    )
    async with AsyncExitStack() as stack:
        replicas = [
            await stack.enter_async_context(
                an_installation(
                    folder / name, url, folder / "city.json", variables | {"CAMPUSLOOP_SERVER_NAME": name}
                )
            )
            for name in ("server-1", "server-2")
        ]
        port = await stack.enter_async_context(_switch([replica.port for replica in replicas]))
        stops = [stop.stop_id for stop in road_map.stops]
        riders = Riders(f"http://127.0.0.1:{port}", stops, args.seed)
        fleet = Fleet(port, where, len(resting), road_map.map_version, args.seed)
        replaced_s = await _under_load(args, replicas, fleet, riders)
        lost_rides, doubled_rides = await riders.lost_and_doubled()
    found = read_back(url, fleet.ledger.acknowledged_below, where)
    return _Campaign(fleet, riders, found, lost_rides, doubled_rides, replaced_s)


async def _under_load(
    args: argparse.Namespace, replicas: list[Installation], fleet: Fleet, riders: Riders
) -> list[float]:
    """Seconds that the replacement of each server took."""
    stopped = threading.Event()
    driving = asyncio.create_task(
        asyncio.to_thread(fleet.run, stopped, args.events_hz, args.status_hz, _DRAIN_S)
    )
    booking: asyncio.Task[None] | None = None
    replaced_s: list[float] = []
    try:
        begun_s = time.monotonic()
        await _until_connected(fleet, args.vehicles, driving)
        print(f"{args.vehicles} sessions opened in {time.monotonic() - begun_s:.1f} s", flush=True)
        booking = asyncio.create_task(riders.run(args.riders))
        for deploy in range(1, args.deploys + 1):
            for replica in replicas:
                gaps = len(fleet.gaps_s)
                replaced_s.append(await replica.replace())
                await asyncio.sleep(_BETWEEN_S)
                new_s = fleet.gaps_s[gaps:] or [0.0]
                print(
                    f"deploy {deploy}, port {replica.port}: {replaced_s[-1]:.1f} s; {len(new_s)} gaps, "
                    f"p99 {np.percentile(new_s, 99):.2f} s; {len(riders.acknowledged)} bookings",
                    flush=True,
                )
                if driving.done():
                    driving.result()
        await _until_connected(fleet, args.vehicles, driving)
    finally:
        stopped.set()
        if booking is not None:
            booking.cancel()
            await asyncio.gather(booking, return_exceptions=True)
        await driving
    return replaced_s


async def _until_connected(fleet: Fleet, count: int, driving: "asyncio.Task[None]") -> None:
    until_s = time.monotonic() + _ALL_OPEN_WITHIN_S
    while fleet.connected < count and not driving.done():
        if time.monotonic() > until_s:
            raise TimeoutError(f"{fleet.connected} of {count} vehicles have a session")
        await asyncio.sleep(0.2)


@asynccontextmanager
async def _switch(ports: list[int]) -> AsyncIterator[int]:
    """The port of the switch, a process of its own."""
    port = free_port()
    command = [sys.executable, "-m", "benchmarks.deploys.switch", str(port), *map(str, ports)]
    process = await asyncio.create_subprocess_exec(*command, stdout=asyncio.subprocess.PIPE)
    try:
        assert process.stdout is not None
        await process.stdout.readline()
        yield port
    finally:
        process.terminate()
        await process.wait()


if __name__ == "__main__":
    main()
