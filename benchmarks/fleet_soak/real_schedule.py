"""Real time for simulated vehicles: their actions run in the event loop when they are due."""

import asyncio
import random
import time
from collections.abc import Callable
from datetime import UTC, datetime


class RealSchedule:
    """`campusloop.simulation.schedule.Schedule` of the monotonic clock; create it inside the loop."""

    def __init__(self, seed: int) -> None:
        self._seed = seed
        self._loop = asyncio.get_running_loop()
        self.start_ns = time.monotonic_ns()

    @property
    def now_ns(self) -> int:
        return time.monotonic_ns()

    @property
    def now_s(self) -> float:
        """Since the beginning."""
        return (self.now_ns - self.start_ns) * 1e-9

    def rng(self, name: str) -> random.Random:
        return random.Random(f"{self._seed}/{name}")

    def at(self, due_ns: int, action: Callable[[], None]) -> None:
        self.after((due_ns - self.now_ns) * 1e-9, action)

    def after(self, delay_s: float, action: Callable[[], None]) -> None:
        self._loop.call_later(max(0.0, delay_s), action)


class MachineClock:
    """The wall clock of server and clients alike."""

    def __init__(self) -> None:
        self.begins = self.now()

    def now(self) -> datetime:
        return datetime.now(UTC)
