"""A spinning lidar (VLP-16 by default) over flat ground, walls, people and vehicles."""

from dataclasses import dataclass

import numpy as np

from contract.geometry import Array, Pose2
from simulator.sensors.ray_hits import (
    Array32,
    Kinds,
    ground_ranges,
    hit_boxes,
    hit_cylinders,
    points_from_ranges,
)
from simulator.sensors.walls import WallScene
from vehicle_agent.config import Body, LidarMount

# The sensor stands on a mast, so that the roof of its own vehicle does not hide the road.
MAST_M = 0.35


@dataclass(frozen=True, slots=True)
class LidarNoise:
    """Range noise (standard deviation), share of rays lost, and the range below which nothing returns."""

    range_std_m: float = 0.02
    dropout_ratio: float = 0.01
    range_m_min: float = 0.5


# nothing, ground, wall, person, vehicle: calibrated reflectivity 0..255
REFLECTIVITY = np.array([0.0, 18.0, 45.0, 35.0, 60.0], dtype=np.float32)


class Lidar:
    """One sensor on one vehicle. A scan is taken at one instant, at the end of the turn."""

    def __init__(
        self, mount: LidarMount, body: Body, walls: WallScene, noise: LidarNoise | None = None
    ) -> None:
        self._mount, self._walls, self._noise = mount, walls, noise or LidarNoise()
        elevations = np.linspace(mount.elevation_rad_min, mount.elevation_rad_max, mount.rings)
        self._cos_el, self._sin_el = np.cos(elevations), np.sin(elevations)
        self._mount_base = np.array([mount.x_m, mount.y_m, mount.z_m])
        rays = mount.rings * mount.columns
        self._still_ranges: Array32 = np.empty(rays, dtype=np.float32)
        self._still_kinds: Kinds = np.empty(rays, dtype=np.int8)
        self._cast_constant_rays(body)

    def scan(
        self, pose_map: Pose2, boxes: Array, cylinders: Array, rng: np.random.Generator
    ) -> tuple[Array32, Array32]:
        """Points (n, 3) in the base frame and intensities (n,), both float32.

        boxes (n, 7) and cylinders (n, 4): moving bodies without the own vehicle, map frame, as in `ray_hits`.
        """
        mount, noise = self._mount, self._noise
        cos_yaw, sin_yaw = np.cos(pose_map.yaw_rad), np.sin(pose_map.yaw_rad)
        sensor = np.array(
            [
                pose_map.x_m + cos_yaw * mount.x_m - sin_yaw * mount.y_m,
                pose_map.y_m + sin_yaw * mount.x_m + cos_yaw * mount.y_m,
                mount.z_m,
            ]
        )
        fan = (sensor, pose_map.yaw_rad, self._cos_el, self._sin_el, mount.columns)
        ranges, kinds = self._still_ranges.copy(), self._still_kinds.copy()
        self._walls.shorten(sensor, pose_map.yaw_rad, self._cos_el, self._sin_el, ranges, kinds)
        hit_boxes(boxes, *fan, ranges, kinds)
        hit_cylinders(cylinders, *fan, ranges, kinds)
        rays = len(ranges)
        return points_from_ranges(
            self._cos_el, self._sin_el, mount.columns, self._mount_base, ranges, kinds,
            rng.standard_normal(rays, dtype=np.float32) * np.float32(noise.range_std_m),
            rng.random(rays, dtype=np.float32), noise.dropout_ratio, noise.range_m_min, REFLECTIVITY,
        )  # fmt: skip

    def _cast_constant_rays(self, body: Body) -> None:
        """The constant ranges in the base frame: the ground and the vehicle's own body."""
        mount = self._mount
        ground_ranges(
            self._sin_el, mount.columns, mount.z_m, mount.range_m_max, self._still_ranges, self._still_kinds
        )
        roof_m = min(body.height_m, mount.z_m - MAST_M)
        own = np.array(
            [[0.0, 0.0, 0.0, body.rear_overhang_m, body.front_overhang_m, 0.5 * body.width_m, roof_m]]
        )
        hit_boxes(
            own, self._mount_base, 0.0, self._cos_el, self._sin_el, mount.columns,
            self._still_ranges, self._still_kinds,
        )  # fmt: skip
