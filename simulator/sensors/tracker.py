"""The output of a lidar and camera tracker, from ground truth with latency, noise, misses and occlusion."""

import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from contract.geometry import Array, Pose2
from contract.roads.walls import edges_near
from simulator.sensors.line_of_sight import visible
from simulator.traffic.actors import Bodies
from vehicle_agent.signals import TrackPercept


@dataclass(frozen=True, slots=True)
class TrackerNoise:
    """Standard deviations in the vehicle's frame, and the tracker's misses.

    wander_s     correlation time of the errors of positions and velocities
    latency_ns   from the scan to the output; dropout_ratio: of scans in which a visible object is missed
    range_m_max  objects farther away are not detected
    """

    position_std_m: float = 0.07
    velocity_std_mps: float = 0.12
    heading_std_rad: float = 0.05
    wander_s: float = 0.4
    dropout_ratio: float = 0.03
    latency_ns: int = 80_000_000
    rate_hz: float = 10.0
    range_m_max: float = 45.0


class Tracker:
    """One vehicle's tracker. `silent` stops it."""

    def __init__(
        self, noise: TrackerNoise, edges: Array, sensor_x_m: float, rng: np.random.Generator
    ) -> None:
        """edges (n, 4): walls, map frame; sensor_x_m: the sensor's position ahead of the rear axle."""
        self._noise, self._edges, self._sensor_x_m, self._rng = noise, edges, sensor_x_m, rng
        self._due_ns: int | None = None
        self._answers: deque[tuple[int, TrackPercept]] = deque()
        self._errors: dict[int, Array] = {}
        self.silent = False

    def percepts(self, now_ns: int, pose_map: Pose2, bodies: Bodies) -> list[TrackPercept]:
        """Scan if one is due, and return the percepts that are due. Call it once a step."""
        period_ns = round(1e9 / self._noise.rate_hz)
        if self._due_ns is None:
            self._due_ns = now_ns
        if now_ns >= self._due_ns:
            self._due_ns += period_ns
            if not self.silent:
                percept = self._scan(now_ns, pose_map, bodies)
                self._answers.append((now_ns + self._noise.latency_ns, percept))
        ready = []
        while self._answers and self._answers[0][0] <= now_ns:
            ready.append(self._answers.popleft()[1])
        return ready

    def _scan(self, now_ns: int, pose_map: Pose2, bodies: Bodies) -> TrackPercept:
        noise = self._noise
        cos, sin = math.cos(pose_map.yaw_rad), math.sin(pose_map.yaw_rad)
        sensor_x = pose_map.x_m + self._sensor_x_m * cos
        sensor_y = pose_map.y_m + self._sensor_x_m * sin
        apart = np.hypot(bodies.poses_map[:, 0] - sensor_x, bodies.poses_map[:, 1] - sensor_y)
        near = np.flatnonzero(apart <= noise.range_m_max)
        seen = visible(
            sensor_x,
            sensor_y,
            bodies.poses_map[near],
            bodies.sizes_m[near],
            bodies.people[near].astype(np.float64),
            edges_near(self._edges, sensor_x, sensor_y, noise.range_m_max),
            bodies.boxes(),
        )
        met = self._rng.random(len(near)) >= noise.dropout_ratio
        chosen = near[(seen > 0.0) & met]
        error = self._error(bodies.numbers[chosen])
        poses, velocities = bodies.poses_map[chosen], bodies.velocities_map_mps[chosen]
        dx, dy = poses[:, 0] - pose_map.x_m, poses[:, 1] - pose_map.y_m
        poses_base = np.column_stack(
            (
                cos * dx + sin * dy + noise.position_std_m * error[:, 0],
                -sin * dx + cos * dy + noise.position_std_m * error[:, 1],
                poses[:, 2] - pose_map.yaw_rad + noise.heading_std_rad * error[:, 2],
            )
        )
        velocities_base = np.column_stack(
            (
                cos * velocities[:, 0] + sin * velocities[:, 1] + noise.velocity_std_mps * error[:, 3],
                -sin * velocities[:, 0] + cos * velocities[:, 1] + noise.velocity_std_mps * error[:, 4],
            )
        )
        return TrackPercept(
            now_ns,
            bodies.numbers[chosen].copy(),
            bodies.kinds[chosen].copy(),
            poses_base,
            velocities_base,
            bodies.sizes_m[chosen].copy(),
        )

    def _error(self, numbers: np.ndarray) -> Array:
        """(n, 5) unit errors of these objects, each a first-order Gauss-Markov process of its own."""
        noise = self._noise
        keep = math.exp(-1.0 / (noise.rate_hz * noise.wander_s)) if noise.wander_s > 0.0 else 0.0
        fresh = math.sqrt(1.0 - keep * keep)
        shocks = self._rng.standard_normal((len(numbers), 5))
        errors: dict[int, Array] = {}
        for number, shock in zip(numbers.tolist(), shocks, strict=True):
            before = self._errors.get(number)
            errors[number] = shock if before is None else keep * before + fresh * shock
        self._errors = errors
        return np.array(list(errors.values())).reshape(-1, 5)
