"""The clock of a live simulation: the computer's, or one that the starting process passes in."""

import time
from typing import Protocol


class Clock(Protocol):
    def now_ns(self) -> int: ...

    def wait(self, due_ns: int) -> None:
        """Wait until due_ns."""
        ...


class WallClock:
    """The computer's monotonic clock."""

    def now_ns(self) -> int:
        return time.monotonic_ns()

    def wait(self, due_ns: int) -> None:
        time.sleep(max(0.0, (due_ns - time.monotonic_ns()) * 1e-9))


WALL = WallClock()
