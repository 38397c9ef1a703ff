"""What simulated people and vehicles need of time and of the wire: virtual, or real in a soak."""

import random
from collections.abc import Callable
from datetime import datetime
from typing import Protocol


class TimeSource(Protocol):
    @property
    def now_ns(self) -> int: ...


class Schedule(TimeSource, Protocol):
    """Runs actions when they are due."""

    def rng(self, name: str) -> random.Random:
        """A separate random stream for each named purpose."""
        ...

    def at(self, due_ns: int, action: Callable[[], None]) -> None:
        """Run the action at due_ns, or at once if that is past."""
        ...

    def after(self, delay_s: float, action: Callable[[], None]) -> None: ...


class Clock(Protocol):
    """The server machine's clock. begins: what it showed when the history began."""

    @property
    def begins(self) -> datetime: ...

    def now(self) -> datetime: ...


class VehicleEnd(Protocol):
    """The vehicle's end of a connection."""

    def listen(self, on_message: Callable[[bytes], None], on_close: Callable[[str], None]) -> None:
        """Said by its owner before anything arrives."""
        ...

    def send(self, data: bytes) -> None: ...

    def close(self, code: int, reason: str) -> None:
        """An orderly close: frames sent before it still arrive."""
        ...


class Dialler(Protocol):
    def dial(self, vehicle_id: str, opened: Callable[[VehicleEnd | None], None]) -> None:
        """Calls `opened` with the vehicle's end of a new connection, or with None if it cannot be made."""
        ...
