"""A straight road with boards beside it, and what a vehicle's lidars see of it on the way."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.signs.front import FrontLidar
from campusloop.scenes.path_map import path_map
from contract.geometry import Array, Pose2
from simulator.sensors.lidars.driver import moved_to_end
from simulator.sensors.lidars.mounts import four_lidars, lidars_of
from simulator.sensors.scene.changes import WorldChanges
from simulator.sensors.scene.ground import Ground
from simulator.sensors.scene.mesh import PackedMesh
from simulator.sensors.scene.shapes import shuttle
from simulator.sensors.scene.sign_boards import board_on_post
from simulator.sensors.scene.static_scene import CastScene, StaticScene
from vehicle_agent.config import Profile

PERIOD_NS = 100_000_000
# What wheels and gyroscope add to the motion by which the driver puts a turn's points together.
_SPEED_STD_MPS, _YAW_RATE_STD_RADPS = 0.02, 0.003


@dataclass(frozen=True, slots=True)
class Board:
    """A board on a post: name says what it is; turned_rad: from square to the road."""

    name: str
    outline: Array
    x_m: float
    y_m: float
    bottom_m: float
    turned_rad: float = 0.0

    @property
    def middle(self) -> Array:
        """(2,) in the map."""
        return np.array([self.x_m, self.y_m])


@dataclass(frozen=True, slots=True)
class Scan:
    """One turn in the base frame at its end, and where the vehicle was then."""

    stamp_ns: int
    pose_map: Pose2
    points_base: Array
    intensities: Array


class SignRoad:
    """One seed's road: hills, posts, plates, trees, parked vehicles, works; and the given boards."""

    def __init__(
        self,
        profile: Profile,
        boards: Sequence[Board],
        seed: int,
        *,
        width_m: float,
        length_m: float = 90.0,
        trees: bool = True,
    ) -> None:
        line = np.column_stack((np.arange(0.0, length_m + 0.1, 0.5), np.zeros(int(2 * length_m) + 1)))
        self.road_map = path_map("sign road", line, width_m=width_m, speed_limit_mps=5.0)
        changes = WorldChanges(
            seed=seed, parked_ratio=0.5, works=max(1, int(length_m / 100.0)),
            trees_felled_ratio=0.0 if trees else 1.0,
        )  # fmt: skip
        ground = Ground(self.road_map, seed)
        self.scene = StaticScene(self.road_map, seed, changes, placed=[_placed(b, ground) for b in boards])
        self._profile, self._seed = profile, seed

    def rig(self, *, four: bool) -> "Rig":
        return Rig(self.scene, self._profile, self._seed, four=four)


class Rig:
    """The vehicle's lidars on the road."""

    def __init__(self, scene: StaticScene, profile: Profile, seed: int, *, four: bool) -> None:
        body = profile.body
        own = CastScene(shuttle(body.length_m, body.width_m, body.height_m, body.rear_overhang_m))
        mounted = four_lidars(body) if four else lidars_of(profile)
        self._scene, self._wheelbase_m = scene, body.wheelbase_m
        self._rng = np.random.default_rng([seed, *b"rig"])
        self._lidars = [
            FrontLidar(one, scene, np.random.default_rng([seed, number]), own)
            for number, one in enumerate(mounted)
        ]
        self.x_m = float(mounted[0].T_base_sensor[0, 3])
        self.z_m = float(mounted[0].T_base_sensor[2, 3])

    def drive(self, speed_mps: float, from_m: float, to_m: float, y_m: float = 0.0) -> Iterator[Scan]:
        """The turns while the base goes from one place to another."""
        for turn in range(int((to_m - from_m) / (speed_mps * PERIOD_NS * 1e-9))):
            yield self._scan(turn * PERIOD_NS, speed_mps, from_m, y_m)

    def stand(self, x_m: float, y_m: float = 0.0) -> Scan:
        """One turn of the standing vehicle."""
        return self._scan(0, 0.0, x_m, y_m)

    def visible_ratio(self, board: Board, pose_map: Pose2) -> float:
        """Share of the board that nothing hides from the first lidar."""
        base = self._scene.ground.poses(np.array([[pose_map.x_m, pose_map.y_m, 0.0]]), self._wheelbase_m)[0]
        eye = (base @ np.array([self.x_m, 0.0, self.z_m, 1.0]))[:3]
        ground = self._scene.ground.pavement_m(np.array([board.x_m]), np.array([board.y_m]))[0]
        lift = float(ground) + board.bottom_m - float(board.outline[:, 1].min())
        shares = np.array([0.2, 0.5, 0.8])
        corners = (board.outline[None] * shares[:, None, None]).reshape(-1, 2)
        places = np.column_stack(
            (np.full(len(corners), board.x_m - 0.05), board.y_m + corners[:, 0], lift + corners[:, 1])
        )
        rays = places - eye
        ranges = np.linalg.norm(rays, axis=1)
        origins = np.ascontiguousarray(np.broadcast_to(eye, rays.shape), dtype=np.float32)
        directions = np.ascontiguousarray(rays / ranges[:, None], dtype=np.float32)
        hits, _ = self._scene.cast(origins, directions, (ranges + 1.0).astype(np.float32))
        return float(np.mean(hits >= ranges - 0.3))

    def _scan(self, begin_ns: int, speed_mps: float, from_m: float, y_m: float) -> Scan:
        def trajectory(times_ns: np.ndarray) -> Array:
            rows = np.zeros((len(times_ns), 3))
            rows[:, 0], rows[:, 1] = from_m + speed_mps * times_ns * 1e-9, y_m
            return self._scene.ground.poses(rows, self._wheelbase_m)

        scans = [lidar.scan(trajectory, begin_ns) for lidar in self._lidars]
        moves = float(speed_mps > 0.0)
        speed = speed_mps + moves * _SPEED_STD_MPS * float(self._rng.standard_normal())
        yaw_rate = moves * _YAW_RATE_STD_RADPS * float(self._rng.standard_normal())
        parts = [
            moved_to_end(scan.points_base, scan.offsets_ns, PERIOD_NS, speed, yaw_rate) for scan in scans
        ]
        end_ns = begin_ns + PERIOD_NS
        pose = Pose2(from_m + speed_mps * end_ns * 1e-9, y_m, 0.0)
        return Scan(end_ns, pose, np.concatenate(parts), np.concatenate([scan.intensities for scan in scans]))


def _placed(board: Board, ground: Ground) -> PackedMesh:
    z_m = float(ground.pavement_m(np.array([board.x_m]), np.array([board.y_m]))[0])
    pose = np.array([[board.x_m, board.y_m, z_m, board.turned_rad]])
    return board_on_post(board.outline, board.bottom_m).placed(pose, np.ones((1, 3)))


def beside(name: str, outline: Array, x_m: float, width_m: float, rng: np.random.Generator) -> Board:
    """A board on the right-hand side: 0.5 m to 1.5 m beyond the edge, up to 15 degrees from square."""
    y_m = -0.5 * width_m - rng.uniform(0.5, 1.5)
    turned = rng.uniform(-1.0, 1.0) * math.radians(15.0)
    return Board(name, outline, x_m, float(y_m), float(rng.uniform(1.8, 2.3)), float(turned))
