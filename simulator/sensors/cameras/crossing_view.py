"""The picture of a camera on a mast beside a crossing."""

from dataclasses import replace

import numpy as np

from contract.geometry import Array
from contract.roads.areas import outline_array
from contract.roads.model import ObservationArea
from simulator.sensors.cameras.camera import CameraSurroundings, SceneCamera, Shot
from simulator.sensors.cameras.clothed_people import PeopleDresser
from simulator.sensors.cameras.light import DAY, Light
from simulator.sensors.cameras.mounts import watching_camera
from simulator.sensors.scene.moving_scene import MovingScenes
from simulator.sensors.scene.static_scene import StaticScene
from simulator.traffic.actors import Bodies

MAST_M = 5.0
# From the area's outline to the mast.
_BEYOND_M = 5.0
# Bodies farther away are no more than a few pixels.
_NEAR_M = 60.0
_DIRECTIONS = 16


class CrossingView:
    """A camera of one observation area, in the direction in which nothing hides the area.

    ground_points  ((u, v), (x, y)) of four places on the ground, as they are measured to set a camera up
    """

    def __init__(
        self,
        scene: StaticScene,
        area: ObservationArea,
        seed: int,
        fleet_numbers_from: int,
        light: Light = DAY,
        size_px: tuple[int, int] = (480, 360),
    ) -> None:
        self._outline = outline_array(area)
        self._middle = self._outline.mean(axis=0)
        self._ground = scene.ground
        place, target = self._best_place(scene)
        reach_m = float(np.linalg.norm(self._outline - self._middle, axis=1).max())
        apart_m = float(np.linalg.norm(target[:2] - place[:2]))
        field_rad = 2.0 * float(np.arctan2(reach_m + 1.0, apart_m))
        mount = replace(
            watching_camera(area.area_id, place, target, min(field_rad, 1.4)),
            width_px=size_px[0], height_px=size_px[1],
        )  # fmt: skip
        self.camera = SceneCamera(mount, scene, seed, light)
        self._dresser = PeopleDresser(scene.ground, seed)
        self._scenes = MovingScenes(scene.ground, fleet_numbers_from)

    @property
    def ground_points(self) -> tuple[tuple[tuple[float, float], tuple[float, float]], ...]:
        low, high = self._outline.min(axis=0), self._outline.max(axis=0)
        corners = np.array([low, [high[0], low[1]], high, [low[0], high[1]]])
        heights = self._ground.height_m(corners[:, 0], corners[:, 1])
        mount = self.camera.mount
        points = np.column_stack((corners, heights, np.ones(4))) @ np.linalg.inv(mount.T_base_camera).T
        pixels = points[:, :3] @ mount.K.T
        return tuple(
            ((float(u / w), float(v / w)), (float(x), float(y)))
            for (u, v, w), (x, y) in zip(pixels, corners, strict=True)
        )

    def take(self, stamp_ns: int, bodies: Bodies) -> Shot:
        """The picture at a stamp, among all bodies of the world."""
        apart = np.linalg.norm(bodies.poses_map[:, :2] - self._middle, axis=1)
        near = bodies.selected(apart < _NEAR_M)
        around = CameraSurroundings(self._dresser.of(near), self._scenes.of(near.selected(~near.people)))
        return self.camera.take(np.eye(4), stamp_ns, around)

    def _best_place(self, scene: StaticScene) -> tuple[Array, Array]:
        """(3,) of the lens and (3,) of the area's middle: where most of the area is in free view."""
        x, y = self._middle
        target = np.array([x, y, float(self._ground.height_m(np.array([x]), np.array([y]))[0])])
        places = np.vstack((self._outline, 0.5 * (self._outline + self._middle), self._middle[None]))
        goals = np.column_stack((places, self._ground.height_m(places[:, 0], places[:, 1]) + 0.9))
        best, most = target, -1
        for angle in 2.0 * np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS:
            ahead = np.array([np.cos(angle), np.sin(angle)])
            foot = self._middle + ahead * (float(((self._outline - self._middle) @ ahead).max()) + _BEYOND_M)
            height = float(self._ground.height_m(foot[:1], foot[1:])[0]) + MAST_M
            lens = np.array([foot[0], foot[1], height])
            ways = goals - lens
            lengths = np.linalg.norm(ways, axis=1)
            origins = np.broadcast_to(lens, ways.shape).astype(np.float32)
            _, met = scene.cast(
                origins, (ways / lengths[:, None]).astype(np.float32), lengths.astype(np.float32)
            )
            free = int(np.count_nonzero(met < 0))
            if free > most:
                best, most = lens, free
        return best, target
