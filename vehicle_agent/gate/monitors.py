"""The gate's own monitors: stuck steering, excess speed, an obstacle ahead of the bumper.

They use nothing of the tick. The module's reports and the perception worker's percepts reach the gate
directly, in the base frame. An error in planning, localization or the guard does not affect them.
"""

import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from contract.geometry import Array, IntArray
from vehicle_agent.can.braking import CommandedActuation
from vehicle_agent.gate.footprint import are_apart, is_met_on_arc
from vehicle_agent.gate.settings import GateSettings
from vehicle_agent.signals import PEDESTRIAN, ObstaclePercept, Percept, TrackPercept, VehicleMotion

# A cell this near to a point of a track belongs to that track.
_OWN_M = 0.7
# Middle, corners and middles of the sides of an outline, in halves of its length and width.
_OUTLINE = np.array([[i, j] for i in (-1.0, 0.0, 1.0) for j in (-1.0, 0.0, 1.0)])


class SteeringMonitor:
    """Detects a wheel that does not follow its command; judged at each report while by-wire steers."""

    def __init__(self, settings: GateSettings) -> None:
        self._settings = settings
        self._sent: deque[tuple[int, float]] = deque()
        self._slow_rad: float | None = None
        self._reported_ns = 0
        self._deviations = 0

    def record_sent(self, now_ns: int, commanded: CommandedActuation) -> None:
        """Notes the command that goes to the module now; without enable it does not count."""
        if not commanded.enable:
            self._sent.clear()
            return
        settings = self._settings
        since_s = (now_ns - self._sent[-1][0]) * 1e-9 if self._sent else 0.0
        self._sent.append((now_ns, commanded.steer_rad))
        self._follow_slowly(since_s, now_ns - round(1e9 * settings.steer_delay_s))
        oldest_ns = now_ns - round(2e9 * (settings.steer_delay_s + settings.stuck_slack_s))
        while self._sent[0][0] < oldest_ns:
            self._sent.popleft()

    def _follow_slowly(self, since_s: float, then_ns: int) -> None:
        """Moves a reference wheel that turns at the slowest healthy rate to the angle commanded by then."""
        wanted = [angle for stamp_ns, angle in self._sent if stamp_ns <= then_ns]
        if not wanted:
            return
        if self._slow_rad is None:
            self._slow_rad = wanted[-1]
        reach = self._settings.slow_share * self._settings.steer_rate_radps_max * since_s
        self._slow_rad += min(max(wanted[-1] - self._slow_rad, -reach), reach)

    def is_stuck(self, motion: VehicleMotion) -> bool:
        """True when the last `confirmed` reports, this one included, lie off what was commanded."""
        if not motion.enabled:
            self._sent.clear()
            self._slow_rad = motion.steer_rad
        if motion.stamp_ns != self._reported_ns:
            self._reported_ns = motion.stamp_ns
            self._deviations = (
                self._deviations + 1 if self._deviates(motion.steer_rad, motion.stamp_ns) else 0
            )
        return self._deviations >= self._settings.confirmed

    def _deviates(self, steer_rad: float, report_ns: int) -> bool:
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
    """Detects reported speeds above anything that the vehicle may drive."""

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
    """Detects an obstacle ahead of the bumper that at most full braking still avoids.

    A track is extrapolated, and counts only if it is still in the way when the bumper arrives: a person who
    leaves the way in time causes no stop. A cell near a track belongs to the track.
    """

    def __init__(self, settings: GateSettings) -> None:
        self._settings = settings
        self._latest: dict[type, _Observation] = {}
        self._met = 0

    def take_percept(self, percept: Percept) -> None:
        """Keeps the newest percept of each kind; drops older ones, and values that are not finite."""
        known = self._latest.get(type(percept))
        if known is None or percept.stamp_ns >= known.stamp_ns:
            self._latest[type(percept)] = _observation(percept)

    def is_close(self, motion: VehicleMotion, commanded: CommandedActuation, now_ns: int) -> bool:
        """True once an obstacle was close for more than `confirmed` calls in a row without a braking command.

        There is a call every 20 ms.
        """
        settings = self._settings
        speed_mps = motion.speed_mps
        unbraked = commanded.enable and speed_mps > settings.standing_mps
        unbraked = unbraked and commanded.brake_ratio < settings.braked_ratio
        met = unbraked and any(
            self._is_met(observation, motion, commanded, now_ns) for observation in self._fresh(now_ns)
        )
        self._met = self._met + 1 if met else 0
        return self._met > settings.confirmed

    def _fresh(self, now_ns: int) -> list["_Observation"]:
        """Observations that are not too old; the cells without those of a track."""
        fresh = [
            observation
            for observation in self._latest.values()
            if now_ns - observation.stamp_ns <= self._settings.percept_ns
        ]
        tracks = [observation for observation in fresh if observation.tracked and len(observation.points)]
        if not tracks:
            return [observation for observation in fresh if len(observation.points)]
        left = [
            observation if observation.tracked else _apart_from(observation, tracks[0])
            for observation in fresh
        ]
        return [observation for observation in left if len(observation.points)]

    def _is_met(
        self, observation: "_Observation", motion: VehicleMotion, commanded: CommandedActuation, now_ns: int
    ) -> bool:
        settings = self._settings
        age_s = max(0, now_ns - observation.stamp_ns) * 1e-9
        way_m = motion.speed_mps * age_s
        driven = math.tan(motion.steer_rad) / settings.wheelbase_m
        places = _after(observation.points + age_s * observation.velocities, way_m, driven)
        velocities = _turned(observation.velocities, driven * way_m)
        return any(
            is_met_on_arc(
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
            for curvature in (driven, math.tan(commanded.steer_rad) / settings.wheelbase_m)
        )


@dataclass(frozen=True, slots=True)
class _Observation:
    """points (n, 2) and their velocities over ground (n, 2), base frame at the stamp."""

    stamp_ns: int
    points: Array
    velocities: Array
    tracked: bool


def _observation(percept: Percept) -> _Observation:
    if isinstance(percept, ObstaclePercept):
        cells = percept.cells_base[np.isfinite(percept.cells_base).all(axis=1)]
        return _Observation(percept.stamp_ns, cells, np.zeros_like(cells), False)
    points, rows = _points(percept)
    return _Observation(percept.stamp_ns, points, percept.velocities_base_mps[rows], True)


def _apart_from(cells: _Observation, tracks: _Observation) -> _Observation:
    """The cells farther than _OWN_M from every point of a track, at the cells' stamp."""
    late_s = (cells.stamp_ns - tracks.stamp_ns) * 1e-9
    places = tracks.points + late_s * tracks.velocities
    kept = are_apart(cells.points, places, _OWN_M)
    return _Observation(cells.stamp_ns, cells.points[kept], cells.velocities[kept], False)


def _points(percept: TrackPercept) -> tuple[Array, IntArray]:
    """((n, 2) corners and middles of the tracks' outlines, base frame; (n,) row of the track of each)."""
    table = np.column_stack((percept.poses_base, percept.velocities_base_mps, percept.sizes_m))
    rows = np.flatnonzero(np.isfinite(table).all(axis=1))
    poses, half_m = table[rows, :3], 0.5 * table[rows, 5:7]
    is_person = percept.kinds[rows] == PEDESTRIAN
    half_m[is_person, 1] = half_m[is_person, 0]
    along, aside = (half_m[:, None, k] * _OUTLINE[None, :, k] for k in (0, 1))
    cos, sin = np.cos(poses[:, 2, None]), np.sin(poses[:, 2, None])
    places = np.stack(
        (poses[:, 0, None] + cos * along - sin * aside, poses[:, 1, None] + sin * along + cos * aside), axis=2
    )
    # A disc has no corners.
    kept = ~is_person[:, None] | (np.abs(_OUTLINE).sum(axis=1) < 1.5)[None, :]
    return places[kept], np.repeat(rows, len(_OUTLINE))[kept.ravel()]


def _after(points: Array, way_m: float, curvature_1pm: float) -> Array:
    """Points of the present base frame, in the base frame after way_m along an arc."""
    yaw = curvature_1pm * way_m
    return _turned(points - np.array([way_m * math.cos(0.5 * yaw), way_m * math.sin(0.5 * yaw)]), yaw)


def _turned(vectors: Array, yaw_rad: float) -> Array:
    """Vectors (n, 2) in a frame that is turned by yaw_rad."""
    cos, sin = math.cos(yaw_rad), math.sin(yaw_rad)
    return np.ascontiguousarray(vectors @ np.array([[cos, -sin], [sin, cos]]))
