"""Everything outside the vehicles' computers: bodies, by-wire, sensors, people, doors and the score.

One `step` is 20 ms of world time and the world reads no clock, so the same world runs in virtual time under
the conductor and in real time in `campusloop simulate`.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from contract.geometry import Array, Pose2
from contract.roads.model import RoadMap
from contract.roads.network import RoadNetwork
from contract.roads.walls import wall_edges
from simulator.chargers import Chargers
from simulator.ecus.bus_faults import BusFaults
from simulator.ecus.module import Module
from simulator.fleet import STEP_NS, SimFleet
from simulator.riders import Phone, Riders
from simulator.scoring.metrics import Scorekeeper, VehicleScore
from simulator.sensors.gnss import CampusReceiver, GnssNoise, GnssReceiver
from simulator.sensors.imu import Imu, ImuNoise
from simulator.sensors.lidar import Lidar, LidarNoise
from simulator.sensors.ray_hits import BOX_COLUMNS, Array32
from simulator.sensors.scene.changes import SceneError
from simulator.sensors.scene_lidars import SceneLidars, SceneOptions
from simulator.sensors.sky import Sky
from simulator.sensors.tracker import Tracker, TrackerNoise
from simulator.sensors.walls import WallScene
from simulator.traffic.actors import Actors, Bodies, no_bodies, together
from simulator.traffic.corridor import SAMPLES, Corridor
from simulator.traffic.crowd import V_FRONT, V_HALF, V_REAR, V_SPEED, V_X, V_Y, V_YAW, VEHICLE_COLUMNS
from simulator.traffic.pedestrians import Pedestrians
from simulator.traffic.population import TrafficParams
from simulator.vehicle.doors import Display, Doors
from simulator.vehicle.plant import PlantParams, PlantView
from simulator.vehicle.random_plant import random_plant
from vehicle_agent.config import Profile
from vehicle_agent.signals import VEHICLE, CanFrame, HmiOutput, InboxBody, TrackPercept
from vehicle_agent.signals.pictures import Picture

# A tracker's numbers of fleet vehicles start here; people and other traffic have lower ones.
FLEET_NUMBERS_FROM = 1_000_000


class WorldError(Exception):
    """The world cannot be set up; the message says what to change."""


@dataclass(frozen=True, slots=True)
class WorldOptions:
    """traffic None: no pedestrians. lidar False: no scans. `plants`: dynamics of some vehicles, by id.

    actors   road users in place of `traffic`
    tracker  noise of the trackers, for vehicles whose stack tracks road users
    plant_seed  of the dynamics of vehicles that `plants` does not name (`random_plant`); None: nominal ones
    campus_sky  buildings hide satellites and reflect their signals (`sensors/sky.py`)
    scene       hills, kerbs, facades, trees and parked vehicles for lidars that move while they scan
                (`sensors/scene_lidars.py`); None: walls of the map on a plane, each scan at one instant
    """

    traffic: TrafficParams | None = field(default_factory=TrafficParams)
    lidar: bool = True
    gnss: GnssNoise = field(default_factory=GnssNoise)
    imu: ImuNoise = field(default_factory=ImuNoise)
    lidar_noise: LidarNoise = field(default_factory=LidarNoise)
    plants: dict[str, PlantParams] = field(default_factory=dict)
    actors: Actors | None = None
    tracker: TrackerNoise = field(default_factory=TrackerNoise)
    plant_seed: int | None = None
    campus_sky: bool = False
    scene: SceneOptions | None = None

    def plants_of(self, profiles: dict[str, Profile]) -> dict[str, PlantParams]:
        """The dynamics that are not the nominal ones of the vehicle's profile."""
        if self.plant_seed is None:
            return self.plants
        drawn = {v: random_plant(profile, self.plant_seed, v) for v, profile in profiles.items()}
        return drawn | self.plants


class SimWorld:
    """The vehicles of `profiles`, placed at `poses_map` on a map; the seed determines all randomness."""

    def __init__(
        self,
        road_map: RoadMap,
        profiles: dict[str, Profile],
        poses_map: dict[str, Pose2],
        seed: int,
        phone: Phone,
        options: WorldOptions | None = None,
    ) -> None:
        """Raises WorldError without vehicles, if a vehicle has no start pose, or a scene cannot be built."""
        if not profiles:
            raise WorldError("a world needs at least one vehicle")
        missing = [v for v in profiles if v not in poses_map]
        if missing:
            raise WorldError(f"give a start pose for {', '.join(missing)}")
        self.options = options or WorldOptions()
        self.vehicle_ids = tuple(profiles)
        self._seed = seed
        self._profiles = profiles
        self._number = {v: i for i, v in enumerate(profiles)}
        self.fleet = SimFleet(profiles, poses_map, self.options.plants_of(profiles))
        self.scene_lidars = self._scene_lidars(road_map)
        # The world's buildings; the map knows nothing of what has changed.
        self._buildings = (
            road_map.buildings if self.scene_lidars is None else self.scene_lidars.scene.buildings
        )
        network = RoadNetwork(road_map)
        self._chargers = Chargers(network)
        self._corridors = [Corridor(network) for _ in profiles]
        self._vehicles: Array = np.zeros((len(profiles), VEHICLE_COLUMNS))
        self._ahead: Array = np.zeros((len(profiles), SAMPLES, 2))
        self._score = Scorekeeper(self.vehicle_ids, self._buildings)
        self.pedestrians = (
            Pedestrians(self.options.traffic, self._rng("traffic"), len(profiles))
            if self.options.traffic and self.options.actors is None
            else None
        )
        self.actors: Actors | None = self.options.actors or self.pedestrians
        self.riders = Riders(self.vehicle_ids, phone, self._rng("riders"))
        self.doors = {v: Doors() for v in profiles}
        self.displays = {v: Display() for v in profiles}
        self._set_up_sensors(road_map)
        self._update_views()

    def _set_up_sensors(self, road_map: RoadMap) -> None:
        options, profiles = self.options, self._profiles
        self.gnss = self._receivers(road_map)
        # On hills an accelerometer measures the slope, too.
        imu = options.imu if self.scene_lidars is None else replace(options.imu, gravity=True)
        self._imus = {v: Imu(imu, self._rng(f"imu {v}")) for v in profiles}
        self._lidars: dict[str, Lidar] = {}
        if options.lidar and self.scene_lidars is None:
            walls = WallScene(self._buildings)
            self._lidars = {
                v: Lidar(profile.lidar, profile.body, walls, options.lidar_noise)
                for v, profile in profiles.items()
            }
        edges = wall_edges(self._buildings)
        self.trackers = {
            v: Tracker(options.tracker, edges, profile.lidar.x_m, self._rng(f"tracker {v}"))
            for v, profile in profiles.items()
            if profile.has_tracker
        }
        self._lidar_rngs = {v: self._rng(f"lidar {v}") for v in profiles}
        self._scan_due_ns: dict[str, int] = {}

    def _scene_lidars(self, road_map: RoadMap) -> SceneLidars | None:
        options = self.options
        if options.scene is None or not options.lidar:
            return None
        try:
            return SceneLidars(road_map, self._profiles, options.scene, FLEET_NUMBERS_FROM)
        except SceneError as error:
            raise WorldError(f"the scene cannot be built: {error}") from error

    def _receivers(self, road_map: RoadMap) -> dict[str, GnssReceiver]:
        origin, noise = road_map.origin, self.options.gnss
        rngs = {v: self._rng(f"gnss {v}") for v in self._profiles}
        if not self.options.campus_sky:
            return {v: GnssReceiver(origin, noise, rng) for v, rng in rngs.items()}
        sky = Sky(self._buildings, self._rng("sky"))
        return {v: CampusReceiver(origin, noise, sky, rng) for v, rng in rngs.items()}

    def _rng(self, name: str) -> np.random.Generator:
        """A separate stream for each purpose; a new consumer does not change the others."""
        return np.random.default_rng([self._seed, *name.encode()])

    # what a vehicle computer is wired to

    def frames_to_vehicle(self, vehicle_id: str) -> tuple[CanFrame, ...]:
        """By-wire reports since the last call."""
        return self.fleet.frames_to_vehicle(vehicle_id)

    def frames_from_vehicle(self, vehicle_id: str, frames: tuple[CanFrame, ...]) -> None:
        """Send command frames; each is received in the step that covers its stamp."""
        self.fleet.frames_from_vehicle(vehicle_id, frames)

    def sensor_items(self, vehicle_id: str, now_ns: int) -> list[InboxBody]:
        """GNSS, inertial, door and cabin items of this tick; call once a tick for each vehicle."""
        truth = self.truth(vehicle_id)
        items: list[InboxBody] = []
        fix = self.gnss[vehicle_id].fix(now_ns, truth)
        if fix is not None:
            items.append(fix)
        items.append(self._imus[vehicle_id].sample(now_ns, truth))
        doors = self.doors[vehicle_id]
        state = doors.step(now_ns, truth.speed_mps)
        if state is not None:
            items.append(state)
        items.extend(self.riders.step(now_ns, vehicle_id, truth.pose_map, doors.is_open))
        return items

    def scan(self, vehicle_id: str, now_ns: int) -> tuple[Array32, Array32] | None:
        """A lidar scan if one is due: points (n, 3) base frame and intensities (n,), float32.

        Vehicles scan in turn, one 20 ms step apart, so that no step carries all scans.
        """
        if self.scene_lidars is not None:
            others, truth = self.road_users_of(vehicle_id), self.truth(vehicle_id)
            is_due = self._is_scan_due(vehicle_id, now_ns)
            return self.scene_lidars.scan(vehicle_id, now_ns, is_due, truth, others)
        lidar = self._lidars.get(vehicle_id)
        if lidar is None or not self._is_scan_due(vehicle_id, now_ns):
            return None
        moving = self.bodies()
        boxes = np.vstack((np.delete(self._boxes(), self._number[vehicle_id], axis=0), moving.boxes()))
        pose_map, rng = self.truth(vehicle_id).pose_map, self._lidar_rngs[vehicle_id]
        return lidar.scan(pose_map, boxes, moving.cylinders(), rng)

    def planar_scan(self, vehicle_id: str, now_ns: int) -> tuple[Array32, Array32] | None:
        """A scan of the vehicle's planar scanner if one is due, as `scan` gives it; only in a scene."""
        if self.scene_lidars is None or self._profiles[vehicle_id].planar_scanner.rate_hz <= 0.0:
            return None
        others, truth = self.road_users_of(vehicle_id), self.truth(vehicle_id)
        return self.scene_lidars.planar_scan(vehicle_id, now_ns, truth, others)

    def people_scan(self, vehicle_id: str, now_ns: int) -> tuple[Array32, Array32] | None:
        """A scan of the planar scanner for people if one is due, as `scan` gives it; only in a scene."""
        if self.scene_lidars is None:
            return None
        others, truth = self.road_users_of(vehicle_id), self.truth(vehicle_id)
        return self.scene_lidars.people_scan(vehicle_id, now_ns, truth, others)

    def picture(
        self, vehicle_id: str, now_ns: int, windows: Callable[[], NDArray[np.int64] | None]
    ) -> Picture | None:
        """The picture of now, if one is due and `windows` are wanted of it; only in a scene."""
        if self.scene_lidars is None:
            return None
        others, truth = self.road_users_of(vehicle_id), self.truth(vehicle_id)
        return self.scene_lidars.picture(vehicle_id, now_ns, truth, others, windows)

    def _is_scan_due(self, vehicle_id: str, now_ns: int) -> bool:
        rate_hz = self._profiles[vehicle_id].lidar.rate_hz
        if rate_hz <= 0.0:
            return False
        period_ns = round(1e9 / rate_hz)
        due_ns = self._scan_due_ns.get(vehicle_id, now_ns + self._number[vehicle_id] * STEP_NS % period_ns)
        if now_ns < due_ns:
            self._scan_due_ns[vehicle_id] = due_ns
            return False
        self._scan_due_ns[vehicle_id] = due_ns + period_ns
        return True

    def tracked(self, vehicle_id: str, now_ns: int) -> list[TrackPercept]:
        """Answers of the vehicle's tracker that are due; call once a tick for each vehicle."""
        tracker = self.trackers.get(vehicle_id)
        if tracker is None:
            return []
        return tracker.percepts(now_ns, self.truth(vehicle_id).pose_map, self.road_users_of(vehicle_id))

    def road_users_of(self, vehicle_id: str) -> Bodies:
        """All road users around a vehicle, the other vehicles of this world among them."""
        others = np.delete(np.arange(len(self.vehicle_ids)), self._number[vehicle_id])
        return together(self.bodies(), self._fleet_bodies(others))

    def all_bodies(self) -> Bodies:
        """All road users, the vehicles of this world among them."""
        return together(self.bodies(), self._fleet_bodies(np.arange(len(self.vehicle_ids))))

    def bodies(self) -> Bodies:
        """All road users except the vehicles of this world."""
        return self.actors.bodies() if self.actors else no_bodies()

    def _fleet_bodies(self, numbers: np.ndarray) -> Bodies:
        rows = self._vehicles[numbers]
        headings = np.column_stack((np.cos(rows[:, V_YAW]), np.sin(rows[:, V_YAW])))
        middle_m = 0.5 * (rows[:, V_FRONT] - rows[:, V_REAR])
        poses = rows[:, [V_X, V_Y, V_YAW]].copy()
        poses[:, :2] += middle_m[:, None] * headings
        return Bodies(
            FLEET_NUMBERS_FROM + numbers.astype(np.int64),
            np.full(len(numbers), VEHICLE, np.int64),
            poses,
            rows[:, V_SPEED, None] * headings,
            np.column_stack((rows[:, V_FRONT] + rows[:, V_REAR], 2.0 * rows[:, V_HALF])),
        )

    def show(self, vehicle_id: str, output: HmiOutput, now_ns: int) -> None:
        """Pass the vehicle's HMI output to its screen, speaker and doors."""
        self.displays[vehicle_id].show(output, now_ns)
        self.doors[vehicle_id].command(output.doors_open, now_ns)

    # time

    def step(self, now_ns: int) -> None:
        """Advance the world from now_ns to now_ns + 20 ms."""
        if self.scene_lidars is not None:
            for vehicle_id, number in self._number.items():
                self.fleet.plant.grades[number] = self.scene_lidars.grade_ratio(
                    self.truth(vehicle_id).pose_map, self._profiles[vehicle_id].body.wheelbase_m
                )
        self.fleet.step(now_ns)
        self._update_views()
        places_map, speeds_mps = self._vehicles[:, V_X:V_YAW], self._vehicles[:, V_SPEED]
        self.fleet.plant.charging_w[:] = self._chargers.power_w(places_map, speeds_mps)
        dt_s = STEP_NS * 1e-9
        odometers_m = np.array([self.truth(v).odometer_m for v in self.vehicle_ids])
        if self.actors:
            self.actors.step(self._vehicles, odometers_m, self._ahead, dt_s)
        moving = self.bodies()
        places, numbers = moving.poses_map[moving.people, :2], moving.numbers[moving.people]
        views = [self.truth(v) for v in self.vehicle_ids]
        self._score.step(now_ns + STEP_NS, dt_s, views, self._vehicles, self._ahead, places, numbers)

    def _update_views(self) -> None:
        """Update the arrays of vehicles for people and score."""
        for i, vehicle_id in enumerate(self.vehicle_ids):
            view, body = self.truth(vehicle_id), self._profiles[vehicle_id].body
            pose = view.pose_map
            self._vehicles[i] = (
                pose.x_m, pose.y_m, pose.yaw_rad, body.rear_overhang_m, body.front_overhang_m,
                0.5 * body.width_m, view.speed_mps,
            )  # fmt: skip
            self._corridors[i].update(pose)
            self._ahead[i] = self._corridors[i].ahead

    def _boxes(self) -> Array:
        boxes = np.empty((len(self.vehicle_ids), BOX_COLUMNS))
        boxes[:, : V_SPEED - V_X] = self._vehicles[:, V_X:V_SPEED]
        boxes[:, BOX_COLUMNS - 1] = [self._profiles[v].body.height_m for v in self.vehicle_ids]
        return boxes

    # ground truth and scenario

    def truth(self, vehicle_id: str) -> PlantView:
        """The vehicle's true motion."""
        return self.fleet.truth(vehicle_id)

    def score(self, vehicle_id: str) -> VehicleScore:
        return self._score.scores[vehicle_id]

    def module(self, vehicle_id: str) -> Module:
        """The by-wire module, to inject a safety driver's input, a fault or the stop button."""
        return self.fleet.modules[vehicle_id]

    def bus_faults(self, vehicle_id: str) -> BusFaults:
        """The faults of the vehicle's bus; the caller may change them."""
        return self.fleet.buses[vehicle_id].faults

    def follow(self, vehicle_id: str, points_map: Array) -> None:
        """Set the vehicle's route (n, 2) for people and score; without one they use the lanes ahead."""
        self._corridors[self._number[vehicle_id]].follow(points_map)

    def place(self, vehicle_id: str, pose_map: Pose2, speed_mps: float = 0.0) -> None:
        """Place a vehicle, at rest or with a speed."""
        self.fleet.place(vehicle_id, pose_map, speed_mps)
        self._update_views()

    def people_near(self, vehicle_id: str, within_m: float) -> Array:
        """(n, 2) places of people around a vehicle."""
        moving = self.bodies()
        places: Array = moving.poses_map[moving.people, :2]
        offsets = places - self._vehicles[self._number[vehicle_id], V_X:V_YAW]
        near: Array = places[np.hypot(offsets[:, 0], offsets[:, 1]) <= within_m]
        return near
