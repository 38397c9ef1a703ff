"""People who keep to places about the shuttle: who follow it for fun, run at it, or overtake it."""

import math
from dataclasses import dataclass

import numpy as np

from contract.geometry import Array
from simulator.traffic.actors import Bodies, no_bodies
from simulator.traffic.crowd import RADIUS_M, V_SPEED, V_X, V_Y, V_YAW, clearance_m, slide
from simulator.traffic.scripted import is_cued
from vehicle_agent.signals import PEDESTRIAN

# Who wants to be at a place is there after about this time.
_CLOSE_IN_S = 0.7
_ACCEL_MPS2 = 3.0
_THERE_M = 0.5
# The shuttle's body is touched, never entered.
_TOUCH_M = RADIUS_M - 0.05
_WALKS_OFF_MPS, _WALKS_OFF_M = 1.2, 8.0


@dataclass(frozen=True, slots=True)
class FollowerRole:
    """at: where the person stands until the cue. places_base: wanted from then on, in the shuttle's frame.

    speed_mps    at most
    from_s, distance_m, after_s  as in `ScriptedRole`
    each_s       at each of the places before going on to the next one; at the last one to the end
    for_s        from then on; then the person walks off to the side
    """

    at: tuple[float, float]
    places_base: tuple[tuple[float, float], ...]
    speed_mps: float
    from_s: float | None = None
    distance_m: float | None = None
    after_s: float = 0.0
    for_s: float = 60.0
    each_s: float = 5.0
    kind: int = PEDESTRIAN
    size_m: tuple[float, float] = (2.0 * RADIUS_M, 2.0 * RADIUS_M)


class Followers:
    """They keep to the first vehicle; `hold` stops their clock and hides them."""

    def __init__(self, roles: tuple[FollowerRole, ...]) -> None:
        self.hold = False
        self._clock_s = 0.0
        self._people = [_Follower(role) for role in roles]

    def step(self, vehicles: Array, odometers_m: Array, ahead: Array, dt_s: float) -> None:
        """Vehicles (m, 7) as in `traffic.crowd`."""
        if self.hold:
            return
        self._clock_s += dt_s
        for person in self._people:
            person.step(self._clock_s, vehicles, dt_s)

    def bodies(self) -> Bodies:
        """All of them, numbered from 1 in the order of the roles."""
        if self.hold or not self._people:
            return no_bodies()
        n = len(self._people)
        return Bodies(
            np.arange(1, n + 1),
            np.array([p.role.kind for p in self._people], dtype=np.int64),
            np.array([(p.x, p.y, p.heading) for p in self._people]),
            np.array([(p.vx, p.vy) for p in self._people]),
            np.array([p.role.size_m for p in self._people]),
        )


class _Follower:
    def __init__(self, role: FollowerRole) -> None:
        self.role = role
        self.x, self.y = role.at
        self.vx = self.vy = self.heading = 0.0
        self._cue_s: float | None = None
        self._place, self._there_s, self._is_there = 0, 0.0, False
        self._off: tuple[float, float] | None = None

    def step(self, clock_s: float, vehicles: Array, dt_s: float) -> None:
        role, vehicle = self.role, vehicles[0]
        if self._cue_s is None:
            if not is_cued(self.x, self.y, role.from_s, role.distance_m, clock_s, vehicles):
                return
            self._cue_s = clock_s + role.after_s
        if clock_s < self._cue_s:
            return
        if clock_s - self._cue_s < role.for_s:
            wanted = self._towards(role.places_base[self._place], vehicle)
            self._there_s += dt_s if self._is_there else 0.0
            if self._there_s >= role.each_s and self._place < len(role.places_base) - 1:
                self._place, self._there_s = self._place + 1, 0.0
        else:
            wanted = self._walking_off(vehicle)
        change_x, change_y = wanted[0] - self.vx, wanted[1] - self.vy
        size = math.hypot(change_x, change_y)
        share = min(1.0, _ACCEL_MPS2 * dt_s / size) if size > 1e-9 else 0.0
        self._walk(self.vx + share * change_x, self.vy + share * change_y, vehicles, dt_s)

    def _towards(self, place_base: tuple[float, float], vehicle: Array) -> tuple[float, float]:
        """The velocity that closes in on the wanted place, which moves with the vehicle."""
        cos, sin = math.cos(vehicle[V_YAW]), math.sin(vehicle[V_YAW])
        ahead_m, left_m = place_base
        x = vehicle[V_X] + ahead_m * cos - left_m * sin
        y = vehicle[V_Y] + ahead_m * sin + left_m * cos
        self._is_there = math.hypot(x - self.x, y - self.y) < _THERE_M
        vx = vehicle[V_SPEED] * cos + (x - self.x) / _CLOSE_IN_S
        vy = vehicle[V_SPEED] * sin + (y - self.y) / _CLOSE_IN_S
        pace = math.hypot(vx, vy)
        share = min(1.0, self.role.speed_mps / pace) if pace > 1e-9 else 0.0
        return share * vx, share * vy

    def _walking_off(self, vehicle: Array) -> tuple[float, float]:
        """To the side of the vehicle that is nearer."""
        if self._off is None:
            cos, sin = math.cos(vehicle[V_YAW]), math.sin(vehicle[V_YAW])
            left_m = cos * (self.y - vehicle[V_Y]) - sin * (self.x - vehicle[V_X])
            side = 1.0 if left_m >= 0.0 else -1.0
            self._off = (self.x - side * _WALKS_OFF_M * sin, self.y + side * _WALKS_OFF_M * cos)
        dx, dy = self._off[0] - self.x, self._off[1] - self.y
        distance = math.hypot(dx, dy)
        if distance < 0.2:
            return 0.0, 0.0
        return _WALKS_OFF_MPS * dx / distance, _WALKS_OFF_MPS * dy / distance

    def _walk(self, vx: float, vy: float, vehicles: Array, dt_s: float) -> None:
        x, y = self.x + vx * dt_s, self.y + vy * dt_s
        for vehicle in vehicles:
            after = clearance_m(vehicle, x, y)
            if after < _TOUCH_M and after < clearance_m(vehicle, self.x, self.y):
                x, y = slide(vehicle, self.x, self.y, x, y)
        self.vx, self.vy = (x - self.x) / dt_s, (y - self.y) / dt_s
        self.x, self.y = x, y
        if math.hypot(self.vx, self.vy) > 0.3:
            self.heading = math.atan2(self.vy, self.vx)
