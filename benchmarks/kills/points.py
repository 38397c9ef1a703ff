"""When a process is killed: at a random moment, or at a named point of the protocol.

A point is reached by what the protocol shows from outside: a request is written and its answer is not read,
an event is sent and not acknowledged, a hello is said, an order has come, an event is on the vehicle's disk.
Then a few milliseconds pass, so that the kill falls before, in and after the server's transaction.
"""

import asyncio
import random
import time
from collections.abc import Awaitable, Callable

import httpx

from benchmarks.faults.agent_process import AgentProcess
from benchmarks.faults.riders import Riders
from benchmarks.faults.wire_vehicle import WireVehicle
from contract.wire.messages import DoorsChanged

_REACHED_WITHIN_S = 10.0
_LOOKS_EVERY_S = 0.002
_FEW_MS = (0.0, 0.02)


class Points:
    """`reach` returns at the moment of the kill: True at the named point, False if it did not come."""

    def __init__(self, riders: Riders, vehicle: WireVehicle, agent: AgentProcess, rng: random.Random) -> None:
        self._riders, self._vehicle, self._agent, self._rng = riders, vehicle, agent, rng
        self._tasks: set[asyncio.Task[str]] = set()
        self._ways: dict[str, Callable[[], Awaitable[bool]]] = {
            "random": self._random,
            "booking in flight": self._booking,
            "event in flight": self._event,
            "hello in flight": self._hello,
            "order unanswered": self._order,
            "event on disk": self._on_disk,
            "just started": self._just_started,
        }

    async def reach(self, point: str) -> bool:
        reached = await self._ways[point]()
        if point not in ("random", "just started"):
            await asyncio.sleep(self._rng.uniform(*_FEW_MS))
        return reached

    async def settle(self) -> None:
        """Wait for the bookings that were begun here."""
        if self._tasks:
            await asyncio.wait(self._tasks, timeout=60.0)

    async def _random(self) -> bool:
        await asyncio.sleep(self._rng.uniform(0.2, 2.0))
        return True

    async def _booking(self) -> bool:
        async def book() -> str:
            async with httpx.AsyncClient(
                base_url=f"{self._riders.origin}/api/v1", trust_env=False, timeout=20.0
            ) as http:
                return await self._riders.book(http, self._rng)

        task = asyncio.create_task(book())
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
        # The client builds its connection first.
        await asyncio.sleep(self._rng.uniform(0.0, 0.06))
        return not task.done()

    async def _event(self) -> bool:
        self._vehicle.report(DoorsChanged(True, f"visit-{len(self._vehicle.events)}"))
        try:
            await self._vehicle.send_events()
        except (TimeoutError, ConnectionError):
            return False
        return True

    async def _hello(self) -> bool:
        before = self._vehicle.hellos
        try:
            await self._vehicle.cut()
        except TimeoutError:
            return False
        return await self._until(lambda: self._vehicle.hellos > before)

    async def _order(self) -> bool:
        before = len(self._vehicle.orders)
        return await self._until(lambda: len(self._vehicle.orders) > before)

    async def _on_disk(self) -> bool:
        before = self._agent.events
        return await self._until(lambda: self._agent.events > before)

    async def _just_started(self) -> bool:
        """Soon after the last kill, while what was killed then starts."""
        await asyncio.sleep(self._rng.uniform(0.3, 4.0))
        return True

    async def _until(self, condition: Callable[[], bool]) -> bool:
        until_s = time.monotonic() + _REACHED_WITHIN_S
        while not condition():
            if time.monotonic() > until_s:
                return False
            await asyncio.sleep(_LOOKS_EVERY_S)
        return True
