"""A drive around a block that ends where it began, scanned by a turning lidar while the vehicle moves."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene

from contract.geometry import Array
from vehicle_agent.lidar.models import HESAI, VLP16, LidarModel
from vehicle_agent.signals.point_cloud import PointCloud, point_cloud

_COLUMNS = 900
_PERIOD_S = 0.1
_SENSOR_M = 2.3
_RANGE_STD_M = {HESAI: 0.006}
_VELODYNE_STD_M = 0.015
_DROPOUT = 0.03
# Nothing stands nearer to the way.
_CLEAR_M = 2.6


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
        self._rng = np.random.default_rng(seed)
        self._loop, self._model = loop or Loop(), model
        self._scene = EmbreeScene()
        # embreex keeps no reference of its own.
        self._way = _way(self._loop)
        triangles = _triangles(self._loop, self._way[:, 1:3], self._rng)
        self._mesh = TriangleMesh(self._scene, triangles.astype(np.float32))
        self._duration_s = float(self._way[-1, 0])
        self.scans = math.floor(self._duration_s / _PERIOD_S)

    def truth(self) -> Array:
        """(scans, 4, 4) of the lidar at the stamps, relative to the first."""
        poses = self._poses(_PERIOD_S * np.arange(self.scans))
        back = np.linalg.inv(poses[0])
        relative: Array = back @ poses
        return relative

    def clouds(self) -> Iterator[PointCloud]:
        """The scans in order, each begun at its stamp."""
        model = self._model
        azimuths = -2.0 * math.pi * np.arange(_COLUMNS) / _COLUMNS
        azimuth = azimuths[:, None] + model.azimuths_rad[None, :]
        level = np.cos(model.elevations_rad)[None, :]
        up = np.broadcast_to(np.sin(model.elevations_rad), azimuth.shape)
        directions = np.stack((level * np.cos(azimuth), level * np.sin(azimuth), up), axis=2)
        times_s = _PERIOD_S * np.arange(_COLUMNS) / _COLUMNS
        std_m = _RANGE_STD_M.get(model.maker, _VELODYNE_STD_M)
        for number in range(self.scans):
            poses = self._poses(number * _PERIOD_S + times_s)
            rays = np.einsum("cij,crj->cri", poses[:, :3, :3], directions).reshape(-1, 3).astype(np.float32)
            origins = np.repeat(poses[:, :3, 3], model.channels, axis=0).astype(np.float32)
            reach = self._scene.run(
                origins, rays, np.full(len(rays), 100.0, dtype=np.float32), query="DISTANCE"
            )
            reach = reach.astype(np.float64) + self._rng.normal(0.0, std_m, len(rays))
            hit = (reach < 99.0) & (reach > 0.8) & (self._rng.random(len(rays)) > _DROPOUT)
            points = directions.reshape(-1, 3)[hit] * reach[hit, None]
            offsets_ns = np.rint(1e9 * np.repeat(times_s, model.channels))[hit]
            rings = np.tile(model.rings, _COLUMNS)[hit]
            yield point_cloud(round(1e9 * number * _PERIOD_S), points, None, rings, offsets_ns)

    def _poses(self, times_s: Array) -> Array:
        """(n, 4, 4) of the lidar in the scene: along the way, rolling and pitching a little."""
        t, x, y, yaw = self._way.T
        yaws = np.interp(times_s, t, yaw)
        roll, pitch = 0.010 * np.sin(2.3 * times_s), 0.008 * np.sin(3.1 * times_s + 1.0)
        cy, sy = np.cos(yaws), np.sin(yaws)
        poses = np.zeros((len(times_s), 4, 4))
        poses[:, 0, 0], poses[:, 0, 1], poses[:, 0, 2] = cy, -sy, cy * pitch + sy * roll
        poses[:, 1, 0], poses[:, 1, 1], poses[:, 1, 2] = sy, cy, sy * pitch - cy * roll
        poses[:, 2, 0], poses[:, 2, 1], poses[:, 2, 2] = -pitch, roll, 1.0
        # Small angles leave the axes a little off right angles.
        u, _, vt = np.linalg.svd(poses[:, :3, :3])
        poses[:, :3, :3] = u @ vt
        poses[:, 0, 3], poses[:, 1, 3] = np.interp(times_s, t, x), np.interp(times_s, t, y)
        poses[:, 2, 3] = _SENSOR_M + 0.02 * np.sin(1.7 * times_s)
        poses[:, 3, 3] = 1.0
        return poses


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


def _triangles(loop: Loop, way: Array, rng: np.random.Generator) -> Array:
    """Ground, houses inside and outside of the loop, parked cars, poles and trunks beside it."""
    found: list[Array] = [
        _quad(np.array([-400.0, -400.0, 0.0]), np.array([800.0, 0.0, 0.0]), np.array([0.0, 800.0, 0.0]))
    ]
    centre = np.array([0.0, 0.5 * loop.width_m])
    half = 0.5 * np.array([loop.length_m, loop.width_m])
    found += _blocks(centre, half - 7.0, rng, inside=True) + _blocks(centre, half + 8.0, rng, inside=False)
    for _ in range(60):
        place = _beside(centre, half, rng)
        if np.linalg.norm(way - place, axis=1).min() < _CLEAR_M:
            continue
        if rng.random() < 0.4:
            found += _box(place, rng.uniform(-0.1, 0.1) + rng.integers(0, 2) * 0.5 * math.pi, 4.2, 1.8, 1.5)
        else:
            width = rng.uniform(0.15, 0.5)
            found += _box(place, rng.uniform(0.0, 1.5), width, width, rng.uniform(2.0, 7.0))
    return np.concatenate(found)


def _blocks(centre: Array, half: Array, rng: np.random.Generator, inside: bool) -> list[Array]:
    """Houses with gaps along the four sides of a rectangle, whose fronts are not quite in line."""
    found: list[Array] = []
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
            found += _box(middle, angle + rng.uniform(-0.03, 0.03), width, depth, rng.uniform(3.0, 12.0))
            at += width + rng.uniform(1.0, 7.0)
    return found


def _beside(centre: Array, half: Array, rng: np.random.Generator) -> Array:
    """A place 3 to 5 m beside the way."""
    off = rng.uniform(3.0, 5.0) * rng.choice([-1.0, 1.0])
    side, share = int(rng.integers(0, 4)), rng.uniform(-0.9, 0.9)
    if side % 2 == 0:
        return centre + np.array([share * half[0], (half[1] + off) * (1.0 if side else -1.0)])
    return centre + np.array([(half[0] + off) * (1.0 if side == 1 else -1.0), share * half[1]])


def _box(middle: Array, yaw: float, length: float, width: float, height: float) -> list[Array]:
    first = length * np.array([math.cos(yaw), math.sin(yaw), 0.0])
    second = width * np.array([-math.sin(yaw), math.cos(yaw), 0.0])
    foot = np.append(middle, 0.0) - 0.5 * first - 0.5 * second
    up = np.array([0.0, 0.0, height])
    return [
        _quad(foot, first, up), _quad(foot + second, first, up), _quad(foot, second, up),
        _quad(foot + first, second, up), _quad(foot + up, first, second),
    ]  # fmt: skip


def _quad(corner: Array, first: Array, second: Array) -> Array:
    a, b, c, d = corner, corner + first, corner + first + second, corner + second
    return np.array([[a, b, c], [a, c, d]])
