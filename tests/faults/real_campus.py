"""A real campus for fault tests: real processes that tests kill, and rides that are driven."""

import asyncio
import contextlib
import os
import signal
import socket
import time
from collections.abc import AsyncIterator, Callable
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import httpx

from campusloop.clients.passengers import (
    ENDED,
    Journey,
    Passengers,
    RideDemand,
)
from campusloop.clients.simulated_people import SimulatedPeople
from campusloop.live.campus import LiveCampus, LiveOptions
from contract.roads.load import encode_map
from contract.roads.model import RoadMap
from contract.roads.network import RoadNetwork
from contract.roads.routing import find_route
from simulator.live.ports import control_port
from tests.contract.roads.ring_map import ring_map

RIDE_WITHIN_S = 240.0
STEADY_S = 5.0


def nearest_pair(road_map: RoadMap) -> tuple[str, str]:
    """The shortest ride there is from where the first shuttle rests, the way to its start included."""
    network = RoadNetwork(road_map)
    rest = road_map.resting_places[0]
    lengths = {}
    for origin in road_map.stops:
        approach = find_route(network, rest.lane_id, rest.s_m, origin.lane_id, origin.s_m)
        for target in road_map.stops:
            ride = find_route(network, origin.lane_id, origin.s_m, target.lane_id, target.s_m)
            if origin is not target and approach is not None and ride is not None:
                lengths[origin.stop_id, target.stop_id] = approach.length_m + ride.length_m
    return min(lengths, key=lambda pair: lengths[pair])


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port


class RealCampus:
    """One shuttle without pedestrians, so that a ride takes a known while."""

    def __init__(self, campus: LiveCampus, passengers: Passengers, states: list[str]) -> None:
        self.campus = campus
        self._passengers = passengers
        self.states = states
        self.pair = nearest_pair(campus.road_map)
        self._rides: dict[int, asyncio.Task[Journey]] = {}

    def request_ride(self, pair: tuple[str, str] | None = None) -> Journey:
        """From a stop to another one; the nearest pair unless it is named."""
        journey = Journey(RideDemand(len(self._rides) + 1, 0.0, *(pair or self.pair), 1, "code"))
        ride = asyncio.create_task(self._passengers.run_journey(journey))
        self._rides[journey.demand.number] = ride
        return journey

    async def until(self, condition: Callable[[], bool], within_s: float = RIDE_WITHIN_S) -> None:
        deadline_s = time.monotonic() + within_s
        while not condition():
            for ride in self._rides.values():
                if ride.done():
                    ride.result()
            assert time.monotonic() < deadline_s, f"not within {within_s} s; {self.states} {self.logs()}"
            await asyncio.sleep(0.2)

    async def shuttle(self) -> dict[str, Any]:
        """What the console shows of the shuttle."""
        shown: dict[str, Any] = await self.campus.operator.vehicle("shuttle-1")
        return shown

    async def keep_going(self) -> None:
        """Resume the shuttle if it is held, as an operator would."""
        try:
            if (await self.campus.operator.vehicle("shuttle-1"))["held"]:
                await self.campus.operator.command("shuttle-1", "resume")
        except httpx.TransportError:
            # The console asks again, too, while the server comes back.
            return

    async def until_state(self, journey: Journey, state: str, within_s: float = RIDE_WITHIN_S) -> None:
        """The shuttle is resumed where it held itself; a passenger who was refused meanwhile asks again."""
        deadline_s = time.monotonic() + within_s
        while journey.state != state and not self._is_over(journey):
            assert time.monotonic() < deadline_s, (self.states, await self.shuttle(), self.logs())
            await self.keep_going()
            await asyncio.sleep(0.5)
        assert journey.state == state, (journey.history, journey.reason, self.logs())

    def _is_over(self, journey: Journey) -> bool:
        return journey.state in ENDED and (
            journey.state != "refused" or self._rides[journey.demand.number].done()
        )

    def kill(self, name: str) -> int:
        """SIGKILL; returns the pid that was killed."""
        pid = self.campus.pids[name]
        os.kill(pid, signal.SIGKILL)
        return pid

    async def until_restarted(self, name: str, killed_pid: int) -> None:
        await self.until(lambda: self.campus.pids.get(name, killed_pid) != killed_pid, 30.0)

    async def close(self) -> None:
        for ride in self._rides.values():
            ride.cancel()
        await asyncio.gather(*self._rides.values(), return_exceptions=True)

    def logs(self) -> str:
        logs = sorted((self.campus.options.folder / "logs").glob("*.log"))
        return "\n".join(f"== {log.name}\n{log.read_text()[-800:]}" for log in logs)


async def _in_service(campus: LiveCampus) -> None:
    """The shuttle has taken rides for a while, resumed where it held itself again; before, a ride is refused.

    On a machine that still starts other processes it may lose a deadline in its first seconds, and holds.
    """
    seen: dict[str, Any] = {}
    since_s = time.monotonic()
    deadline_s = since_s + 120.0
    while time.monotonic() - since_s < STEADY_S:
        seen = await campus.operator.vehicle("shuttle-1")
        takes_rides = seen["connected"] and seen["placed"] and not seen["held"]
        if not takes_rides:
            assert time.monotonic() < deadline_s, f"the shuttle was released and takes no rides: {seen}"
            since_s = time.monotonic()
            if seen["connected"] and seen["placed"]:
                await campus.operator.command("shuttle-1", "resume")
        await asyncio.sleep(0.5)


@contextlib.asynccontextmanager
async def a_real_campus(
    folder: Path, base_port: int, road_map: RoadMap | None = None
) -> AsyncIterator[RealCampus]:
    """Started on a ring of 464 m or another map, its shuttle released; at the end everything is stopped."""
    map_path = folder / "map.json"
    map_path.write_bytes(encode_map(road_map or ring_map()))
    options = LiveOptions(
        map_path, folder / "campus", 1, port=free_port(), base_port=base_port, pedestrians=False
    )
    campus = LiveCampus(options)
    watch: asyncio.Task[None] | None = None
    try:
        await campus.start()
        watch = asyncio.create_task(campus.watch())
        await asyncio.wait_for(campus.release_all(), 120.0)
        await _in_service(campus)
        states: list[str] = []
        people = SimulatedPeople(campus.road_map, control_port(base_port))
        passengers = Passengers(
            campus.client, people, lambda: datetime.now(UTC), lambda journey: states.append(journey.state)
        )
        async with people.listening(passengers.tap):
            real = RealCampus(campus, passengers, states)
            try:
                yield real
            finally:
                await real.close()
    finally:
        if watch is not None:
            watch.cancel()
            await asyncio.gather(watch, return_exceptions=True)
        await campus.stop()
