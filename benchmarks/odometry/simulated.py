"""A drive around a block that ends where it began, scanned by a turning lidar while the vehicle moves."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from contract.geometry import Array
from contract.roads.model import Building, Lane, Origin, RoadMap
from simulator.sensors.lidars.mounts import in_makers_frame, mount
from simulator.sensors.lidars.spinning_lidar import MountedLidar, SpinningLidar
from simulator.sensors.scene.changes import WorldChanges
from simulator.sensors.scene.static_scene import StaticScene
from vehicle_agent.lidar.models import VLP16, LidarModel
from vehicle_agent.signals.point_cloud import PointCloud

_PERIOD_NS = 100_000_000
_SENSOR_M = 2.3
_LANE_M = 4.0
# Points of a lane are at most a metre apart.
_LANE_STEP_M = 0.8


@dataclass(frozen=True, slots=True)
class Loop:
    """A rounded rectangle of these sides and radius, driven once; speeds change along it."""

    length_m: float = 90.0
    width_m: float = 60.0
    radius_m: float = 8.0
    speed_mps: float = 4.0


class SimulatedDrive:
    """The scans of one drive and the true poses of the lidar; the same for the same seed."""

    def __init__(self, seed: int, loop: Loop | None = None, model: LidarModel = VLP16) -> None:
        self._way = _way(loop or Loop())
        road_map = _block(loop or Loop(), self._way[:, 1:3], np.random.default_rng(seed))
        scene = StaticScene(road_map, seed, WorldChanges(seed=seed))
        self._ground = scene.ground
        self._T_base_sensor = in_makers_frame(mount(0.0, 0.0, _SENSOR_M, 0.0), model)
        self._lidar = SpinningLidar(
            MountedLidar("top", self._T_base_sensor, model), scene, np.random.default_rng([seed, 1])
        )
        self.scans = math.floor(float(self._way[-1, 0]) * 1e9 / _PERIOD_NS)

    def truth(self) -> Array:
        """(scans, 4, 4) of the lidar at the stamps, relative to the first."""
        poses = self._poses(_PERIOD_NS * np.arange(self.scans)) @ self._T_base_sensor
        back = np.linalg.inv(poses[0])
        relative: Array = back @ poses
        return relative

    def clouds(self) -> Iterator[PointCloud]:
        """The scans in order, each begun at its stamp."""
        for number in range(self.scans):
            yield self._lidar.scan(self._poses, number * _PERIOD_NS).cloud

    def _poses(self, times_ns: np.ndarray) -> Array:
        """(n, 4, 4) T_map_base: on the road, rolling, pitching and heaving a little."""
        times_s = times_ns * 1e-9
        t, x, y, yaw = self._way.T
        places = np.column_stack([np.interp(times_s, t, column) for column in (x, y, yaw)])
        poses = self._ground.poses(places)
        roll, pitch = 0.010 * np.sin(2.3 * times_s), 0.008 * np.sin(3.1 * times_s + 1.0)
        sway: Array = np.tile(np.eye(4), (len(times_s), 1, 1))
        sway[:, 0, 2], sway[:, 2, 0], sway[:, 1, 2], sway[:, 2, 1] = pitch, -pitch, -roll, roll
        # Small angles leave the axes a little off right angles.
        u, _, vt = np.linalg.svd(sway[:, :3, :3])
        sway[:, :3, :3] = u @ vt
        sway[:, 2, 3] = 0.02 * np.sin(1.7 * times_s)
        moved: Array = poses @ sway
        return moved


def _way(loop: Loop) -> Array:
    """(n, 4) time, x, y, yaw every few centimetres; begins and ends at rest in the middle of a long side."""
    step_m = 0.02
    straight, across = loop.length_m - 2 * loop.radius_m, loop.width_m - 2 * loop.radius_m
    bend = 0.5 * math.pi * loop.radius_m
    parts = [(0.5 * straight, 0.0)]
    for side in (across, straight, across):
        parts += [(bend, 1.0 / loop.radius_m), (side, 0.0)]
    parts += [(bend, 1.0 / loop.radius_m), (0.5 * straight, 0.0)]
    kappa = np.concatenate([np.full(round(length / step_m), curvature) for length, curvature in parts])
    yaw = np.concatenate(([0.0], np.cumsum(kappa) * step_m))
    middle = 0.5 * (yaw[1:] + yaw[:-1])
    s = step_m * np.arange(len(yaw))
    # It drives away and stops at 1 m/s2, and slows down now and then.
    speed = loop.speed_mps * (0.75 + 0.25 * np.cos(2.0 * math.pi * s / 47.0))
    speed = np.minimum(speed, np.sqrt(2.0 * np.minimum(s, s[-1] - s) + 0.02))
    time = np.concatenate(([0.0], np.cumsum(step_m / (0.5 * (speed[1:] + speed[:-1])))))
    x = np.concatenate(([0.0], np.cumsum(np.cos(middle)) * step_m))
    y = np.concatenate(([0.0], np.cumsum(np.sin(middle)) * step_m))
    return np.column_stack((time, x, y, yaw))


def _block(loop: Loop, way: Array, rng: np.random.Generator) -> RoadMap:
    """A lane around houses, with houses around it."""
    lengths = np.hypot(*np.diff(way, axis=0).T)
    s = np.concatenate(([0.0], np.cumsum(lengths)))
    at = np.linspace(0.0, s[-1], math.ceil(s[-1] / _LANE_STEP_M))
    points = tuple(
        zip(np.interp(at, s, way[:, 0]).tolist(), np.interp(at, s, way[:, 1]).tolist(), strict=True)
    )
    lane = Lane("loop", "road", points, _LANE_M, loop.speed_mps, False, ("loop",))
    centre = np.array([0.0, 0.5 * loop.width_m])
    half = 0.5 * np.array([loop.length_m, loop.width_m])
    built = houses(centre, half - 7.0, rng, inside=True) + houses(centre, half + 8.0, rng, inside=False)
    return RoadMap("block", "Block", Origin(0.0, 0.0), (lane,), (), (), (), tuple(built))


def houses(centre: Array, half: Array, rng: np.random.Generator, inside: bool) -> list[Building]:
    """Houses with gaps along the four sides of a rectangle, whose fronts are not quite in line."""
    found: list[Building] = []
    for side in range(4):
        angle = 0.5 * math.pi * side
        along, out = (
            np.array([math.cos(angle), math.sin(angle)]),
            np.array([math.sin(angle), -math.cos(angle)]),
        )
        extent, reach = (half[0], half[1]) if side % 2 == 0 else (half[1], half[0])
        at = -extent
        while at < extent - 4.0:
            width, depth = min(rng.uniform(6.0, 16.0), extent - at), rng.uniform(4.0, 9.0)
            back = rng.uniform(0.0, 2.5)
            front = reach - back - 0.5 * depth if inside else reach + back + 0.5 * depth
            middle = centre + along * (at + 0.5 * width) + out * front
            found.append(
                _house(middle, angle + rng.uniform(-0.03, 0.03), width, depth, rng.uniform(3.0, 12.0))
            )
            at += width + rng.uniform(1.0, 7.0)
    return found


def _house(middle: Array, yaw: float, length: float, width: float, height: float) -> Building:
    first = 0.5 * length * np.array([math.cos(yaw), math.sin(yaw)])
    second = 0.5 * width * np.array([-math.sin(yaw), math.cos(yaw)])
    corners = (
        middle - first - second,
        middle + first - second,
        middle + first + second,
        middle - first + second,
    )
    return Building(tuple((float(x), float(y)) for x, y in corners), float(height))
