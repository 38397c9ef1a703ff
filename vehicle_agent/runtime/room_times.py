"""The time that each onboard room takes, measured from outside, because the rooms have no clock."""

import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from contract.wire.messages import RoomTime, TickTimes
from vehicle_agent.onboard.car import Car

ROOMS = (
    "can",
    "localization",
    "perception",
    "world",
    "mission",
    "planning",
    "control",
    "guard",
    "hmi",
)
TIMED = ("step", "decode", "encode")


def timed(car: Car, note: Callable[[str, int], None]) -> Car:
    """The same car; `note` gets the room and the wall time in ns of each of its calls.

    Wall time, because the thread's CPU clock needs a system call.
    """
    rooms: dict[str, Any] = {name: _TimedRoom(getattr(car, name), name, note) for name in ROOMS}
    return replace(car, **rooms)


class TickStopwatch:
    """The times of the slowest tick since they were taken last: `timed` once, `note` after each tick."""

    def __init__(self) -> None:
        self._now = dict.fromkeys(ROOMS, 0)
        self._slowest: TickTimes | None = None

    def timed(self, car: Car) -> Car:
        return timed(car, self._add)

    def note(self, whole_ns: int, late_ns: int) -> None:
        """The tick has ended; whole_ns: its time with everything around the rooms."""
        if self._slowest is None or whole_ns // 1000 > self._slowest.whole_us:
            rooms = tuple(RoomTime(name, spent // 1000) for name, spent in self._now.items())
            self._slowest = TickTimes(rooms, whole_ns // 1000, max(late_ns, 0) // 1000)
        self._now = dict.fromkeys(ROOMS, 0)

    def take(self) -> TickTimes | None:
        """None before the first tick."""
        slowest, self._slowest = self._slowest, None
        return slowest

    def _add(self, room: str, spent_ns: int) -> None:
        self._now[room] += spent_ns


class _TimedRoom:
    """A proxy of a room that times its calls."""

    def __init__(self, room: Any, name: str, note: Callable[[str, int], None]) -> None:
        self._room, self._name, self._note = room, name, note

    def __getattr__(self, name: str) -> Any:
        inner = getattr(self._room, name)
        if name not in TIMED:
            return inner
        room, note = self._name, self._note

        def call(*arguments: Any) -> Any:
            begun = time.perf_counter_ns()
            result = inner(*arguments)
            note(room, time.perf_counter_ns() - begun)
            return result

        setattr(self, name, call)
        return call
