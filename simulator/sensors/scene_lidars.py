"""The lidars of all vehicles of a world in its common scene, tick by tick."""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from contract.geometry import Pose2
from contract.roads.model import RoadMap
from simulator.sensors.cameras.light import OVERCAST, Light
from simulator.sensors.lidars.driver import moved_to_end
from simulator.sensors.lidars.faults import FaultyLidar, FaultyPlanarScanner
from simulator.sensors.lidars.firings import Array32
from simulator.sensors.lidars.mounts import lidars_of
from simulator.sensors.lidars.scanner import MovingBodies
from simulator.sensors.lidars.spinning_lidar import LidarScan, SpinningLidar
from simulator.sensors.scene.changes import WorldChanges
from simulator.sensors.scene.ground import GroundParams
from simulator.sensors.scene.moving_scene import MovingScenes
from simulator.sensors.scene.shapes import shuttle
from simulator.sensors.scene.static_scene import CastScene, StaticScene
from simulator.sensors.scene_people import VehiclePeopleSensors
from simulator.sensors.scene_planar import VehiclePlanarScanner
from simulator.traffic.actors import Bodies
from simulator.vehicle.plant import PlantView
from vehicle_agent.config import Profile
from vehicle_agent.signals.pictures import Picture

# Bodies farther away give no return that counts.
_NEAR_M = 70.0
# What wheels and gyroscope add to the motion by which the driver puts a turn's points together.
_SPEED_STD_MPS, _YAW_RATE_STD_RADPS = 0.02, 0.003


@dataclass(frozen=True, slots=True)
class SceneOptions:
    """The surroundings of a world, for lidars that see them.

    seed      of what is permanent: facades, trees, hills; the same campus for all runs
    four      four XT16 on each vehicle; otherwise only on those of the Snow Lion stack that find road users
              by themselves: people 2 m beside the vehicle are below the rings of one on the roof. Others have
              the VLP-16 of their profile
    is_furnished  trees, posts and parked vehicles beside the roads
    light     of the pictures of vehicles that look for people
    """

    seed: int = 1
    changes: WorldChanges = field(default_factory=WorldChanges)
    ground: GroundParams = field(default_factory=GroundParams)
    four: bool = False
    rain_mm_per_h: float = 0.0
    is_furnished: bool = True
    light: Light = OVERCAST


def open_square(seed: int) -> SceneOptions:
    """Flat ground and buildings alone: recorded people walk where trees and posts would stand."""
    level = GroundParams(grade_ratio=0.0, kerb_m=0.0, lowered_kerb_m=0.0)
    return SceneOptions(seed=seed, ground=level, is_furnished=False)


def scene_of_run(seed: int) -> SceneOptions:
    """The campus of every run, in which the run's seed parks the vehicles."""
    return SceneOptions(changes=WorldChanges(seed=seed))


def _sees_around(profile: Profile) -> bool:
    return profile.stack == "snow_lion" and profile.perception == "own"


class SceneLidars:
    """One static scene, and the sensors of each vehicle. `faults` by vehicle: each sensor's may be set.

    light  of all pictures
    """

    def __init__(
        self, road_map: RoadMap, profiles: dict[str, Profile], options: SceneOptions, fleet_numbers_from: int
    ) -> None:
        """Raises SceneError for a map without lanes."""
        self.scene = StaticScene(
            road_map, options.seed, options.changes, options.ground, is_furnished=options.is_furnished
        )
        self.light = options.light
        self._scenes = MovingScenes(self.scene.ground, fleet_numbers_from)
        self._vehicles: dict[str, _VehicleLidars] = {}
        self._planar: dict[str, VehiclePlanarScanner] = {}
        self._people: dict[str, VehiclePeopleSensors] = {}
        for vehicle_id, profile in profiles.items():
            if profile.lidar.rate_hz > 0.0:
                rng = np.random.default_rng([options.seed, *f"scene lidars {vehicle_id}".encode()])
                self._vehicles[vehicle_id] = _VehicleLidars(self.scene, profile, options, rng)
            if profile.planar_scanner.rate_hz > 0.0:
                rng = np.random.default_rng([options.seed, *f"planar scanner {vehicle_id}".encode()])
                planar = VehiclePlanarScanner(self.scene, profile, rng, options.rain_mm_per_h)
                self._planar[vehicle_id] = planar
            if profile.perception == "own" and profile.people_scanner.rate_hz > 0.0:
                rng = np.random.default_rng([options.seed, *f"people sensors {vehicle_id}".encode()])
                self._people[vehicle_id] = VehiclePeopleSensors(
                    self.scene, profile, rng, self._scenes, options.light, options.rain_mm_per_h
                )

    def faults(self, vehicle_id: str) -> tuple[FaultyLidar, ...]:
        """The vehicle's sensors, in the order of `lidars_of`."""
        return self._vehicles[vehicle_id].lidars

    def planar_scanner(self, vehicle_id: str) -> FaultyPlanarScanner:
        """The vehicle's planar scanner, whose fault may be set."""
        return self._planar[vehicle_id].scanner

    def planar_scan(
        self, vehicle_id: str, now_ns: int, truth: PlantView, others: Bodies
    ) -> tuple[Array32, Array32] | None:
        """Points (n, 3) base frame at now_ns, intensities (n,) of the planar scanner's turn, if one is due.

        Call it in every step.
        """
        planar = self._planar.get(vehicle_id)
        if planar is None:
            return None
        return planar.step(now_ns, truth, lambda: self._moving(now_ns, truth, others))

    def people_scan(
        self, vehicle_id: str, now_ns: int, truth: PlantView, others: Bodies
    ) -> tuple[Array32, Array32] | None:
        """As `planar_scan`, of the scanner for people: only a vehicle that looks for them itself uses it."""
        sensors = self._people.get(vehicle_id)
        if sensors is None:
            return None
        return sensors.scan(now_ns, truth, lambda: self._moving(now_ns, truth, others))

    def picture(
        self,
        vehicle_id: str,
        now_ns: int,
        truth: PlantView,
        others: Bodies,
        windows: Callable[[], NDArray[np.int64] | None],
    ) -> Picture | None:
        """The picture of now, if one is due and wanted (`VehiclePeopleSensors.picture`)."""
        sensors = self._people.get(vehicle_id)
        return None if sensors is None else sensors.picture(now_ns, truth, others, windows)

    def _moving(self, now_ns: int, truth: PlantView, others: Bodies) -> MovingBodies:
        apart = np.hypot(
            others.poses_map[:, 0] - truth.pose_map.x_m, others.poses_map[:, 1] - truth.pose_map.y_m
        )
        return MovingBodies(now_ns, self._scenes.of(others.selected(apart < _NEAR_M)))

    def grade_ratio(self, pose_map: Pose2, wheelbase_m: float) -> float:
        """Slope of the road under a vehicle, uphill positive."""
        row = np.array([[pose_map.x_m, pose_map.y_m, pose_map.yaw_rad]])
        ahead = self.scene.ground.poses(row, wheelbase_m)[0, :3, 0]
        return float(ahead[2] / np.hypot(ahead[0], ahead[1]))

    def scan(
        self, vehicle_id: str, now_ns: int, due: bool, truth: PlantView, others: Bodies
    ) -> tuple[Array32, Array32] | None:
        """Points (n, 3) base frame at now_ns and intensities (n,) of the turn that ends now, if `due`.

        Call it in every step: it remembers where the vehicle and the others were during the turn.
        """
        vehicle = self._vehicles.get(vehicle_id)
        if vehicle is None:
            return None
        return vehicle.step(now_ns, due, truth, self._moving(now_ns, truth, others))


class _VehicleLidars:
    """One vehicle's sensors, and its way during the present turn."""

    def __init__(
        self, scene: StaticScene, profile: Profile, options: SceneOptions, rng: np.random.Generator
    ) -> None:
        body = profile.body
        own = CastScene(shuttle(body.length_m, body.width_m, body.height_m, body.rear_overhang_m))
        self._period_ns = round(1e9 / profile.lidar.rate_hz)
        self._ground, self._wheelbase_m, self._rng = scene.ground, body.wheelbase_m, rng
        self.lidars = tuple(
            FaultyLidar(
                SpinningLidar(
                    mounted, scene, np.random.default_rng(rng.integers(1 << 62)), own, options.rain_mm_per_h
                )
            )
            for mounted in lidars_of(profile, options.four or _sees_around(profile))
        )
        self._poses: deque[tuple[int, float, float, float]] = deque()
        self._moving: deque[MovingBodies] = deque()

    def step(
        self, now_ns: int, due: bool, truth: PlantView, moving: MovingBodies
    ) -> tuple[Array32, Array32] | None:
        pose = truth.pose_map
        self._poses.append((now_ns, pose.x_m, pose.y_m, pose.yaw_rad))
        self._moving.append(moving)
        begin_ns = now_ns - self._period_ns
        # One pose before the turn's begin stays, to start from.
        while len(self._poses) > 1 and self._poses[1][0] <= begin_ns:
            self._poses.popleft()
        while self._moving[0].until_ns <= begin_ns:
            self._moving.popleft()
        if not due or self._poses[0][0] > begin_ns:
            return None
        scans = [lidar.scan(self._trajectory, begin_ns, self._moving) for lidar in self.lidars]
        return self._joined([scan for scan in scans if scan is not None], truth)

    def _trajectory(self, times_ns: np.ndarray) -> np.ndarray:
        rows = np.array([row[1:] for row in self._poses])
        known_ns = np.array([row[0] for row in self._poses], dtype=np.float64)
        rows[:, 2] = np.unwrap(rows[:, 2])
        places = np.column_stack([np.interp(times_ns, known_ns, column) for column in rows.T])
        return self._ground.poses(places, self._wheelbase_m)

    def _joined(self, scans: list[LidarScan], truth: PlantView) -> tuple[Array32, Array32] | None:
        """None if all sensors are dead."""
        if not scans:
            return None
        speed, yaw_rate = self._rng.standard_normal(2).tolist()
        speed = truth.speed_mps * truth.wheel_ratio + _SPEED_STD_MPS * speed * (truth.speed_mps != 0.0)
        yaw_rate = truth.yaw_rate_radps + _YAW_RATE_STD_RADPS * yaw_rate
        parts = [
            moved_to_end(scan.points_base, scan.cloud.offsets_ns, self._period_ns, speed, yaw_rate)
            for scan in scans
        ]
        return np.concatenate(parts), np.concatenate([scan.cloud.intensities for scan in scans])
