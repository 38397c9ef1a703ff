"""Two turns of a vehicle's lidars among road users, put together as on the vehicle, with the true boxes."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from campusloop.scenes.detector_scenes.campuses import CampusScene
from campusloop.scenes.detector_scenes.road_users import REACH_M, draw_bodies, draw_kinds
from contract.geometry import Array
from simulator.fleet import STEP_NS
from simulator.sensors.lidars.driver import moved_to_end
from simulator.sensors.lidars.firings import Array32
from simulator.sensors.lidars.mounts import four_lidars, roof_lidar
from simulator.sensors.lidars.response import LidarResponse
from simulator.sensors.lidars.scanner import MovingBodies
from simulator.sensors.lidars.spinning_lidar import MountedLidar, SpinningLidar
from simulator.sensors.scene.moving_scene import MovingScenes
from simulator.sensors.scene.shapes import shuttle
from simulator.sensors.scene.static_scene import CastScene
from simulator.sensors.scene.varied_bodies import Looks, VariedBodies
from simulator.traffic.actors import PERSON_HEIGHT_M, Bodies
from vehicle_agent.config import Body
from vehicle_agent.lidar.models import VLP16, XT32
from vehicle_agent.perception.pillars.standing_points import standing_points
from vehicle_agent.perception.pillars.sweeps import OLDER_NS
from vehicle_agent.signals import CYCLIST, OTHER, PEDESTRIAN, VEHICLE
from vehicle_agent.stacks.own_perception import own_outline
from workshop.detector.labeled_scans import LabeledScan

_TURN_NS = 100_000_000
_FLEET_FROM = 1_000_000
# Errors of wheel speed and gyroscope, as in the world's lidars' driver.
_SPEED_STD_MPS, _YAW_RATE_STD_RADPS = 0.02, 0.003
# Returns this near to a box's side belong to it; what moves is smeared along its way during a turn.
_BESIDE_M = 0.1
_HEIGHTS_M = {PEDESTRIAN: PERSON_HEIGHT_M, CYCLIST: 1.75, VEHICLE: 1.48, OTHER: 1.0}
_PLAIN_M = {PEDESTRIAN: (0.5, 0.5), CYCLIST: (1.75, 0.6), VEHICLE: (4.4, 1.8), OTHER: (0.5, 0.5)}


@dataclass(frozen=True, slots=True)
class Motion:
    """The own motion during a scene: constant speed and yaw rate, with a little roll and pitch."""

    pose_map: Array
    end_ns: int
    speed_mps: float
    yaw_rate_radps: float

    def places(self, times_ns: NDArray[np.int64]) -> Array:
        """(n, 3) x, y, yaw at times (n,); the pose is that at end_ns."""
        left_s = (np.asarray(times_ns) - self.end_ns) * 1e-9
        yaw = self.pose_map[2] + self.yaw_rate_radps * left_s
        middle = self.pose_map[2] + 0.5 * self.yaw_rate_radps * left_s
        way = self.speed_mps * left_s
        return np.column_stack(
            (self.pose_map[0] + way * np.cos(middle), self.pose_map[1] + way * np.sin(middle), yaw)
        )


class SceneRecorder:
    """Makes labeled scans on one campus; the same seed gives the same scan.

    varied  bodies, mounts and sensors of many kinds, to learn from; else those of a simulated world
    """

    def __init__(self, campus: CampusScene, varied: bool) -> None:
        self._campus, self._varied = campus, varied
        self._plain_bodies = MovingScenes(campus.static.ground, _FLEET_FROM)
        self._bodies = VariedBodies(campus.static.ground)

    def record(self, seed: tuple[int, ...]) -> LabeledScan:
        """One scene at a place, with road users and sensors that the seed draws."""
        rng = np.random.default_rng(seed)
        end_ns = OLDER_NS + _TURN_NS
        speed_mps = 0.0 if rng.random() < 0.2 else float(rng.uniform(0.3, 5.0))
        yaw_rate = float(rng.normal(0.0, 0.12)) * min(1.0, speed_mps)
        motion = Motion(self._campus.draw_place(rng), end_ns, speed_mps, yaw_rate)
        bodies, heights_m, looks = self._draw_bodies(motion.pose_map, rng)
        body = Body()
        own = CastScene(shuttle(body.length_m, body.width_m, body.height_m, body.rear_overhang_m))
        lidars = [
            SpinningLidar(mounted, self._campus.static, np.random.default_rng(rng.integers(1 << 62)), own)
            for mounted in self._lidars(body, rng)
        ]
        measured = (
            speed_mps + _SPEED_STD_MPS * rng.standard_normal() * (speed_mps > 0.0),
            yaw_rate + _YAW_RATE_STD_RADPS * rng.standard_normal(),
        )
        parts, values, older = [], [], []
        for begin_ns in (0, OLDER_NS):
            moving = self._moving(begin_ns, end_ns, bodies, looks)
            for lidar in lidars:
                scan = lidar.scan(
                    lambda t: self._campus.static.ground.poses(motion.places(t)), begin_ns, moving
                )
                parts.append(
                    moved_to_end(scan.points_base, scan.cloud.offsets_ns, end_ns - begin_ns, *measured)
                )
                values.append(scan.cloud.intensities)
                older.append(np.full(len(scan.points_base), begin_ns == 0))
        points = np.concatenate(parts)
        rows, heights = standing_points(points, own_outline(body), reach_m=REACH_M)
        kept = np.column_stack((points[rows, :2], heights, np.concatenate(values)[rows])).astype(np.float32)
        is_older = np.concatenate(older)[rows]
        kinds, boxes = self._boxes(motion.pose_map, bodies, heights_m)
        hits = hits_of(kept[~is_older, :2], boxes)
        return LabeledScan(kept, is_older, OLDER_NS * 1e-9, kinds, boxes, hits)

    def _draw_bodies(self, around: Array, rng: np.random.Generator) -> tuple[Bodies, Array, Looks | None]:
        kinds = draw_kinds(rng, with_others=self._varied)
        if self._varied:
            looks = self._bodies.draw(kinds, rng)
            sizes = self._bodies.sizes_m(looks)
            bodies, rows = draw_bodies(kinds, sizes, self._campus, around, rng)
            looks = Looks(looks.builds[rows], looks.scales[rows], looks.shades[rows])
            return bodies, sizes[rows, 2], looks
        sizes = np.array([[*_PLAIN_M[int(kind)], _HEIGHTS_M[int(kind)]] for kind in kinds])
        vehicles = np.flatnonzero(kinds == VEHICLE)
        sizes[vehicles, :2] *= rng.uniform(0.92, 1.08, (len(vehicles), 1))
        bodies, rows = draw_bodies(kinds, sizes, self._campus, around, rng)
        return bodies, sizes[rows, 2], None

    def _lidars(self, body: Body, rng: np.random.Generator) -> list[MountedLidar]:
        """Four XT16 as on the vehicle; varied: with other places, sensors and some missing."""
        lidars = list(four_lidars(body))
        if not self._varied:
            return lidars
        chance = rng.random()
        if chance < 0.1:
            lidars = [roof_lidar(body, VLP16)]
        elif chance < 0.25:
            del lidars[int(rng.integers(len(lidars)))]
        elif chance < 0.35:
            lidars = list(four_lidars(body, XT32))[: int(rng.integers(1, 3))]
        dropout = 0.005 if rng.random() < 0.6 else float(rng.uniform(0.0, 0.15))
        changed = []
        for lidar in lidars:
            near = LidarResponse(
                range_std_m=float(rng.uniform(0.004, 0.025)), range_10_m=float(rng.uniform(45.0, 90.0)),
                divergence_rad=float(rng.uniform(0.0015, 0.003)), dropout_ratio=dropout,
            )  # fmt: skip
            pose = lidar.T_base_sensor @ _small_motion(rng)
            changed.append(MountedLidar(lidar.name, pose, lidar.model, lidar.rate_hz, near))
        return changed

    def _moving(
        self, begin_ns: int, end_ns: int, bodies: Bodies, looks: Looks | None
    ) -> tuple[MovingBodies, ...]:
        moving = []
        for until_ns in range(begin_ns + STEP_NS, begin_ns + _TURN_NS + 1, STEP_NS):
            poses = bodies.poses_map.copy()
            poses[:, :2] += bodies.velocities_map_mps * ((until_ns - end_ns) * 1e-9)
            there = Bodies(bodies.numbers, bodies.kinds, poses, bodies.velocities_map_mps, bodies.sizes_m)
            scene = self._plain_bodies.of(there) if looks is None else self._bodies.of(there, looks)
            moving.append(MovingBodies(until_ns, scene))
        return tuple(moving)

    def _boxes(self, pose_map: Array, bodies: Bodies, heights_m: Array) -> tuple[NDArray[np.int64], Array]:
        """(kinds (m,), boxes (m, 8)) of road users and parked vehicles; other things are left out."""
        labeled = bodies.kinds != OTHER
        parked = self._campus.static.parked
        parked = parked[np.hypot(*(parked[:, :2] - pose_map[:2]).T) < REACH_M + 8.0]
        users = np.column_stack((bodies.poses_map, bodies.sizes_m, heights_m, bodies.velocities_map_mps))[
            labeled
        ]
        boxes = np.vstack((users, np.hstack((parked, np.zeros((len(parked), 2))))))
        kinds = np.concatenate((bodies.kinds[labeled], np.full(len(parked), VEHICLE, dtype=np.int64)))
        cos, sin = math.cos(pose_map[2]), math.sin(pose_map[2])
        into = np.array([[cos, sin], [-sin, cos]])
        boxes[:, :2] = (boxes[:, :2] - pose_map[:2]) @ into.T
        boxes[:, 6:] = boxes[:, 6:] @ into.T
        boxes[:, 2] = np.angle(np.exp(1j * (boxes[:, 2] - pose_map[2])))
        near = np.abs(boxes[:, :2]).max(axis=1) < REACH_M
        return kinds[near], boxes[near]


def hits_of(points: Array | Array32, boxes: Array) -> NDArray[np.int64]:
    """(m,) points (n, 2) in each box (m, 8), 0.1 m around it and where it was during the turn."""
    hits = np.zeros(len(boxes), dtype=np.int64)
    for row, box in enumerate(boxes):
        cos, sin = math.cos(box[2]), math.sin(box[2])
        apart = points - box[:2]
        along, across = cos * apart[:, 0] + sin * apart[:, 1], -sin * apart[:, 0] + cos * apart[:, 1]
        behind_m = 1e-9 * _TURN_NS * math.hypot(box[6], box[7])
        ahead = along < 0.5 * box[3] + _BESIDE_M
        back = along > -0.5 * box[3] - _BESIDE_M - behind_m
        hits[row] = np.count_nonzero(ahead & back & (np.abs(across) < 0.5 * box[4] + _BESIDE_M))
    return hits


def _small_motion(rng: np.random.Generator) -> Array:
    """(4, 4) some centimetres and about a degree."""
    a, b, c = rng.normal(0.0, 0.02, 3)
    moved: Array = np.eye(4)
    moved[:3, :3] = np.array([[1.0, -c, b], [c, 1.0, -a], [-b, a, 1.0]])
    moved[:3, :3] = np.linalg.qr(moved[:3, :3])[0] * np.sign(np.diag(np.linalg.qr(moved[:3, :3])[1]))
    moved[:3, 3] = rng.normal(0.0, 0.06, 3)
    return moved
