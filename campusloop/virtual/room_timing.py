"""How long each onboard room takes, measured from outside: the rooms themselves know no clock."""

import time
from dataclasses import replace
from typing import Any

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


class RoomTimes:
    """Wall time of every call, in ns, by room; `whole` is the complete tick with its recording.

    The thread's CPU clock is a system call, and nearly all that runs in virtual time is this thread.
    """

    def __init__(self) -> None:
        self.by_room: dict[str, list[int]] = {room: [] for room in ROOMS}
        self.whole: list[int] = []

    def timed(self, car: Car) -> Car:
        """The same car, with a stopwatch at every door."""
        rooms: dict[str, Any] = {name: _TimedRoom(getattr(car, name), self.by_room[name]) for name in ROOMS}
        return replace(car, **rooms)


class _TimedRoom:
    """Stands in a room's door and times who goes through."""

    def __init__(self, room: Any, samples: list[int]) -> None:
        self._room = room
        self._samples = samples

    def __getattr__(self, name: str) -> Any:
        inner = getattr(self._room, name)
        if name not in TIMED:
            return inner
        samples = self._samples

        def timed(*arguments: Any) -> Any:
            begun = time.perf_counter_ns()
            result = inner(*arguments)
            samples.append(time.perf_counter_ns() - begun)
            return result

        setattr(self, name, timed)
        return timed
