"""The clock of a vehicle's processes.

On a vehicle it is the computer's monotonic clock. A composition that starts the processes may give them
another one, which they share.
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
        """UTC, by this computer's clock, minus this clock."""
        ...

    def wait(self, due_ns: int, files: Sequence[int] = ()) -> None:
        """Waits until due_ns or until one of the files can be read; may return earlier."""
        ...

    def work(self, until_ns: int) -> None:
        """Says that the process is at work, and need not be waited for before until_ns."""
        ...

    def close(self) -> None:
        """Ends the process's use of the clock."""
        ...


class ClockSource(Protocol):
    """Opens a process's clock; can be pickled."""

    def open(self, name: str) -> Clock:
        """name: the process's name, unique among all that share the clock."""
        ...


@dataclass(frozen=True, slots=True)
class MonotonicClock:
    """The computer's monotonic clock."""

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

    def work(self, until_ns: int) -> None: ...

    def close(self) -> None: ...


MONOTONIC = MonotonicClock()
