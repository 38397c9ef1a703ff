"""The clock that a vehicle's processes live by.

On a vehicle it is the computer's monotonic clock. A composition that starts the processes may give them
another one, which all of them share.
"""

import select
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol


class Clock(Protocol):
    """One process's view of the clock."""

    def now_ns(self) -> int: ...

    def utc_offset_ns(self) -> int:
        """UTC minus this clock, by this computer's own idea of UTC."""
        ...

    def wait(self, due_ns: int, files: Sequence[int] = ()) -> None:
        """Until the clock has come to due_ns or one of the files can be read; sometimes sooner."""
        ...

    def close(self) -> None:
        """The process ends in order."""
        ...


class ClockSource(Protocol):
    """What a process is given to open its clock with; it can be pickled."""

    def open(self, name: str) -> Clock:
        """name: the process's own among all that share the clock."""
        ...


@dataclass(frozen=True, slots=True)
class MonotonicClock:
    """The computer's own: nothing stops it."""

    def open(self, name: str) -> Clock:
        return self

    def now_ns(self) -> int:
        return time.monotonic_ns()

    def utc_offset_ns(self) -> int:
        return time.time_ns() - time.monotonic_ns()

    def wait(self, due_ns: int, files: Sequence[int] = ()) -> None:
        pause_s = max(0.0, (due_ns - time.monotonic_ns()) / 1e9)
        if files:
            select.select(files, [], [], pause_s)
        elif pause_s > 0.0:
            time.sleep(pause_s)

    def close(self) -> None: ...


MONOTONIC = MonotonicClock()
