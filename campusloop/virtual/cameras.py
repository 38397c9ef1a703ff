"""Cameras at the crossings of a campus in virtual time."""

from collections.abc import Callable

import numpy as np

from contract.roads.model import RoadMap
from contract.wire.messages import PresenceReport
from simulator.infrastructure import CameraParams, cameras_at_crossings
from simulator.world import SimWorld


class VirtualCameras:
    """A camera at every crossing of the map; a report is passed to `send` in the step in which it is due."""

    def __init__(
        self,
        road_map: RoadMap,
        params: CameraParams,
        world: SimWorld,
        rng: Callable[[str], np.random.Generator],
        send: Callable[[PresenceReport], None],
    ) -> None:
        """rng: a random stream by its purpose."""
        self._world, self._send = world, send
        self._cameras = cameras_at_crossings(road_map, params, rng)

    def step(self, now_ns: int) -> None:
        people = self._world.pedestrians
        places = np.zeros((0, 2)) if people is None else people.places
        for camera in self._cameras:
            for report in camera.step(now_ns, places):
                self._send(report)
