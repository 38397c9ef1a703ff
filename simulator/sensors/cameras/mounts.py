"""Where cameras are, and what they see: four on a vehicle, one over each crossing."""

import math
from dataclasses import dataclass

import numpy as np

from contract.geometry import Array
from simulator.sensors.scene.changes import SceneError
from vehicle_agent.config import Body, Camera
from vehicle_agent.signals.pictures import optical_pose, pinhole_matrix


@dataclass(frozen=True, slots=True, eq=False)
class CameraMount:
    """One pinhole camera without distortion, as a driver hands pictures over after rectification.

    T_base_camera  (4, 4) optical frame: x right, y down, z ahead. Of a fixed camera it is T_map_camera
    field_rad      horizontal field of view
    """

    name: str
    T_base_camera: Array
    width_px: int = 640
    height_px: int = 480
    field_rad: float = math.radians(60.0)

    def __post_init__(self) -> None:
        """Raises SceneError for a picture or a field of view that no pinhole camera has."""
        if not (self.width_px >= 16 and self.height_px >= 16 and 0.05 <= self.field_rad <= 2.6):
            raise SceneError(f"a camera has at least 16 x 16 px and a field of 0.05 to 2.6 rad, not {self}")

    @property
    def K(self) -> Array:  # noqa: N802 - the pinhole matrix's name in every book
        """(3, 3) pinhole matrix; the middle of the first pixel is (0, 0)."""
        return pinhole_matrix(self.width_px, self.height_px, self.field_rad)


def profile_camera(camera: Camera) -> CameraMount:
    """The camera of a vehicle's profile."""
    pose = optical_pose(camera.x_m, camera.y_m, camera.z_m, camera.yaw_rad, camera.down_rad)
    return CameraMount("front", pose, camera.width_px, camera.height_px, camera.field_rad)


def four_cameras(body: Body) -> tuple[CameraMount, ...]:
    """Front, left, right and rear at the roof's edge. The front one is narrower, to see people far away."""
    front, rear, half = body.front_overhang_m, -body.rear_overhang_m, 0.5 * body.width_m
    middle, z_m = 0.5 * (front + rear), body.height_m - 0.1
    wide = math.radians(90.0)
    return (
        CameraMount("front", optical_pose(front, 0.0, z_m, 0.0, 0.05), field_rad=math.radians(50.0)),
        CameraMount("left", optical_pose(middle, half, z_m, 0.5 * math.pi, 0.15), field_rad=wide),
        CameraMount("right", optical_pose(middle, -half, z_m, -0.5 * math.pi, 0.15), field_rad=wide),
        CameraMount("rear", optical_pose(rear, 0.0, z_m, math.pi, 0.1), field_rad=wide),
    )


def watching_camera(name: str, place_map: Array, target_map: Array, field_rad: float = 0.9) -> CameraMount:
    """A fixed camera at place_map (3,) that looks at target_map (3,), map frame; its base is the map.

    Raises SceneError if both are the same place.
    """
    ahead = np.asarray(target_map, dtype=np.float64) - place_map
    level_m = float(np.hypot(ahead[0], ahead[1]))
    if level_m < 0.1:
        raise SceneError(f"camera {name} must look at a place at least 0.1 m beside it")
    yaw_rad, down_rad = math.atan2(ahead[1], ahead[0]), math.atan2(-ahead[2], level_m)
    pose = optical_pose(float(place_map[0]), float(place_map[1]), float(place_map[2]), yaw_rad, down_rad)
    return CameraMount(name, pose, field_rad=field_rad)
