"""perception: pictures of cameras, and the pinhole model by which places are found in them."""

import msgspec
import numpy as np


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
