"""The time that each onboard room takes, measured from outside, because the rooms have no clock."""

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
    """Wall time of every call, in ns, by room; `whole`: the complete tick with its recording.

    Wall time, because the thread's CPU clock needs a system call, and virtual time runs in this thread alone.
    """

    def __init__(self) -> None:
        self.by_room: dict[str, list[int]] = {room: [] for room in ROOMS}
        self.whole: list[int] = []

    def timed(self, car: Car) -> Car:
        """The same car with every room timed."""
        rooms: dict[str, Any] = {name: _TimedRoom(getattr(car, name), self.by_room[name]) for name in ROOMS}
        return replace(car, **rooms)


class _TimedRoom:
    """A proxy of a room that times its calls."""

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
