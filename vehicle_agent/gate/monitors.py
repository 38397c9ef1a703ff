"""What the gate sees for itself: stuck steering, too high a speed, something before the bumper.

None of it comes from the tick: the module's reports and the perception worker's answers reach the gate
directly, in the base frame, so that neither a plan nor a position nor the guard can be wrong about it.
"""

import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from contract.geometry import Array, IntArray
from vehicle_agent.can.braking import CommandedActuation
from vehicle_agent.gate.footprint import met_on_arc
from vehicle_agent.gate.settings import GateSettings
from vehicle_agent.signals import PEDESTRIAN, ObstaclePercept, Percept, TrackPercept, VehicleMotion

# A cell this near to a place of a track belongs to it.
_OWN_M = 0.7


class SteeringMonitor:
    """Does the wheel follow? Judged at each report, once by-wire has had the steering for a while."""

    def __init__(self, settings: GateSettings) -> None:
        self._settings = settings
        self._sent: deque[tuple[int, float]] = deque()
        self._slow_rad: float | None = None
        self._reported_ns = 0
        self._astray = 0

    def sent(self, now_ns: int, asked: CommandedActuation) -> None:
        """What goes to the module now; angles that it does not steer by do not count."""
        if not asked.enable:
            self._sent.clear()
            return
        settings = self._settings
        since_s = (now_ns - self._sent[-1][0]) * 1e-9 if self._sent else 0.0
        self._sent.append((now_ns, asked.steer_rad))
        self._follow_slowly(since_s, now_ns - round(1e9 * settings.steer_delay_s))
        oldest_ns = now_ns - round(2e9 * (settings.steer_delay_s + settings.stuck_slack_s))
        while self._sent[0][0] < oldest_ns:
            self._sent.popleft()

    def _follow_slowly(self, since_s: float, then_ns: int) -> None:
        """A sound wheel that turns at the least rate that is still sound, after what was sent by then."""
        wanted = [angle for stamp_ns, angle in self._sent if stamp_ns <= then_ns]
        if not wanted:
            return
        if self._slow_rad is None:
            self._slow_rad = wanted[-1]
        reach = self._settings.slow_share * self._settings.steer_rate_radps_max * since_s
        self._slow_rad += min(max(wanted[-1] - self._slow_rad, -reach), reach)

    def is_stuck(self, motion: VehicleMotion) -> bool:
        """So many reports in a row, this one included, that lie off what was commanded."""
        if not motion.enabled:
            self._sent.clear()
            self._slow_rad = motion.steer_rad
        if motion.stamp_ns != self._reported_ns:
            self._reported_ns = motion.stamp_ns
            self._astray = self._astray + 1 if self._is_astray(motion.steer_rad, motion.stamp_ns) else 0
        return self._astray >= self._settings.confirmed

    def _is_astray(self, steer_rad: float, report_ns: int) -> bool:
        settings = self._settings
        first_ns = report_ns - round(1e9 * (settings.steer_delay_s + settings.stuck_slack_s))
        last_ns = report_ns - round(1e9 * (settings.steer_delay_s - settings.stuck_slack_s))
        if not self._sent or self._sent[0][0] > first_ns:
            return False
        angles = [angle for stamp_ns, angle in self._sent if first_ns <= stamp_ns <= last_ns]
        if not angles:
            return False
        if self._slow_rad is not None:
            angles.append(self._slow_rad)
        low, high = min(angles) - settings.stuck_rad, max(angles) + settings.stuck_rad
        return not low <= steer_rad <= high


class SpeedMonitor:
    """Faster than the vehicle may ever be, by its reports."""

    def __init__(self, settings: GateSettings) -> None:
        self._limit_mps = (1.0 + settings.over_share) * settings.speed_mps_max + settings.over_mps
        self._confirmed = settings.confirmed
        self._reported_ns = 0
        self._over = 0

    def is_over(self, motion: VehicleMotion) -> bool:
        if motion.stamp_ns != self._reported_ns:
            self._reported_ns = motion.stamp_ns
            self._over = self._over + 1 if motion.enabled and motion.speed_mps > self._limit_mps else 0
        return self._over >= self._confirmed


class FootprintMonitor:
    """Is something before the bumper that only full braking, if that, still misses?

    Who moves is carried along, and must still be there when the bumper comes: whoever leaves the way before
    is no reason to stop for good. A cell beside somebody who is tracked is theirs.
    """

    def __init__(self, settings: GateSettings) -> None:
        self._settings = settings
        self._seen: dict[type, _Seen] = {}
        self._met = 0

    def see(self, percept: Percept) -> None:
        """The newest answer of each kind counts, an older one is dropped; so is what is not a number, for a
        worker gone wrong must not take the gate along."""
        known = self._seen.get(type(percept))
        if known is None or percept.stamp_ns >= known.stamp_ns:
            self._seen[type(percept)] = _seen(percept)

    def is_close(self, motion: VehicleMotion, asked: CommandedActuation, now_ns: int) -> bool:
        """Called each 20 ms; True once it has been so for `confirmed` times and a set does not brake."""
        settings = self._settings
        speed_mps = motion.speed_mps
        unbraked = asked.enable and speed_mps > settings.standing_mps
        unbraked = unbraked and asked.brake_ratio < settings.braked_ratio
        met = unbraked and any(self._is_met(seen, motion, asked, now_ns) for seen in self._fresh(now_ns))
        self._met = self._met + 1 if met else 0
        return self._met > settings.confirmed

    def _fresh(self, now_ns: int) -> list["_Seen"]:
        """What is not too old, cells without those of a track."""
        fresh = [seen for seen in self._seen.values() if now_ns - seen.stamp_ns <= self._settings.percept_ns]
        tracks = [seen for seen in fresh if seen.tracked and len(seen.points)]
        if not tracks:
            return [seen for seen in fresh if len(seen.points)]
        left = [seen if seen.tracked else _apart_from(seen, tracks[0]) for seen in fresh]
        return [seen for seen in left if len(seen.points)]

    def _is_met(self, seen: "_Seen", motion: VehicleMotion, asked: CommandedActuation, now_ns: int) -> bool:
        settings = self._settings
        age_s = max(0, now_ns - seen.stamp_ns) * 1e-9
        way_m = motion.speed_mps * age_s
        driven = math.tan(motion.steer_rad) / settings.wheelbase_m
        places = _after(seen.points + age_s * seen.velocities, way_m, driven)
        velocities = _turned(seen.velocities, driven * way_m)
        return any(
            met_on_arc(
                places,
                velocities,
                curvature,
                motion.speed_mps,
                settings.delay_s,
                settings.brake_mps2,
                settings.margin_m,
                settings.front_m,
                settings.half_width_m,
            )
            for curvature in (driven, math.tan(asked.steer_rad) / settings.wheelbase_m)
        )


@dataclass(frozen=True, slots=True)
class _Seen:
    """points (n, 2) and their velocities over ground (n, 2), base frame at the stamp."""

    stamp_ns: int
    points: Array
    velocities: Array
    tracked: bool


def _seen(percept: Percept) -> _Seen:
    if isinstance(percept, ObstaclePercept):
        cells = percept.cells_base[np.isfinite(percept.cells_base).all(axis=1)]
        return _Seen(percept.stamp_ns, cells, np.zeros_like(cells), False)
    points, owners = _points(percept)
    return _Seen(percept.stamp_ns, points, percept.velocities_base_mps[owners], True)


def _apart_from(cells: _Seen, tracks: _Seen) -> _Seen:
    """The cells that lie farther than _OWN_M from every place of a track at the cells' moment."""
    late_s = (cells.stamp_ns - tracks.stamp_ns) * 1e-9
    places = tracks.points + late_s * tracks.velocities
    apart2 = ((cells.points[:, None, :] - places[None, :, :]) ** 2).sum(axis=2)
    kept = apart2.min(axis=1) > _OWN_M**2
    return _Seen(cells.stamp_ns, cells.points[kept], cells.velocities[kept], False)


def _points(percept: TrackPercept) -> tuple[Array, IntArray]:
    """((n, 2) corners and middles of the tracks' outlines, base frame, (n,) whose they are)."""
    places, owners = [np.empty((0, 2))], [np.empty(0, np.int64)]
    told = np.column_stack((percept.poses_base, percept.velocities_base_mps, percept.sizes_m))
    for number in np.flatnonzero(np.isfinite(told).all(axis=1)):
        kind, (x, y, yaw), size = percept.kinds[number], told[number, :3], told[number, 5:]
        half = 0.5 * size if kind != PEDESTRIAN else np.full(2, 0.5 * size[0])
        corners = np.array([[i, j] for i in (-1.0, 0.0, 1.0) for j in (-1.0, 0.0, 1.0)]) * half
        if kind == PEDESTRIAN:
            # A disc has no corners.
            corners = corners[np.abs(corners).sum(axis=1) <= half[0] + 1e-9]
        cos, sin = math.cos(yaw), math.sin(yaw)
        places.append(corners @ np.array([[cos, sin], [-sin, cos]]) + np.array([x, y]))
        owners.append(np.full(len(corners), number, np.int64))
    return np.vstack(places), np.concatenate(owners)


def _after(points: Array, way_m: float, curvature_1pm: float) -> Array:
    """Places of the base frame, in the base frame after way_m along an arc."""
    yaw = curvature_1pm * way_m
    return _turned(points - np.array([way_m * math.cos(0.5 * yaw), way_m * math.sin(0.5 * yaw)]), yaw)


def _turned(vectors: Array, yaw_rad: float) -> Array:
    """(n, 2) of one frame, in a frame that is turned by yaw_rad from it."""
    cos, sin = math.cos(yaw_rad), math.sin(yaw_rad)
    return np.ascontiguousarray(vectors @ np.array([[cos, -sin], [sin, cos]]))
