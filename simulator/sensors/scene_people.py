"""The planar scanner and the camera with which one vehicle sees people, in a world's scene, tick by tick."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from simulator.sensors.cameras.camera import CameraSurroundings, SceneCamera
from simulator.sensors.cameras.clothed_people import PeopleDresser
from simulator.sensors.cameras.light import Light
from simulator.sensors.cameras.mounts import profile_camera
from simulator.sensors.lidars.firings import Array32
from simulator.sensors.lidars.scanner import MovingBodies
from simulator.sensors.scene.moving_scene import MovingScenes
from simulator.sensors.scene.static_scene import StaticScene
from simulator.sensors.scene_planar import VehiclePlanarScanner
from simulator.traffic.actors import Bodies
from simulator.vehicle.plant import PlantView
from vehicle_agent.config import Profile
from vehicle_agent.signals.pictures import Picture

# Bodies farther away are no more than a few pixels.
_NEAR_M = 60.0


class VehiclePeopleSensors:
    """What `[people_scanner]` and `[camera]` of a profile see."""

    def __init__(
        self,
        scene: StaticScene,
        profile: Profile,
        rng: np.random.Generator,
        scenes: MovingScenes,
        light: Light,
        rain_mm_per_h: float,
    ) -> None:
        self._scanner = VehiclePlanarScanner(scene, profile, rng, rain_mm_per_h, profile.people_scanner)
        seed = int(rng.integers(1 << 31))
        self._camera = SceneCamera(profile_camera(profile.camera), scene, seed, light)
        self._dresser, self._scenes = PeopleDresser(scene.ground, seed), scenes
        self._ground, self._wheelbase_m = scene.ground, profile.body.wheelbase_m
        rate_hz = profile.camera.rate_hz
        self._every_ns = round(1e9 / rate_hz) if rate_hz > 0.0 else 0
        self._due_ns: int | None = None

    def scan(
        self, now_ns: int, truth: PlantView, moving_now: Callable[[], MovingBodies]
    ) -> tuple[Array32, Array32] | None:
        """As `VehiclePlanarScanner.step`; call it in every step."""
        return self._scanner.step(now_ns, truth, moving_now)

    def picture(
        self,
        now_ns: int,
        truth: PlantView,
        others: Bodies,
        windows: Callable[[], NDArray[np.int64] | None],
    ) -> Picture | None:
        """The picture of now, if one is due and `windows` (`SceneCamera.glimpse`) are wanted of it."""
        if not self._every_ns or (self._due_ns is not None and now_ns < self._due_ns):
            return None
        self._due_ns = (now_ns if self._due_ns is None else self._due_ns) + self._every_ns
        wanted = windows()
        if wanted is None:
            return None
        pose = truth.pose_map
        row = np.array([[pose.x_m, pose.y_m, pose.yaw_rad]])
        T_map_base = self._ground.poses(row, self._wheelbase_m)[0]
        near = others.selected(np.hypot(*(others.poses_map[:, :2] - row[:, :2]).T) < _NEAR_M)
        around = CameraSurroundings(self._dresser.of(near), self._scenes.of(near.selected(~near.people)))
        return self._camera.glimpse(T_map_base, now_ns, around, wanted)
