"""Bare ground with a wall, and simple drives over it."""

import numpy as np

from contract.geometry import Array
from contract.roads.model import Building
from simulator.sensors.lidars.scanner import Trajectory
from simulator.sensors.scene.changes import WorldChanges
from simulator.sensors.scene.ground import GroundParams
from simulator.sensors.scene.static_scene import StaticScene
from tests.simulator.sensors.scene.campus import a_street

FLAT = GroundParams(0.0, 0.0, 3.5, 0.0, 0.0)
WALL = Building(((52.0, -300.0), (53.0, -300.0), (53.0, 300.0), (52.0, 300.0)), 2.9)


def bare_scene(*buildings: Building) -> StaticScene:
    """Flat ground without furniture but for these buildings; low ones have no windows."""
    return StaticScene(a_street(8, buildings), 1, WorldChanges(parked_ratio=0.0, sway_m=0.0), FLAT)


def moving(speed_mps: float, yaw_rate_radps: float = 0.0, x_m: float = 40.0) -> Trajectory:
    """T_map_base of a straight drive over flat ground that turns on the spot."""

    def poses(times_ns: np.ndarray) -> Array:
        t = times_ns * 1e-9
        yaw = yaw_rate_radps * t
        found: Array = np.tile(np.eye(4), (len(t), 1, 1))
        found[:, 0, 0] = found[:, 1, 1] = np.cos(yaw)
        found[:, 1, 0], found[:, 0, 1] = np.sin(yaw), -np.sin(yaw)
        found[:, 0, 3] = x_m + speed_mps * t
        found[:, 1, 3] = -1.75
        return found

    return poses
