"""A simulated street with a person, a cyclist and a car, as four lidars of a standing vehicle see it."""

from functools import cache

import numpy as np

from contract.geometry import Pose2
from simulator.sensors.lidars.driver import moved_to_end
from simulator.sensors.lidars.mounts import four_lidars
from simulator.sensors.lidars.scanner import MovingBodies
from simulator.sensors.lidars.spinning_lidar import SpinningLidar
from simulator.sensors.scene.changes import WorldChanges
from simulator.sensors.scene.moving_scene import MovingScenes
from simulator.sensors.scene.static_scene import StaticScene
from simulator.traffic.actors import Bodies
from vehicle_agent.config import Body
from vehicle_agent.perception.pillars.sweeps import OLDER_NS, Sweep
from vehicle_agent.signals import CYCLIST, PEDESTRIAN, VEHICLE
from vehicle_agent.stacks.warm import straight_road

TURN_NS = 100_000_000
KINDS = np.array([PEDESTRIAN, CYCLIST, VEHICLE, VEHICLE])
# At the newer turn's end, in the frame of the vehicle, which stands at (30, 0) of the map.
POSES = np.array([[9.0, 3.0, -1.5], [14.0, -2.5, 0.0], [20.0, 1.0, 3.1], [-8.0, -3.0, 0.05]])
SPEEDS_MPS = np.array([1.3, 3.5, 2.0, 0.0])
SIZES_M = np.array([[0.5, 0.5], [1.75, 0.6], [4.4, 1.8], [4.4, 1.8]])
_PLACE_M = np.array([30.0, 0.0, 0.0])


@cache
def street(parked_ratio: float = 0.0) -> StaticScene:
    return StaticScene(straight_road(), 3, WorldChanges(parked_ratio=parked_ratio))


def turns(scene: StaticScene) -> tuple[Sweep, Sweep]:
    """(older, newer) turn, 0.2 s apart."""
    sensors = [
        SpinningLidar(mounted, scene, np.random.default_rng([5, number]))
        for number, mounted in enumerate(four_lidars(Body()))
    ]
    bodies = MovingScenes(scene.ground, 1_000_000)
    base = scene.ground.poses(_PLACE_M[None])
    sweeps = []
    for end_ns in (TURN_NS, TURN_NS + OLDER_NS):
        begin_ns, moving = end_ns - TURN_NS, []
        for until_ns in range(begin_ns + 20_000_000, end_ns + 1, 20_000_000):
            ago_s = (TURN_NS + OLDER_NS - until_ns) * 1e-9
            moving.append(MovingBodies(until_ns, bodies.of(_users(ago_s))))
        scans = [
            sensor.scan(lambda times: np.repeat(base, len(times), axis=0), begin_ns, moving)
            for sensor in sensors
        ]
        points = [moved_to_end(s.points_base, s.cloud.offsets_ns, TURN_NS, 0.0, 0.0) for s in scans]
        intensities = np.concatenate([s.cloud.intensities for s in scans])
        sweeps.append(Sweep(end_ns, Pose2(0.0, 0.0, 0.0), np.concatenate(points), intensities))
    return sweeps[0], sweeps[1]


def velocities_mps() -> np.ndarray:
    return SPEEDS_MPS[:, None] * np.column_stack((np.cos(POSES[:, 2]), np.sin(POSES[:, 2])))


def _users(ago_s: float) -> Bodies:
    poses = POSES + _PLACE_M
    poses[:, :2] -= ago_s * velocities_mps()
    return Bodies(np.arange(4), KINDS, poses, velocities_mps(), SIZES_M)
