"""Compiles every kernel of the simulator into numba's cache."""

import numpy as np

from contract.geometry import Pose2, wrap_angle
from contract.roads.model import Building, Lane, Origin, RoadMap
from contract.roads.network import RoadNetwork
from simulator.scoring.metrics import relations
from simulator.sensors.cameras.camera import CameraSurroundings, SceneCamera
from simulator.sensors.cameras.clothed_people import PeopleDresser
from simulator.sensors.cameras.mounts import CameraMount
from simulator.sensors.lidar import Lidar
from simulator.sensors.lidars.driver import moved_to_end
from simulator.sensors.lidars.mounts import roof_lidar
from simulator.sensors.lidars.spinning_lidar import SpinningLidar
from simulator.sensors.scene.changes import WorldChanges
from simulator.sensors.scene.moving_scene import MovingScenes
from simulator.sensors.scene.static_scene import StaticScene
from simulator.sensors.walls import WallScene
from simulator.traffic.actors import no_bodies
from simulator.traffic.corridor import SAMPLES, Corridor
from simulator.traffic.crowd import VEHICLE_COLUMNS, step_crowd
from simulator.traffic.outlines import outline_meets_edges, outlines_overlap
from simulator.traffic.population import Population, TrafficParams
from simulator.vehicle.plant import COMMAND_SIZE, Plant, PlantParams
from vehicle_agent.config import Body, LidarMount
from vehicle_agent.signals.pictures import optical_pose


def warm_kernels() -> None:
    """Call each kernel once with small arguments of the types it is used with."""
    here = Pose2(0.0, 0.0, 0.0)
    plant = Plant((PlantParams(),), (here,))
    plant.step(0.02)
    assert plant.commands.shape == (1, COMMAND_SIZE)
    wrap_angle(4.0)
    rng = np.random.default_rng(0)
    walls = WallScene((Building(((30.0, -5.0), (30.0, 5.0), (40.0, 0.0)), 9.0),))
    boxes = np.array([[10.0, 0.0, 0.0, 0.85, 3.5, 0.8, 2.2]])
    Lidar(LidarMount(), Body(), walls).scan(here, boxes, np.array([[8.0, 0.0, 0.25, 1.7]]), rng)
    lane = Lane("lane", "road", ((0.0, 0.0), (1.0, 0.0), (2.0, 0.0)), 4.0, 4.0, False, ())
    road_map = RoadMap("warm", "warm", Origin(0.0, 0.0), (lane,), (), (), ())
    _warm_scene(road_map, rng)
    corridor = Corridor(RoadNetwork(road_map))
    corridor.update(here)
    corridor.follow(np.array([[0.0, 0.0], [50.0, 0.0]]))
    corridor.update(here)
    ahead = np.zeros((1, SAMPLES, 2))
    ahead[0] = corridor.ahead
    vehicles = np.zeros((1, VEHICLE_COLUMNS))
    crowd = Population(TrafficParams(), rng)
    crowd.add_crosser(ahead[0], 10.0, 0.8)
    step_crowd(crowd.people, crowd.activity, crowd.ways, crowd.way, vehicles, ahead, 8.0, 0.02)
    relations(vehicles[0], ahead[0], crowd.people[:, :2].copy())
    outlines_overlap(vehicles[0], vehicles[0])
    outline_meets_edges(vehicles[0], np.zeros((1, 4)))


def _warm_scene(road_map: RoadMap, rng: np.random.Generator) -> None:
    scene = StaticScene(road_map, 1, WorldChanges(parked_ratio=0.0))
    scan = SpinningLidar(roof_lidar(Body()), scene, rng).scan(lambda t: np.tile(np.eye(4), (len(t), 1, 1)), 0)
    moved_to_end(scan.points_base, scan.cloud.offsets_ns, 100_000_000, 1.0, 0.1)
    around = CameraSurroundings(
        PeopleDresser(scene.ground).of(no_bodies()), MovingScenes(scene.ground, 1).of(no_bodies())
    )
    camera = SceneCamera(CameraMount("warm", optical_pose(0.0, 0.0, 2.0, 0.0), 32, 32), scene, 1)
    camera.take(np.eye(4), 0, around)
