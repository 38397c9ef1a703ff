"""What moves around one vehicle at one moment: people who walk, cyclists, vehicles."""

import math

import numpy as np
from numpy.typing import NDArray

from simulator.sensors.scene import shapes
from simulator.sensors.scene.ground import Ground
from simulator.sensors.scene.mesh import PackedMesh
from simulator.sensors.scene.placed_bodies import PlacedBodies, Template
from simulator.traffic.actors import Bodies
from vehicle_agent.signals import CYCLIST

# A step of a person who walks; half a swing of the legs.
_STEP_M = 0.7
SWING_RAD = 0.45
STRIDES = 9
_WALKING_MPS = 0.2
_TRUCK_M_MIN = 5.6
_CYCLE_M_MAX = 1.1
# Places of the templates after those of the strides.
_CAR, _TRUCK, _CYCLE, _SHUTTLE = range(STRIDES, STRIDES + 4)
# Length and width of the templates on wheels.
_EXTENTS_M = np.array([[4.4, 1.8], [7.0, 2.3], [1.75, 0.6], [4.35, 1.63]])


class MovingScenes:
    """Places moving bodies on one ground; the templates are made once.

    fleet_numbers_from  bodies with this number or a greater one are shuttles
    """

    def __init__(self, ground: Ground, fleet_numbers_from: int) -> None:
        self._ground, self._fleet_from = ground, fleet_numbers_from
        strides = np.linspace(-SWING_RAD, SWING_RAD, STRIDES)
        meshes = [shapes.person(1.75, float(stride)) for stride in strides]
        meshes += [shapes.car(), shapes.truck(), shapes.cyclist(), shapes.shuttle(4.35, 1.63, 2.28, 2.175)]
        self._templates = [Template(mesh) for mesh in meshes]

    def of(self, bodies: Bodies) -> PlacedBodies:
        """These bodies as rays meet them; without the vehicle whose sensors look at them."""
        chosen = np.where(bodies.people, strides_of(bodies), self._vehicles(bodies))
        order = np.argsort(chosen, kind="stable")
        chosen, numbers, people = chosen[order], bodies.numbers[order], bodies.people[order]
        x, y, yaw = bodies.poses_map[order].T
        z = np.where(people, self._ground.height_m(x, y), self._ground.road_m(x, y))
        scales = np.repeat(0.9 + 0.02 * (numbers * 7 % 10), 3).reshape(-1, 3)
        # What is on wheels has the size of its body, and its height of its kind.
        driven = ~people
        scales[driven, :2] = bodies.sizes_m[order][driven] / _EXTENTS_M[chosen[driven] - STRIDES]
        scales[driven, 2] = 1.0
        return PlacedBodies(self._templates, chosen, np.column_stack((x, y, z, yaw)), scales, numbers)

    def _vehicles(self, bodies: Bodies) -> NDArray[np.int64]:
        """(n,) the template of each body if it is on wheels."""
        length, width = bodies.sizes_m.T
        kinds = np.where(length >= _TRUCK_M_MIN, _TRUCK, _CAR)
        kinds = np.where((bodies.kinds == CYCLIST) | (width < _CYCLE_M_MAX), _CYCLE, kinds)
        return np.where(bodies.numbers >= self._fleet_from, _SHUTTLE, kinds).astype(np.int64)


def strides_of(bodies: Bodies) -> NDArray[np.int64]:
    """(n,) which of STRIDES each body's legs make, from one leg ahead to the other."""
    x, y, yaw = bodies.poses_map.T
    # The way along the heading sets the phase, so that legs swing with the distance walked.
    way = x * np.cos(yaw) + y * np.sin(yaw) + 0.37 * bodies.numbers
    speeds = np.hypot(bodies.velocities_map_mps[:, 0], bodies.velocities_map_mps[:, 1])
    swing = np.where(speeds < _WALKING_MPS, 0.0, np.sin(math.pi * way / _STEP_M))
    return np.rint(0.5 * (swing + 1.0) * (STRIDES - 1)).astype(np.int64)


def nothing() -> PackedMesh:
    return PackedMesh(
        np.empty((0, 3, 3), dtype=np.float32),
        np.empty(0, dtype=np.uint8),
        np.empty(0, dtype=np.float32),
        np.empty(0, dtype=np.int32),
    )
