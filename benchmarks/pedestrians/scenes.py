"""Simulated drives among people: what laser and front camera see, and who is really there."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from benchmarks.sensors.drive import Drive, way_over
from contract.geometry import Array, Pose2
from contract.roads.model import RoadMap
from simulator.sensors.cameras.camera import CameraSurroundings, SceneCamera, Shot
from simulator.sensors.cameras.clothed_people import PeopleDresser
from simulator.sensors.cameras.light import Light
from simulator.sensors.cameras.mounts import CameraMount
from simulator.sensors.lidars.mounts import mount
from simulator.sensors.lidars.planar_scanner import PlanarMount, PlanarScan, PlanarScanner
from simulator.sensors.lidars.scanner import MovingBodies
from simulator.sensors.scene.moving_scene import MovingScenes
from simulator.sensors.scene.static_scene import StaticScene
from simulator.traffic.actors import Bodies, no_bodies
from vehicle_agent.config import Body
from vehicle_agent.perception.laser_people.people import LaserPeople, LaserPeopleState
from vehicle_agent.perception.laser_people.verification import RegionScorer
from vehicle_agent.signals import PEDESTRIAN

SCAN_NS = 40_000_000
PICTURE_EVERY = 3
_FLEET_FROM = 1_000_000
# At the height of a hip: legs are two things, and the road's hills are below.
_LASER_M = 0.85
# Of a drive among people.
SECONDS = 2.4


def people_laser(body: Body) -> PlanarMount:
    """A SICK LMS151 of 0.25 degrees at 25 Hz on the front, 180 degrees ahead, as the paper's LMS 291."""
    at = mount(body.front_overhang_m, 0.0, _LASER_M, 0.0)
    return PlanarMount("people", at, math.pi, math.radians(0.25), 25.0, (0.3, 50.0))


@dataclass(frozen=True, slots=True, eq=False)
class Moment:
    """One scan, and every third time a picture; bodies at the scan's end, pose there."""

    stamp_ns: int
    scan: PlanarScan
    pose_map: Pose2
    bodies: Bodies
    shot: Shot | None


def walkers(
    start_map: Pose2, end_map: Pose2, count: int, scene: StaticScene, lens_m: float, rng: np.random.Generator
) -> Bodies:
    """People 9 m to 32 m ahead, a quarter of them standing, whom nothing that stands hides at start and end.

    end_map  pose of the vehicle at the end; lens_m: height of its camera
    """
    rows: list[tuple[float, float, float, float]] = []
    for _ in range(200 * count):
        if len(rows) == count:
            break
        range_m, angle_rad = rng.uniform(9.0, 32.0), start_map.yaw_rad + rng.uniform(-0.38, 0.38)
        yaw_rad = rng.uniform(-math.pi, math.pi)
        speed_mps = 0.0 if rng.random() < 0.25 else rng.uniform(0.6, 1.6)
        x, y = start_map.x_m + range_m * math.cos(angle_rad), start_map.y_m + range_m * math.sin(angle_rad)
        way = SECONDS * speed_mps * np.array([math.cos(yaw_rad), math.sin(yaw_rad)])
        begin, end = np.array([x, y]), np.array([x, y]) + way
        if _is_free(start_map, begin, scene, lens_m) and _is_free(end_map, end, scene, lens_m):
            rows.append((x, y, yaw_rad, speed_mps))
    table = np.array(rows).reshape(-1, 4)
    return Bodies(
        rng.integers(1, 100_000, len(rows)),
        np.full(len(rows), PEDESTRIAN, np.int64),
        table[:, :3],
        table[:, 3:] * np.column_stack((np.cos(table[:, 2]), np.sin(table[:, 2]))),
        np.full((len(rows), 2), 0.5),
    )


def _is_free(pose_map: Pose2, place: Array, scene: StaticScene, lens_m: float) -> bool:
    """Neither the laser's beam nor the camera's view of hip and head meets what stands."""
    ground = scene.ground.height_m(np.array([pose_map.x_m, place[0]]), np.array([pose_map.y_m, place[1]]))
    ways = np.array(
        [
            [place[0] - pose_map.x_m, place[1] - pose_map.y_m, ground[1] + goal_m - ground[0] - from_m]
            for from_m, goal_m in ((_LASER_M, _LASER_M), (lens_m, 0.4), (lens_m, 1.6))
        ]
    )
    lengths = np.linalg.norm(ways, axis=1)
    origins = np.array([[pose_map.x_m, pose_map.y_m, ground[0] + m] for m in (_LASER_M, lens_m, lens_m)])
    _, met = scene.cast(
        origins.astype(np.float32), (ways / lengths[:, None]).astype(np.float32), lengths.astype(np.float32)
    )
    return bool((met < 0).all())


class PeopleDrive:
    """One drive over the campus. The seed determines way, people, clothes and noise."""

    def __init__(
        self,
        road_map: RoadMap,
        scene: StaticScene,
        body: Body,
        camera: CameraMount,
        light: Light,
        seed: int,
        people: int,
        speed_mps: float,
        seconds: float,
        with_pictures: bool = True,
    ) -> None:
        rng = np.random.default_rng([seed, *b"pedestrians"])
        way = way_over(road_map, 20.0 + speed_mps * seconds + 40.0, rng)
        self._drive = Drive(way, scene.ground, speed_mps, body.wheelbase_m)
        self._scenes = MovingScenes(scene.ground, _FLEET_FROM)
        self._dresser = PeopleDresser(scene.ground, seed)
        self.laser = people_laser(body)
        self._scanner = PlanarScanner(self.laser, scene, np.random.default_rng([seed, *b"laser"]))
        self.camera = SceneCamera(camera, scene, seed, light)
        self._start = no_bodies()
        if people:
            lens_m = float(camera.T_base_camera[2, 3])
            self._start = walkers(self._pose(0.0), self._pose(seconds), people, scene, lens_m, rng)
        self._count = round(seconds * 1e9 / SCAN_NS)
        self._with_pictures = with_pictures

    def moments(self) -> Iterator[Moment]:
        """All scans of the drive, in order."""
        for number in range(1, self._count + 1):
            begin_ns, end_ns = (number - 1) * SCAN_NS, number * SCAN_NS
            bodies = self._bodies(end_ns * 1e-9)
            moving = MovingBodies(end_ns, self._scenes.of(bodies))
            scan = self._scanner.scan(self._drive.poses, begin_ns, (moving,))
            shot = self._shot(bodies, end_ns) if number % PICTURE_EVERY == 0 and self._with_pictures else None
            yield Moment(end_ns, scan, self._pose(end_ns * 1e-9), bodies, shot)

    def _shot(self, bodies: Bodies, stamp_ns: int) -> Shot:
        around = CameraSurroundings(
            self._dresser.of(bodies), self._scenes.of(bodies.selected(~bodies.people))
        )
        T_map_base = self._drive.poses(np.array([stamp_ns]))[0]
        return self.camera.take(T_map_base, stamp_ns, around)

    def _pose(self, time_s: float) -> Pose2:
        x_m, y_m, yaw_rad = self._drive.pose(time_s).tolist()
        return Pose2(x_m, y_m, yaw_rad)

    def _bodies(self, time_s: float) -> Bodies:
        start = self._start
        poses: Array = start.poses_map.copy()
        poses[:, :2] += time_s * start.velocities_map_mps
        return Bodies(start.numbers, start.kinds, poses, start.velocities_map_mps, start.sizes_m)


def states_of(
    drive: PeopleDrive, room: LaserPeople, scorer: RegionScorer | None
) -> Iterator[tuple[Moment, LaserPeopleState]]:
    """Each moment of a drive, and what the room knows after it; scorer None: pictures are left out."""
    state = LaserPeopleState()
    for moment in drive.moments():
        scan, pose_map = moment.scan, moment.pose_map
        state = room.after_scan(
            state, scan.ranges_m, scan.angles_rad, drive.laser.T_base_sensor, pose_map, moment.stamp_ns
        )
        if moment.shot is not None and scorer is not None:
            state = room.after_picture(state, moment.shot.picture, drive.camera.model, pose_map, scorer)
        yield moment, state
