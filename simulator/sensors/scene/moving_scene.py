"""What moves around one vehicle at one moment, as triangles: people who walk, cyclists, vehicles."""

import math

import numpy as np

from contract.geometry import Array
from simulator.sensors.scene import shapes
from simulator.sensors.scene.ground import Ground
from simulator.sensors.scene.mesh import PackedMesh, joined
from simulator.sensors.scene.static_scene import CastScene
from simulator.traffic.actors import Bodies
from vehicle_agent.signals import CYCLIST, PEDESTRIAN

# A step of a person who walks; half a swing of the legs.
_STEP_M = 0.7
_SWING_RAD = 0.45
_STRIDES = 9
_WALKING_MPS = 0.2
_TRUCK_M_MIN = 5.6
_CYCLE_M_MAX = 1.1


class MovingScenes:
    """Makes scenes of moving bodies on one ground; the templates are made once.

    fleet_numbers_from  bodies with this number or a greater one are shuttles
    """

    def __init__(self, ground: Ground, fleet_numbers_from: int) -> None:
        self._ground, self._fleet_from = ground, fleet_numbers_from
        strides = np.linspace(-_SWING_RAD, _SWING_RAD, _STRIDES)
        self._people = [shapes.person(1.75, float(stride)) for stride in strides]
        self._car, self._truck, self._cyclist = shapes.car(), shapes.truck(), shapes.cyclist()
        # As long as a car of the template, so that all scale by their sizes.
        self._shuttle = shapes.shuttle(4.35, 1.63, 2.28, 2.175)

    def of(self, bodies: Bodies) -> CastScene:
        """The scene of these bodies; without the vehicle whose sensors look at it."""
        parts = [self._placed(bodies, k) for k in range(len(bodies.numbers))]
        return CastScene(joined(parts)) if parts else CastScene(_nothing())

    def _placed(self, bodies: Bodies, k: int) -> PackedMesh:
        x, y, yaw = (float(value) for value in bodies.poses_map[k])
        length, width = (float(value) for value in bodies.sizes_m[k])
        place = np.array([x]), np.array([y])
        number = int(bodies.numbers[k])
        if bodies.kinds[k] == PEDESTRIAN:
            z = float(self._ground.height_m(*place)[0])
            stature = 0.9 + 0.02 * (number * 7 % 10)
            return self._template(bodies, k, x, y, yaw).placed(
                np.array([[x, y, z, yaw]]), np.full((1, 3), stature), first_number=number
            )
        z = float(self._ground.road_m(*place)[0])
        template, extent = self._vehicle(number, int(bodies.kinds[k]), length, width)
        scales = np.array([[length / extent[0], width / extent[1], 1.0]])
        return template.placed(np.array([[x, y, z, yaw]]), scales, first_number=number)

    def _template(self, bodies: Bodies, k: int, x: float, y: float, yaw: float) -> PackedMesh:
        velocity: Array = bodies.velocities_map_mps[k]
        if float(np.hypot(velocity[0], velocity[1])) < _WALKING_MPS:
            return self._people[_STRIDES // 2]
        # The way along the heading sets the phase, so that legs swing with the distance walked.
        way = x * math.cos(yaw) + y * math.sin(yaw) + 0.37 * float(bodies.numbers[k])
        swing = math.sin(math.pi * way / _STEP_M)
        return self._people[round(0.5 * (swing + 1.0) * (_STRIDES - 1))]

    def _vehicle(
        self, number: int, kind: int, length: float, width: float
    ) -> tuple[PackedMesh, tuple[float, float]]:
        """The template and its own length and width."""
        if number >= self._fleet_from:
            return self._shuttle, (4.35, 1.63)
        if kind == CYCLIST or width < _CYCLE_M_MAX:
            return self._cyclist, (1.75, 0.6)
        if length >= _TRUCK_M_MIN:
            return self._truck, (7.0, 2.3)
        return self._car, (4.4, 1.8)


def _nothing() -> PackedMesh:
    return PackedMesh(
        np.empty((0, 3, 3), dtype=np.float32),
        np.empty(0, dtype=np.uint8),
        np.empty(0, dtype=np.float32),
        np.empty(0, dtype=np.int32),
    )
