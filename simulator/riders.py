"""Simulated passengers: they come to the stop, board, sit and alight."""

from dataclasses import dataclass, field
from typing import Literal, Protocol

import numpy as np

from contract.geometry import Pose2
from vehicle_agent.signals import CodeTyped, SeatButton, SeatSensor

STOP_REACH_M = 6.0
_SEAT_REPEAT_NS = 1_000_000_000

BoardingMethod = Literal["code", "tap", "sensor"]


class Phone(Protocol):
    """A rider's phone; the composition implements it."""

    def vehicle_of(self, ride_id: str) -> str:
        """The vehicle that the ride's party boards at the stop, "" for none."""
        ...

    def tap(self, ride_id: str, kind: Literal["board", "alight"]) -> None: ...


class NoPhones:
    """For a world without riders."""

    def vehicle_of(self, ride_id: str) -> str:
        return ""

    def tap(self, ride_id: str, kind: Literal["board", "alight"]) -> None:
        raise AssertionError("there are no riders")


@dataclass(frozen=True, slots=True)
class Rider:
    """One party that has booked. Stops are rear-axle poses, as on the map."""

    ride_id: str
    code: str
    party: int
    how: BoardingMethod
    from_map: Pose2
    to_map: Pose2
    ready_ns: int = 0
    alights: bool = True


@dataclass(slots=True)
class _Trip:
    rider: Rider
    state: Literal["waiting", "boarding", "seated", "alighting", "gone"] = "waiting"
    vehicle_id: str = ""
    due_ns: int = 0


@dataclass(slots=True)
class _Cabin:
    occupied: int = 0
    reported: int = -1
    reported_ns: int = 0
    pressed: list[SeatButton] = field(default_factory=list)


class Riders:
    """All passengers of a world. Boarding takes each party some seconds, drawn from rng."""

    def __init__(self, vehicle_ids: tuple[str, ...], phone: Phone, rng: np.random.Generator) -> None:
        self._phone, self._rng = phone, rng
        self._trips: dict[str, _Trip] = {}
        self._cabins = {vehicle_id: _Cabin() for vehicle_id in vehicle_ids}

    def add(self, rider: Rider) -> None:
        """Raises ValueError if this ride already has a rider."""
        if rider.ride_id in self._trips:
            raise ValueError(f"ride {rider.ride_id} already has a rider")
        self._trips[rider.ride_id] = _Trip(rider)

    def is_gone(self, ride_id: str) -> bool:
        """The party has alighted."""
        return self._trips[ride_id].state == "gone"

    def press_seat_button(self, vehicle_id: str, seat: int, now_ns: int) -> None:
        self._cabins[vehicle_id].pressed.append(SeatButton(now_ns, seat))

    def occupied(self, vehicle_id: str) -> int:
        """The number of occupied seats."""
        return self._cabins[vehicle_id].occupied

    def step(
        self, now_ns: int, vehicle_id: str, pose_map: Pose2, doors_open: bool
    ) -> tuple[CodeTyped | SeatSensor | SeatButton, ...]:
        """The cabin events of one vehicle in this step."""
        items: list[CodeTyped | SeatSensor | SeatButton] = []
        cabin = self._cabins[vehicle_id]
        items.extend(cabin.pressed)
        cabin.pressed = []
        if doors_open:
            for trip in self._trips.values():
                self._move_party(trip, now_ns, vehicle_id, pose_map, items)
        if cabin.occupied != cabin.reported or now_ns - cabin.reported_ns >= _SEAT_REPEAT_NS:
            cabin.reported, cabin.reported_ns = cabin.occupied, now_ns
            items.append(SeatSensor(now_ns, cabin.occupied))
        return tuple(items)

    def _move_party(
        self,
        trip: _Trip,
        now_ns: int,
        vehicle_id: str,
        pose_map: Pose2,
        items: list[CodeTyped | SeatSensor | SeatButton],
    ) -> None:
        rider, cabin = trip.rider, self._cabins[vehicle_id]
        match trip.state:
            case "waiting":
                comes = now_ns >= rider.ready_ns and _near(pose_map, rider.from_map)
                if comes and self._phone.vehicle_of(rider.ride_id) == vehicle_id:
                    trip.state, trip.vehicle_id = "boarding", vehicle_id
                    trip.due_ns = now_ns + self._seconds(2.0, 4.0)
                    if rider.how == "code":
                        items.append(CodeTyped(now_ns, rider.code))
                    elif rider.how == "tap":
                        self._phone.tap(rider.ride_id, "board")
            case "boarding" if trip.vehicle_id == vehicle_id and now_ns >= trip.due_ns:
                trip.state = "seated"
                cabin.occupied += rider.party
            case "seated" if trip.vehicle_id == vehicle_id:
                if rider.alights and _near(pose_map, rider.to_map):
                    trip.state = "alighting"
                    trip.due_ns = now_ns + self._seconds(2.0, 4.0)
            case "alighting" if trip.vehicle_id == vehicle_id and now_ns >= trip.due_ns:
                trip.state = "gone"
                cabin.occupied -= rider.party
                if rider.how == "tap":
                    self._phone.tap(rider.ride_id, "alight")
            case _:
                pass

    def _seconds(self, low: float, high: float) -> int:
        return round(float(self._rng.uniform(low, high)) * 1e9)


def _near(a: Pose2, b: Pose2) -> bool:
    return (a.x_m - b.x_m) ** 2 + (a.y_m - b.y_m) ** 2 <= STOP_REACH_M**2
