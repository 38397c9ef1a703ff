"""The drivers of the cameras on a live world's vehicles: pictures of its scene, as fast as a core makes them.

A process beside the simulator, which has no time for them: a picture takes 50 to 100 ms.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np

from contract.roads.model import RoadMap
from simulator.live.live import scan_ring_path
from simulator.live.moment_file import Moment, MomentFile, moment_path
from simulator.sensors.cameras.camera import CameraSurroundings, SceneCamera
from simulator.sensors.cameras.clothed_people import PeopleDresser
from simulator.sensors.cameras.mounts import four_cameras
from simulator.sensors.scene.moving_scene import MovingScenes
from simulator.sensors.scene.static_scene import StaticScene
from simulator.sensors.scene_lidars import SceneOptions
from simulator.world import FLEET_NUMBERS_FROM
from vehicle_agent.config import Profile
from vehicle_agent.picture_ring import PictureRing, picture_ring_path

# Bodies farther away are no more than a few pixels.
_NEAR_M = 60.0


class VehicleCameras:
    """Four cameras on each vehicle, in turn. Call `step` again and again."""

    def __init__(
        self,
        road_map: RoadMap,
        profile: Profile,
        vehicle_ids: tuple[str, ...],
        options: SceneOptions,
        folder: Path,
        size_px: tuple[int, int],
        rate_hz: float,
    ) -> None:
        """options: of the simulator's scene. folder: of its rings and moments.

        size_px  width and height of a picture
        rate_hz  of each camera, where the core is fast enough
        Raises SceneError, DeviceFeedError: the simulator has made no file of moments yet.
        """
        self._moments = MomentFile(moment_path(folder), create=False)
        scene = StaticScene(
            road_map, options.seed, options.changes, options.ground, is_furnished=options.is_furnished
        )
        self._ground, self._wheelbase_m = scene.ground, profile.body.wheelbase_m
        self._dresser = PeopleDresser(scene.ground, options.seed)
        self._scenes = MovingScenes(scene.ground, FLEET_NUMBERS_FROM)
        width_px, height_px = size_px
        mounts = [
            replace(mount, width_px=width_px, height_px=height_px) for mount in four_cameras(profile.body)
        ]
        cameras = [SceneCamera(mount, scene, options.seed, options.light) for mount in mounts]
        self._taken = [
            _TakenByCamera(number, camera, picture_ring_path(scan_ring_path(folder, name), camera.mount.name))
            for camera in cameras
            for number, name in enumerate(vehicle_ids)
        ]
        self._turn, self._every_ns = 0, round(1e9 / rate_hz)

    def step(self) -> bool:
        """Takes the next picture that is due; False: none is yet."""
        moment = self._moments.read()
        if moment is None:
            return False
        for k in range(len(self._taken)):
            taken = self._taken[(self._turn + k) % len(self._taken)]
            if taken.is_due(moment.stamp_ns, self._every_ns):
                self._turn = (self._turn + k + 1) % len(self._taken)
                self._take(taken, moment)
                return True
        return False

    def close(self) -> None:
        self._moments.close()
        for taken in self._taken:
            taken.ring.close()

    def _take(self, taken: "_TakenByCamera", moment: Moment) -> None:
        row = moment.poses_map[taken.number][None]
        T_map_base = self._ground.poses(row, self._wheelbase_m)[0]
        bodies = moment.bodies
        near = np.hypot(*(bodies.poses_map[:, :2] - row[:, :2]).T) < _NEAR_M
        others = bodies.selected(near & (bodies.numbers != FLEET_NUMBERS_FROM + taken.number))
        around = CameraSurroundings(
            self._dresser.of(others), self._scenes.of(others.selected(~others.people))
        )
        picture = taken.camera.take(T_map_base, moment.stamp_ns, around).picture
        taken.ring.write(picture.stamp_ns, picture.pixels)
        taken.stamp_ns = moment.stamp_ns


class _TakenByCamera:
    """One vehicle's camera: its ring, and when its last picture was taken."""

    def __init__(self, number: int, camera: SceneCamera, ring: Path) -> None:
        self.number, self.camera = number, camera
        self.ring = PictureRing(ring, create=True)
        self.stamp_ns: int | None = None

    def is_due(self, now_ns: int, every_ns: int) -> bool:
        """Also after the simulator was started again, with an earlier clock."""
        return self.stamp_ns is None or abs(now_ns - self.stamp_ns) >= every_ns
