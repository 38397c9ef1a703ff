"""Cameras at the crossings of a campus in virtual time."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from campusloop.virtual.detecting_cameras import detector_at
from contract.roads.model import ObservationArea, RoadMap
from contract.wire.messages import PresenceReport
from simulator.infrastructure import CameraError, CameraParams, cameras_at_crossings
from simulator.world import SimWorld

# As security cameras have, for which the paper's rule works too. Pictures take long to render.
DETECTOR_HZ = 1.0


class VirtualCameras:
    """A camera at every crossing of the map; a report is passed to `send` in the step in which it is due."""

    def __init__(
        self,
        road_map: RoadMap,
        params: CameraParams,
        world: SimWorld,
        rng: Callable[[str], np.random.Generator],
        send: Callable[[PresenceReport], None],
        detector_seed: int | None = None,
    ) -> None:
        """rng: a random stream by its purpose; detector_seed: of the pictures, None: true counts.

        Raises CameraLibraryMissing without OpenCV, and CameraError for a detector in a world without scene.
        """
        self._world, self._send = world, send
        if detector_seed is None:
            self._cameras = cameras_at_crossings(road_map, params, rng)
            return
        lidars = world.scene_lidars
        if lidars is None:
            raise CameraError("a crossing's detector looks at pictures, which a world without a scene lacks")
        rate_hz = min(params.rate_hz, DETECTOR_HZ)

        def detector_of(area: ObservationArea) -> Callable[[int], int | None]:
            return detector_at(area, lidars.scene, world.all_bodies, detector_seed, lidars.light, rate_hz)

        self._cameras = cameras_at_crossings(road_map, replace(params, rate_hz=rate_hz), rng, detector_of)

    def step(self, now_ns: int) -> None:
        people = self._world.pedestrians
        places = np.zeros((0, 2)) if people is None else people.places
        for camera in self._cameras:
            for report in camera.step(now_ns, places):
                self._send(report)
