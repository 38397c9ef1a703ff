"""perception: pictures of cameras, and the pinhole model by which places are found in them."""

import math

import msgspec
import numpy as np

from contract.geometry import Array

# The ways that an optical frame's axes have in a frame with x ahead, y left, z up.
_R_LEVEL_OPTICAL = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])


class Picture(msgspec.Struct, frozen=True):
    """One picture of one camera, without distortion.

    camera    name of the camera
    stamp_ns  middle of the exposure
    pixels    (height, width, 3) uint8, red green blue; row 0 is the top
    """

    camera: str
    stamp_ns: int
    pixels: np.ndarray


class PinholeCamera(msgspec.Struct, frozen=True):
    """Where a camera is and what it sees.

    K              (3, 3) pinhole matrix, px; the middle of the first pixel is (0, 0)
    T_base_camera  (4, 4) of the optical frame (x right, y down, z ahead); a fixed camera's base is the map
    """

    name: str
    K: np.ndarray
    T_base_camera: np.ndarray
    width_px: int
    height_px: int


def optical_pose(x_m: float, y_m: float, z_m: float, yaw_rad: float, down_rad: float = 0.0) -> Array:
    """(4, 4) pose of an optical frame at a place, which looks to yaw_rad and down_rad below the horizon."""
    cy, sy, cp, sp = math.cos(yaw_rad), math.sin(yaw_rad), math.cos(down_rad), math.sin(down_rad)
    pose: Array = np.eye(4)
    pose[:3, :3] = (
        np.array([[cy, -sy, 0.0], [sy, cy, 0.0], [0.0, 0.0, 1.0]])
        @ np.array([[cp, 0.0, sp], [0.0, 1.0, 0.0], [-sp, 0.0, cp]])
        @ _R_LEVEL_OPTICAL
    )
    pose[:3, 3] = x_m, y_m, z_m
    return pose


def pinhole_matrix(width_px: int, height_px: int, field_rad: float) -> Array:
    """(3, 3) of a camera with this horizontal field of view; the middle of the first pixel is (0, 0)."""
    focal_px = 0.5 * width_px / math.tan(0.5 * field_rad)
    return np.array(
        [[focal_px, 0.0, 0.5 * (width_px - 1)], [0.0, focal_px, 0.5 * (height_px - 1)], [0.0, 0.0, 1.0]]
    )
