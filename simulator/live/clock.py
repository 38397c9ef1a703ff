"""The clock that a live simulation steps by: the computer's, or one that whoever starts it brings along."""

import time
from typing import Protocol


class Clock(Protocol):
    def now_ns(self) -> int: ...

    def wait(self, due_ns: int) -> None:
        """Until the clock has come to due_ns."""
        ...


class WallClock:
    """The computer's monotonic clock."""

    def now_ns(self) -> int:
        return time.monotonic_ns()

    def wait(self, due_ns: int) -> None:
        time.sleep(max(0.0, (due_ns - time.monotonic_ns()) * 1e-9))


WALL = WallClock()
