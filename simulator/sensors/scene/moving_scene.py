"""What moves around one vehicle at one moment, as triangles: people who walk, cyclists, vehicles."""

import math

import numpy as np
from numpy.typing import NDArray

from contract.geometry import Array
from simulator.sensors.scene import shapes
from simulator.sensors.scene.ground import Ground
from simulator.sensors.scene.mesh import PackedMesh, joined
from simulator.sensors.scene.static_scene import CastScene
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


class MovingScenes:
    """Makes scenes of moving bodies on one ground; the templates are made once.

    fleet_numbers_from  bodies with this number or a greater one are shuttles
    """

    def __init__(self, ground: Ground, fleet_numbers_from: int) -> None:
        self._ground, self._fleet_from = ground, fleet_numbers_from
        strides = np.linspace(-SWING_RAD, SWING_RAD, STRIDES)
        # Length and width of what is scaled to a body's size; None for people.
        self._templates: list[tuple[PackedMesh, Array | None]] = [
            (shapes.person(1.75, float(stride)), None) for stride in strides
        ]
        self._templates += [
            (shapes.car(), np.array([4.4, 1.8])),
            (shapes.truck(), np.array([7.0, 2.3])),
            (shapes.cyclist(), np.array([1.75, 0.6])),
            (shapes.shuttle(4.35, 1.63, 2.28, 2.175), np.array([4.35, 1.63])),
        ]

    def of(self, bodies: Bodies) -> CastScene:
        """The scene of these bodies; without the vehicle whose sensors look at it."""
        n = len(bodies.numbers)
        if not n:
            return CastScene(nothing())
        x, y = bodies.poses_map[:, 0], bodies.poses_map[:, 1]
        people = bodies.people
        z = np.where(people, self._ground.height_m(x, y), self._ground.road_m(x, y))
        poses = np.column_stack((x, y, z, bodies.poses_map[:, 2]))
        chosen = np.where(people, strides_of(bodies), self._vehicles(bodies))
        scales = np.empty((n, 3))
        scales[:] = (0.9 + 0.02 * (bodies.numbers * 7 % 10))[:, None]
        parts = []
        for kind in np.unique(chosen):
            template, extent = self._templates[int(kind)]
            rows = np.flatnonzero(chosen == kind)
            if extent is not None:
                scales[rows, :2] = bodies.sizes_m[rows] / extent
                scales[rows, 2] = 1.0
            parts.append(template.placed(poses[rows], scales[rows], numbers=bodies.numbers[rows]))
        return CastScene(joined(parts))

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
