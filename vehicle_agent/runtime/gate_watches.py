"""What the gate sees for itself: stuck steering, too high a speed, something before the bumper.

None of it comes from the tick: the module's reports and the perception worker's answers reach the gate
directly, in the base frame, so that neither a plan nor a position nor the guard can be wrong about it.
"""

import math
from collections import deque

import numpy as np

from contract.geometry import Array
from vehicle_agent.can.braking import Commanded
from vehicle_agent.runtime.gate_footprint import distance_on_arc
from vehicle_agent.runtime.gate_settings import GateSettings
from vehicle_agent.signals import PEDESTRIAN, ObstaclePercept, Percept, VehicleMotion


class SteeringWatch:
    """Does the wheel follow? Judged at each report, once by-wire has had the steering for a while."""

    def __init__(self, settings: GateSettings) -> None:
        self._settings = settings
        self._sent: deque[tuple[int, float]] = deque()
        self._slow_rad: float | None = None
        self._reported_ns = 0
        self._astray = 0

    def sent(self, now_ns: int, asked: Commanded) -> None:
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


class SpeedWatch:
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


class FootprintWatch:
    """Is something before the bumper that only full braking, if that, still misses?"""

    def __init__(self, settings: GateSettings) -> None:
        self._settings = settings
        self._points: dict[type, tuple[int, Array]] = {}
        self._met = 0

    def see(self, percept: Percept) -> None:
        """The newest answer of each kind counts; an older one is dropped."""
        known = self._points.get(type(percept))
        if known is None or percept.stamp_ns >= known[0]:
            self._points[type(percept)] = (percept.stamp_ns, _points(percept))

    def is_close(self, motion: VehicleMotion, asked: Commanded, now_ns: int) -> bool:
        """Called each 20 ms; True once it has been so for `confirmed` times and a set does not brake."""
        settings = self._settings
        speed_mps = motion.speed_mps
        look_m = speed_mps * settings.delay_s + speed_mps**2 / (2.0 * settings.brake_mps2) + settings.margin_m
        unbraked = asked.enable and speed_mps > settings.standing_mps
        unbraked = unbraked and asked.brake_ratio < settings.braked_ratio
        met = unbraked and any(
            self._is_met(points, stamp_ns, motion, asked, look_m, now_ns)
            for stamp_ns, points in self._points.values()
            if now_ns - stamp_ns <= settings.percept_ns and len(points)
        )
        self._met = self._met + 1 if met else 0
        return self._met > settings.confirmed

    def _is_met(
        self,
        points: Array,
        stamp_ns: int,
        motion: VehicleMotion,
        asked: Commanded,
        look_m: float,
        now_ns: int,
    ) -> bool:
        settings = self._settings
        way_m = motion.speed_mps * max(0, now_ns - stamp_ns) * 1e-9
        near = np.abs(points).max(axis=1) <= settings.front_m + look_m + way_m + 2.0
        driven = math.tan(motion.steer_rad) / settings.wheelbase_m
        moved = _after(points[near], way_m, driven)
        return any(
            distance_on_arc(moved, curvature, settings.front_m, settings.half_width_m, look_m) <= look_m
            for curvature in (driven, math.tan(asked.steer_rad) / settings.wheelbase_m)
        )


def _points(percept: Percept) -> Array:
    """(n, 2) places in the base frame; of a track the corners and middles of its outline."""
    if isinstance(percept, ObstaclePercept):
        return percept.cells_base
    places = [np.empty((0, 2))]
    for kind, pose, size in zip(percept.kinds, percept.poses_base, percept.sizes_m, strict=True):
        x, y, yaw = pose
        half = 0.5 * size if kind != PEDESTRIAN else np.full(2, 0.5 * size[0])
        corners = np.array([[i, j] for i in (-1.0, 0.0, 1.0) for j in (-1.0, 0.0, 1.0)]) * half
        if kind == PEDESTRIAN:
            # A disc has no corners.
            corners = corners[np.abs(corners).sum(axis=1) <= half[0] + 1e-9]
        cos, sin = math.cos(yaw), math.sin(yaw)
        places.append(corners @ np.array([[cos, sin], [-sin, cos]]) + np.array([x, y]))
    return np.vstack(places)


def _after(points: Array, way_m: float, curvature_1pm: float) -> Array:
    """Places of the base frame, in the base frame after way_m along an arc."""
    yaw = curvature_1pm * way_m
    moved = points - np.array([way_m * math.cos(0.5 * yaw), way_m * math.sin(0.5 * yaw)])
    cos, sin = math.cos(yaw), math.sin(yaw)
    turned: Array = moved @ np.array([[cos, -sin], [sin, cos]])
    return np.ascontiguousarray(turned)
