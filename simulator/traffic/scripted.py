"""Scripted people and vehicles of a scenario: they wait for their cue, follow their path and stop."""

import math
from dataclasses import dataclass

import numpy as np

from contract.geometry import Array
from simulator.traffic.actors import Actors, Bodies, no_bodies, together
from simulator.traffic.crowd import V_FRONT, V_X, V_Y, V_YAW

# The offset between the numbers of two groups.
_NUMBERS_APART = 100_000


@dataclass(frozen=True, slots=True)
class ScriptedRole:
    """One actor's script. pose_map: at the beginning; way (n, 2): its path from there.

    accel_mps2     up to speed_mps from the cue on, and down to 0 at the end of the path
    from_s         the earliest time of the cue; None: any time
    distance_m     the cue needs a shuttle's bumper within this distance; None: any distance
    after_s        from the cue to the first step
    stays          the actor stands at the end of its path; otherwise it disappears
    halt_at        number of a place of the path where the actor stops dead, for halt_s; None: nowhere
    """

    kind: int
    pose_map: tuple[float, float, float]
    size_m: tuple[float, float]
    way: Array
    speed_mps: float
    accel_mps2: float = 3.0
    from_s: float | None = None
    distance_m: float | None = None
    after_s: float = 0.0
    stays: bool = True
    halt_at: int | None = None
    halt_s: float = 0.0


class ScriptedTraffic:
    """Plays the roles; `hold` stops the clock and hides all actors. They react to shuttles only by cues."""

    def __init__(self, roles: tuple[ScriptedRole, ...]) -> None:
        self.hold = False
        self.clock_s = 0.0
        self._actors = [_ScriptedActor(role) for role in roles]

    def step(self, vehicles: Array, odometers_m: Array, ahead: Array, dt_s: float) -> None:
        """Vehicles (m, 7) as in `traffic.crowd`."""
        if self.hold:
            return
        self.clock_s += dt_s
        for actor in self._actors:
            actor.step(self.clock_s, vehicles, dt_s)

    def bodies(self) -> Bodies:
        """The present actors, numbered from 1 in the order of the roles."""
        there = [(k, p) for k, p in enumerate(self._actors, start=1) if not p.gone]
        if self.hold or not there:
            return no_bodies()
        return Bodies(
            np.array([k for k, _ in there], dtype=np.int64),
            np.array([p.role.kind for _, p in there], dtype=np.int64),
            np.array([p.pose for _, p in there]),
            np.array([p.velocity for _, p in there]),
            np.array([p.role.size_m for _, p in there]),
        )


class _ScriptedActor:
    def __init__(self, role: ScriptedRole) -> None:
        self.role = role
        self.pose = role.pose_map
        self.velocity = (0.0, 0.0)
        self.gone = False
        self._speed_mps = 0.0
        self._cue_s: float | None = None
        self._next = 0
        self._halted_s = 0.0

    def step(self, clock_s: float, vehicles: Array, dt_s: float) -> None:
        role = self.role
        if self._cue_s is None and is_cued(*self.pose[:2], role.from_s, role.distance_m, clock_s, vehicles):
            self._cue_s = clock_s
        if self._cue_s is None or clock_s - self._cue_s < role.after_s or self._next >= len(role.way):
            self.velocity = (0.0, 0.0)
            return
        if self._is_halted():
            self._halted_s += dt_s
            self._speed_mps, self.velocity = 0.0, (0.0, 0.0)
            return
        left_m = self._left_m()
        # An actor that stays brakes to a stop at the end of its path; others do not.
        stop_mps = math.sqrt(2.0 * role.accel_mps2 * left_m) if role.stays else role.speed_mps
        wanted_mps = min(role.speed_mps, self._speed_mps + role.accel_mps2 * dt_s, stop_mps)
        self._speed_mps = max(wanted_mps, 0.05)
        self._walk(self._speed_mps * dt_s, dt_s)
        if self._next >= len(role.way):
            self.gone = not role.stays
            self._speed_mps = 0.0

    def _walk(self, step_m: float, dt_s: float) -> None:
        x0, y0, yaw = self.pose
        x, y = x0, y0
        while step_m > 0.0 and self._next < len(self.role.way) and not self._is_halted():
            to_x, to_y = self.role.way[self._next]
            distance_m = math.hypot(to_x - x, to_y - y)
            if distance_m > 1e-9:
                yaw = math.atan2(to_y - y, to_x - x)
            if distance_m > step_m:
                x, y = x + step_m * math.cos(yaw), y + step_m * math.sin(yaw)
                break
            x, y, step_m = float(to_x), float(to_y), step_m - distance_m
            self._next += 1
        self.pose = (x, y, yaw)
        self.velocity = ((x - x0) / dt_s, (y - y0) / dt_s)

    def _is_halted(self) -> bool:
        """The actor has come to the place where it stops dead, and has not stood there long enough."""
        role = self.role
        return role.halt_at is not None and self._next == role.halt_at + 1 and self._halted_s < role.halt_s

    def _left_m(self) -> float:
        rest = np.vstack((np.array([self.pose[:2]]), self.role.way[self._next :]))
        return float(np.hypot(*np.diff(rest, axis=0).T).sum())


def is_cued(
    x_m: float,
    y_m: float,
    from_s: float | None,
    distance_m: float | None,
    clock_s: float,
    vehicles: Array,
) -> bool:
    """Whether somebody at this place starts now; from_s, distance_m as in `ScriptedRole`."""
    if from_s is not None and clock_s < from_s:
        return False
    if distance_m is None:
        return True
    bumpers_x = vehicles[:, V_X] + vehicles[:, V_FRONT] * np.cos(vehicles[:, V_YAW])
    bumpers_y = vehicles[:, V_Y] + vehicles[:, V_FRONT] * np.sin(vehicles[:, V_YAW])
    return bool((np.hypot(bumpers_x - x_m, bumpers_y - y_m) <= distance_m).any())


class ActorGroups:
    """Several groups of actors as one."""

    def __init__(self, groups: tuple[Actors, ...]) -> None:
        self._groups = groups
        self._hold = False

    @property
    def hold(self) -> bool:
        return self._hold

    @hold.setter
    def hold(self, value: bool) -> None:
        self._hold = value
        for group in self._groups:
            if hasattr(group, "hold"):
                group.hold = value

    def step(self, vehicles: Array, odometers_m: Array, ahead: Array, dt_s: float) -> None:
        for group in self._groups:
            group.step(vehicles, odometers_m, ahead, dt_s)

    def bodies(self) -> Bodies:
        """Numbers of the k-th group are k * 100,000 higher."""
        found = [group.bodies() for group in self._groups]
        apart = [
            Bodies(
                one.numbers + k * _NUMBERS_APART,
                one.kinds,
                one.poses_map,
                one.velocities_map_mps,
                one.sizes_m,
            )
            for k, one in enumerate(found)
        ]
        return together(*apart) if apart else no_bodies()
