"""Kills, one after the other, under riders who book and vehicles that report."""

import asyncio
import random
import time
from collections import Counter
from collections.abc import AsyncIterator, Callable
from contextlib import AsyncExitStack, asynccontextmanager, nullcontext
from dataclasses import dataclass, field
from pathlib import Path

from benchmarks.bookings.nats import Nats, a_nats
from benchmarks.bookings.postgresql import PostgreSql, a_postgresql
from benchmarks.faults.agent_process import AgentProcess, an_agent
from benchmarks.faults.installation import MAP, Installation, an_installation
from benchmarks.faults.riders import Riders
from benchmarks.faults.wire_vehicle import WireVehicle
from benchmarks.kills.points import Points
from benchmarks.kills.verdict import verdict
from campusloop.simulation.history.records import Violation
from contract.roads.load import load_map
from contract.roads.network import RoadNetwork

# Each process with the points at which it is killed, drawn alike.
POINTS: dict[str, tuple[str, ...]] = {
    "server": (
        "random",
        "booking in flight",
        "event in flight",
        "hello in flight",
        "order unanswered",
        "just started",
    ),
    "agent": ("random", "event on disk", "order unanswered"),
    "database": ("random", "booking in flight", "event in flight", "hello in flight"),
    "broker": ("random", "booking in flight", "order unanswered"),
}
# Bookings are what needs all of it; so many have to be acknowledged after a kill before the next one.
_BOOKED_BETWEEN = 2
_WORKS_WITHIN_S = 90.0
_PROGRESS_EVERY = 10
_STOPPED_FOR_S = (0.0, 1.0)


@dataclass
class Campaign:
    """kills: by process and point; missed: whose point did not come; slowest_s: until bookings went on.

    orphans: processes of killed servers that still run at the end
    """

    database: str
    seed: int
    kills: Counter[str] = field(default_factory=Counter)
    missed: int = 0
    slowest_s: float = 0.0
    bookings: int = 0
    events: int = 0
    failures: int = 0
    sick: tuple[str, ...] = ()
    orphans: int = 0
    violations: list[Violation] = field(default_factory=list)
    ended: str = ""


@dataclass
class _Campus:
    installation: Installation
    postgresql: PostgreSql | None
    nats: Nats
    riders: Riders
    vehicle: WireVehicle
    agent: AgentProcess


async def kill_often(database: str, kills: int, within_s: float, seed: int, folder: Path) -> Campaign:
    """within_s: no further kill after this time"""
    until_s = time.monotonic() + within_s
    done, rng = Campaign(database, seed), random.Random(f"{seed} {database}")
    async with _a_campus(database, seed, folder) as campus:
        points = Points(campus.riders, campus.vehicle, campus.agent, rng)
        try:
            for number in range(1, kills + 1):
                if time.monotonic() > until_s:
                    break
                await _kill_once(campus, points, rng, done)
                if number % _PROGRESS_EVERY == 0:
                    booked, failed = len(campus.riders.acknowledged), len(campus.riders.failures)
                    print(
                        f"{database}: {number} kills, {booked} bookings, {failed} failed, "
                        f"{campus.agent.events} events on disk",
                        flush=True,
                    )
            await points.settle()
            await campus.installation.until_ready()
        except TimeoutError as error:
            done.ended = f"after {done.kills.total()} kills: {error}"
        done.sick = (await campus.installation.readiness()).sick
        done.violations, done.events = await verdict(
            campus.installation.url, campus.riders, campus.vehicle, campus.agent
        )
        done.orphans = len(campus.installation.orphans())
        done.bookings, done.failures = len(campus.riders.acknowledged), len(campus.riders.failures)
    return done


async def _kill_once(campus: _Campus, points: Points, rng: random.Random, done: Campaign) -> None:
    targets = [name for name in POINTS if name != "database" or campus.postgresql is not None]
    target = rng.choice(targets)
    point = rng.choice(POINTS[target])
    if not await points.reach(point):
        done.missed += 1
    await _kill(campus, target, rng.uniform(*_STOPPED_FOR_S))
    done.kills[f"{target}: {point}"] += 1
    begun_s = time.monotonic()
    booked = len(campus.riders.acknowledged)
    while len(campus.riders.acknowledged) < booked + _BOOKED_BETWEEN:
        if time.monotonic() - begun_s > _WORKS_WITHIN_S:
            raise TimeoutError(f"no bookings for {_WORKS_WITHIN_S:.0f} s after {target} was killed ({point})")
        await asyncio.sleep(0.05)
    done.slowest_s = max(done.slowest_s, time.monotonic() - begun_s)


async def _kill(campus: _Campus, target: str, stopped_for_s: float) -> None:
    """The server and the agent are started again by themselves."""
    if target == "server":
        campus.installation.kill()
    elif target == "agent":
        campus.agent.kill()
    else:
        killed = campus.postgresql if target == "database" else campus.nats
        assert killed is not None
        steps: tuple[Callable[[], None], ...] = (killed.kill, killed.start)
        await asyncio.to_thread(steps[0])
        await asyncio.sleep(stopped_for_s)
        await asyncio.to_thread(steps[1])


@asynccontextmanager
async def _a_campus(database: str, seed: int, folder: Path) -> AsyncIterator[_Campus]:
    network = RoadNetwork(load_map(MAP))
    async with AsyncExitStack() as stack:
        postgresql = stack.enter_context(a_postgresql() if database == "postgresql" else nullcontext())
        nats = stack.enter_context(a_nats())
        url = "" if postgresql is None else postgresql.url
        installation = await stack.enter_async_context(
            an_installation(folder, url, variables={"CAMPUSLOOP_BUS_URL": nats.url})
        )
        vehicle = WireVehicle(installation, network, "shuttle-1", 0)
        await vehicle.enrol()
        agent = await stack.enter_async_context(an_agent(installation, "shuttle-2", 1))
        riders = Riders(installation.origin, [stop.stop_id for stop in network.road_map.stops], seed)
        tasks = [asyncio.create_task(vehicle.run()), asyncio.create_task(riders.run())]
        try:
            await vehicle.until_served()
            yield _Campus(installation, postgresql, nats, riders, vehicle, agent)
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
