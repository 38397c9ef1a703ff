"""The times of onboard rooms over a whole drive in virtual time."""

from vehicle_agent.onboard.car import Car
from vehicle_agent.runtime.room_times import ROOMS, timed


class RoomTimes:
    """Wall time of every call, in ns, by room; `whole`: the complete tick with its recording.

    Virtual time runs in this thread alone.
    """

    def __init__(self) -> None:
        self.by_room: dict[str, list[int]] = {room: [] for room in ROOMS}
        self.whole: list[int] = []

    def timed(self, car: Car) -> Car:
        """The same car with every room timed."""
        return timed(car, lambda room, spent_ns: self.by_room[room].append(spent_ns))
