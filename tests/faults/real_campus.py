"""A real campus for fault tests: processes that can really be killed, rides that are really driven."""

import asyncio
import contextlib
import os
import signal
import socket
import time
from collections.abc import AsyncIterator, Callable
from datetime import UTC, datetime
from pathlib import Path

from campusloop.headless import ride_pairs
from campusloop.live_campus import LiveCampus, LiveOptions
from campusloop.passengers import ENDED, Journey, Passengers, Wish
from campusloop.simulated_people import SimulatedPeople
from simulator.live_ports import control_port

ROOT = Path(__file__).resolve().parents[2]
SHIPPED = ROOT / "maps" / "shanghai-university" / "map.json"
RIDE_WITHIN_S = 240.0


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port


class RealCampus:
    """One shuttle without pedestrians, so that a ride takes a known while."""

    def __init__(self, campus: LiveCampus, passengers: Passengers) -> None:
        self.campus = campus
        self._passengers = passengers
        self.told: list[str] = []
        pairs = ride_pairs(campus.road_map, 120.0)
        self.pair = pairs[0]
        self._lives: list[asyncio.Task[Journey]] = []

    def ask(self) -> Journey:
        journey = Journey(Wish(len(self._lives) + 1, 0.0, *self.pair, 1, "code"))
        self._lives.append(asyncio.create_task(self._passengers.live(journey)))
        return journey

    async def until(self, condition: Callable[[], bool], within_s: float = RIDE_WITHIN_S) -> None:
        deadline_s = time.monotonic() + within_s
        while not condition():
            for life in self._lives:
                if life.done():
                    life.result()
            assert time.monotonic() < deadline_s, f"not within {within_s} s; {self._said()}"
            await asyncio.sleep(0.2)

    async def until_state(self, journey: Journey, state: str, within_s: float = RIDE_WITHIN_S) -> None:
        await self.until(lambda: journey.state == state or journey.state in ENDED, within_s)
        assert journey.state == state, (journey.history, journey.reason)

    def kill(self, name: str) -> int:
        """SIGKILL; returns the pid that was killed."""
        pid = self.campus.pids[name]
        os.kill(pid, signal.SIGKILL)
        return pid

    async def until_restarted(self, name: str, killed_pid: int) -> None:
        await self.until(lambda: self.campus.pids.get(name, killed_pid) != killed_pid, 30.0)

    async def close(self) -> None:
        for life in self._lives:
            life.cancel()
        await asyncio.gather(*self._lives, return_exceptions=True)

    def _said(self) -> str:
        logs = sorted((self.campus.options.folder / "logs").glob("*.log"))
        return "\n".join(f"== {log.name}\n{log.read_text()[-800:]}" for log in logs)


@contextlib.asynccontextmanager
async def a_real_campus(folder: Path, base_port: int) -> AsyncIterator[RealCampus]:
    """Started, its shuttle released; everything is stopped at the end, whatever happened."""
    options = LiveOptions(
        SHIPPED, folder / "campus", 1, port=free_port(), base_port=base_port, pedestrians=False
    )
    campus = LiveCampus(options)
    watch: asyncio.Task[None] | None = None
    try:
        await campus.start()
        watch = asyncio.create_task(campus.watch())
        await asyncio.wait_for(campus.release_all(), 60.0)
        people = SimulatedPeople(campus.road_map, control_port(base_port))
        passengers = Passengers(campus.client, people, lambda: datetime.now(UTC), lambda _: None)
        async with people.listening(passengers.tap):
            real = RealCampus(campus, passengers)
            try:
                yield real
            finally:
                await real.close()
    finally:
        if watch is not None:
            watch.cancel()
            await asyncio.gather(watch, return_exceptions=True)
        await campus.stop()
