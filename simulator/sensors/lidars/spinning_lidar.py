"""A spinning lidar on a vehicle that moves while it scans."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from contract.geometry import Array
from simulator.sensors.lidars.firings import Array32, fire, turn_of
from simulator.sensors.lidars.response import LidarResponse, response_of, response_row
from simulator.sensors.lidars.returns import answer, bloom, pack
from simulator.sensors.scene.static_scene import CastScene, StaticScene
from vehicle_agent.lidar.models import XT16, LidarModel
from vehicle_agent.signals.point_cloud import PointCloud

# T_map_base (n, 4, 4) at times (n,), ns.
Trajectory = Callable[[np.ndarray], Array]

# The trajectory is asked so often; between the answers the motion is linear (10 um, 20 urad when driving).
_POSE_EVERY_NS = 2_000_000
# Trees swing about once in four seconds.
_SWAY_RADPS = 1.6


@dataclass(frozen=True, slots=True, eq=False)
class MountedLidar:
    """One lidar and its place.

    T_base_sensor  (4, 4); the sensor's frame is that of its maker, as in `PointCloud`
    response       None for that of the maker's datasheet
    """

    name: str
    T_base_sensor: Array
    model: LidarModel = XT16
    rate_hz: float = 10.0
    response: LidarResponse | None = None


@dataclass(frozen=True, slots=True, eq=False)
class LidarScan:
    """One turn.

    cloud        as decoded from the sensor's packets: distorted by the motion during the turn
    points_base  (n, 3) the same points by T_base_sensor
    ghosts       how many of them are bloom beside a retro-reflector
    """

    cloud: PointCloud
    points_base: Array32
    ghosts: int = 0


@dataclass(frozen=True, slots=True, eq=False)
class MovingBodies:
    """What moves, as it stands from the end of the bodies before until `until_ns`."""

    until_ns: int
    scene: CastScene = field(repr=False)


class SpinningLidar:
    """One sensor of one vehicle; the same generator state and poses give the same bytes."""

    def __init__(
        self,
        mounted: MountedLidar,
        scene: StaticScene,
        rng: np.random.Generator,
        own_body: CastScene | None = None,
        rain_mm_per_h: float = 0.0,
    ) -> None:
        """own_body: the vehicle itself in its base frame; its returns are in every scan."""
        self.mounted, self._scene, self._rng = mounted, scene, rng
        model = mounted.model
        self.period_ns = round(1e9 / mounted.rate_hz)
        self._directions, self._offsets_ns, self._rings = turn_of(model, mounted.rate_hz)
        self._params = response_row(
            mounted.response or response_of(model),
            (model.range_m_min, model.range_m_max),
            rain_mm_per_h,
            scene.changes.sway_m,
        )
        self._mount = mounted.T_base_sensor[:3].astype(np.float32)
        n = len(self._offsets_ns)
        self._own_m, self._own_intensity = self._own_returns(own_body)
        self._origins: Array32 = np.empty((n, 3), dtype=np.float32)
        self._rays_map: Array32 = np.empty((n, 3), dtype=np.float32)
        self._rays = np.empty(n, dtype=np.int64)
        self._spare: Array32 = np.empty(n, dtype=np.float32)

    def scan(self, trajectory: Trajectory, begin_ns: int, moving: Sequence[MovingBodies] = ()) -> LidarScan:
        """The turn that begins at begin_ns.

        trajectory  T_map_base (n, 4, 4) at times (n,) int64, ns; asked from begin_ns to the end of the turn
        moving      in order of time; the last one is valid to the end of the turn
        """
        poses = self._sensor_poses(trajectory, begin_ns)
        n = len(self._offsets_ns)
        count = fire(
            poses, float(_POSE_EVERY_NS), self._directions, self._offsets_ns, self._own_m,
            self._origins, self._rays_map, self._rays,
        )  # fmt: skip
        origins, rays_map, rays = self._origins[:count], self._rays_map[:count], self._rays[:count]
        noise = self._rng.standard_normal((n, 2), dtype=np.float32)
        chance = self._rng.random((n, 2), dtype=np.float32)
        ranges, intensities = self._own_m.copy(), self._own_intensity.copy()
        far = np.full(count, self.mounted.model.range_m_max, dtype=np.float32)
        hit_m, triangles = self._scene.cast(origins, rays_map, far)
        wind_rad = _SWAY_RADPS * begin_ns * 1e-9
        self._answer(
            self._scene, rays, hit_m, triangles, rays_map, wind_rad, noise, chance, ranges, intensities
        )
        first = 0
        for number, bodies in enumerate(moving):
            is_last = number == len(moving) - 1
            end = count if is_last else self._first_ray_after(bodies.until_ns - begin_ns, rays)
            if end > first:
                self._answer_moving(
                    bodies.scene, slice(first, end), hit_m, wind_rad, noise, chance, ranges, intensities
                )
            first = max(first, end)
        ghosts = bloom(
            self.mounted.model.channels, self._params, chance, self._own_m, ranges, intensities, self._spare
        )
        points, based, values, rings, times = pack(
            ranges, intensities, self._directions, self._offsets_ns, self._rings, self._mount
        )
        return LidarScan(PointCloud(begin_ns, points, values, rings, times), based, ghosts)

    def _first_ray_after(self, offset_ns: int, rays: np.ndarray) -> int:
        firing = int(np.searchsorted(self._offsets_ns, offset_ns))
        return int(np.searchsorted(rays, firing))

    def _answer_moving(
        self,
        scene: CastScene,
        part: slice,
        hit_m: Array32,
        wind_rad: float,
        noise: Array32,
        chance: Array32,
        ranges: Array32,
        intensities: Array32,
    ) -> None:
        """Where a body that moves is nearer than what stands still, its return replaces the other one."""
        rays_map = self._rays_map[part]
        near_m, triangles = scene.cast(self._origins[part], rays_map, hit_m[part].copy())
        found = np.flatnonzero(triangles >= 0)
        if len(found):
            self._answer(
                scene, self._rays[part][found], near_m[found], triangles[found], rays_map[found],
                wind_rad, noise, chance, ranges, intensities,
            )  # fmt: skip

    def _answer(
        self,
        scene: CastScene,
        rays: np.ndarray,
        hit_m: Array32,
        triangles: np.ndarray,
        rays_map: Array32,
        wind_rad: float,
        noise: Array32,
        chance: Array32,
        ranges: Array32,
        intensities: Array32,
    ) -> None:
        surfaces = scene.surfaces
        answer(
            rays, len(rays), hit_m, triangles, rays_map, surfaces.normals, surfaces.materials,
            surfaces.reflectivity, surfaces.objects, self._scene.sway_phases, wind_rad, self._params,
            noise, chance, ranges, intensities,
        )  # fmt: skip

    def _sensor_poses(self, trajectory: Trajectory, begin_ns: int) -> Array:
        steps = math.ceil(self._offsets_ns[-1] / _POSE_EVERY_NS) + 1
        times_ns = begin_ns + _POSE_EVERY_NS * np.arange(steps + 1, dtype=np.int64)
        poses: Array = np.asarray(trajectory(times_ns), dtype=np.float64) @ self.mounted.T_base_sensor
        return poses

    def _own_returns(self, own_body: CastScene | None) -> tuple[Array32, Array32]:
        """Ranges and intensities of the firings that the vehicle itself stops; 0.0 for the others."""
        n = len(self._offsets_ns)
        ranges: Array32 = np.zeros(n, dtype=np.float32)
        intensities: Array32 = np.zeros(n, dtype=np.float32)
        if own_body is None:
            return ranges, intensities
        rays = (self._directions @ self.mounted.T_base_sensor[:3, :3].T).astype(np.float32)
        origins = np.broadcast_to(self.mounted.T_base_sensor[:3, 3], (n, 3)).astype(np.float32)
        hit_m, triangles = own_body.cast(
            origins, np.ascontiguousarray(rays), np.full(n, 15.0, dtype=np.float32)
        )
        found = triangles >= 0
        ranges[found] = hit_m[found]
        intensities[found] = np.floor(100.0 * own_body.surfaces.reflectivity[triangles[found]])
        return ranges, intensities
