"""One turn of a sensor in the scene: rays, hits and returns."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from contract.geometry import Array
from simulator.sensors.lidars.firings import Array32, Times, fire
from simulator.sensors.lidars.returns import answer, bloom
from simulator.sensors.scene.static_scene import CastScene, RayTarget, StaticScene

# T_map_base (n, 4, 4) at times (n,), ns.
Trajectory = Callable[[np.ndarray], Array]

# The trajectory is asked so often; between the answers the motion is linear (10 um, 20 urad when driving).
_POSE_EVERY_NS = 2_000_000
# Trees swing about once in four seconds.
_SWAY_RADPS = 1.6
# The own body is nearer than this.
_OWN_REACH_M = 15.0


@dataclass(frozen=True, slots=True, eq=False)
class Turn:
    """The firings of one turn, in the sensor's frame and in the order of time.

    directions (n, 3), offsets_ns (n,), rings (n,); channels: firings of one azimuth
    """

    directions: Array32
    offsets_ns: Times
    rings: NDArray[np.uint16]
    channels: int


@dataclass(frozen=True, slots=True, eq=False)
class MovingBodies:
    """What moves, as it stands from the end of the bodies before until `until_ns`."""

    until_ns: int
    scene: RayTarget = field(repr=False)


@dataclass(frozen=True, slots=True, eq=False)
class TurnReturns:
    """ranges (n,) m and intensities (n,) of a turn's firings, 0.0 for none; ghosts: returns by bloom."""

    ranges: Array32
    intensities: Array32
    ghosts: int


class Scanner:
    """Casts turns from a moving vehicle; the same generator state and poses give the same bytes."""

    def __init__(
        self,
        turn: Turn,
        T_base_sensor: Array,
        params: Array32,
        scene: StaticScene,
        rng: np.random.Generator,
        own_body: CastScene | None = None,
    ) -> None:
        """params: as `response_row` gives them; own_body: the vehicle in its base frame."""
        self.turn = turn
        self._T_base_sensor, self._params, self._scene, self._rng = T_base_sensor, params, scene, rng
        n = len(turn.offsets_ns)
        self._own_m, self._own_intensity = self._own_returns(own_body)
        self._origins: Array32 = np.empty((n, 3), dtype=np.float32)
        self._rays_map: Array32 = np.empty((n, 3), dtype=np.float32)
        self._rays = np.empty(n, dtype=np.int64)
        self._spare: Array32 = np.empty(n, dtype=np.float32)
        self._before: _StandingHits | None = None

    @property
    def rays(self) -> int:
        """Firings of a turn that the own body does not stop."""
        return int(np.count_nonzero(self._own_m == 0.0))

    def measure(
        self, trajectory: Trajectory, begin_ns: int, moving: Sequence[MovingBodies], range_m_max: float
    ) -> TurnReturns:
        """The returns of the turn that begins at begin_ns."""
        turn = self.turn
        n = len(turn.offsets_ns)
        standing = self._standing_hits(trajectory, begin_ns, range_m_max)
        hit_m, triangles = standing.ranges_m, standing.triangles
        count = len(hit_m)
        draws = _Draws(
            self._rng.standard_normal((n, 2), dtype=np.float32), self._rng.random((n, 2), dtype=np.float32)
        )
        returns = TurnReturns(self._own_m.copy(), self._own_intensity.copy(), 0)
        wind_rad = _SWAY_RADPS * begin_ns * 1e-9
        every = slice(0, count)
        self._answer(
            self._scene, self._rays[every], hit_m, triangles, self._rays_map[every], wind_rad, draws, returns
        )
        first = 0
        for bodies in moving:
            is_last = bodies is moving[-1]
            end = count if is_last else self._first_ray_at(bodies.until_ns - begin_ns, count)
            if end > first:
                self._answer_moving(bodies.scene, slice(first, end), hit_m, wind_rad, draws, returns)
                first = end
        ghosts = bloom(
            turn.channels, self._params, draws.chance, self._own_m, returns.ranges, returns.intensities,
            self._spare,
        )  # fmt: skip
        return TurnReturns(returns.ranges, returns.intensities, ghosts)

    def _standing_hits(self, trajectory: Trajectory, begin_ns: int, range_m_max: float) -> "_StandingHits":
        """Where rays meet what stands still; a vehicle that stands, too, meets what it met before."""
        poses = self._sensor_poses(trajectory, begin_ns)
        before = self._before
        if before is not None and before.range_m_max == range_m_max and np.array_equal(before.poses, poses):
            return before
        count = fire(
            poses, float(_POSE_EVERY_NS), self.turn.directions, self.turn.offsets_ns, self._own_m,
            self._origins, self._rays_map, self._rays,
        )  # fmt: skip
        far = np.full(count, range_m_max, dtype=np.float32)
        hits = self._scene.cast(self._origins[:count], self._rays_map[:count], far)
        self._before = _StandingHits(poses, range_m_max, *hits)
        return self._before

    def _first_ray_at(self, offset_ns: int, count: int) -> int:
        firing = int(np.searchsorted(self.turn.offsets_ns, offset_ns))
        return int(np.searchsorted(self._rays[:count], firing))

    def _answer_moving(
        self,
        scene: RayTarget,
        part: slice,
        hit_m: Array32,
        wind_rad: float,
        draws: "_Draws",
        returns: TurnReturns,
    ) -> None:
        """Where a body that moves is nearer than what stands still, its return replaces the other one."""
        rays_map = self._rays_map[part]
        near_m, triangles = scene.cast(self._origins[part], rays_map, hit_m[part].copy())
        found = np.flatnonzero(triangles >= 0)
        if len(found):
            rays, hits = self._rays[part][found], triangles[found]
            self._answer(scene, rays, near_m[found], hits, rays_map[found], wind_rad, draws, returns)

    def _answer(
        self,
        scene: RayTarget,
        rays: NDArray[np.int64],
        hit_m: Array32,
        triangles: NDArray[np.int32],
        rays_map: Array32,
        wind_rad: float,
        draws: "_Draws",
        returns: TurnReturns,
    ) -> None:
        surfaces = scene.surfaces
        answer(
            rays, len(rays), hit_m, triangles, rays_map, surfaces.normals, surfaces.materials,
            surfaces.reflectivity, surfaces.objects, self._scene.sway_phases, wind_rad, self._params,
            draws.noise, draws.chance, returns.ranges, returns.intensities,
        )  # fmt: skip

    def _sensor_poses(self, trajectory: Trajectory, begin_ns: int) -> Array:
        steps = math.ceil(self.turn.offsets_ns[-1] / _POSE_EVERY_NS) + 1
        times_ns = begin_ns + _POSE_EVERY_NS * np.arange(steps + 1, dtype=np.int64)
        poses: Array = np.asarray(trajectory(times_ns), dtype=np.float64) @ self._T_base_sensor
        return poses

    def _own_returns(self, own_body: CastScene | None) -> tuple[Array32, Array32]:
        """Ranges and intensities of the firings that the vehicle itself stops; 0.0 for the others."""
        n = len(self.turn.offsets_ns)
        ranges: Array32 = np.zeros(n, dtype=np.float32)
        intensities: Array32 = np.zeros(n, dtype=np.float32)
        if own_body is None:
            return ranges, intensities
        rays = np.ascontiguousarray(self.turn.directions @ self._T_base_sensor[:3, :3].T, dtype=np.float32)
        origins = np.broadcast_to(self._T_base_sensor[:3, 3], (n, 3)).astype(np.float32)
        reach = np.full(n, _OWN_REACH_M, dtype=np.float32)
        hit_m, triangles = own_body.cast(origins, rays, reach)
        found = triangles >= 0
        ranges[found] = hit_m[found]
        intensities[found] = np.floor(100.0 * own_body.surfaces.reflectivity[triangles[found]])
        return ranges, intensities


@dataclass(frozen=True, slots=True, eq=False)
class _StandingHits:
    """What a turn met: the sensor's poses; ranges_m and triangles (m,) of the rays that leave the vehicle."""

    poses: Array
    range_m_max: float
    ranges_m: Array32
    triangles: NDArray[np.int32]


@dataclass(frozen=True, slots=True, eq=False)
class _Draws:
    """noise (n, 2) standard normal and chance (n, 2) uniform, of every firing."""

    noise: Array32
    chance: Array32
