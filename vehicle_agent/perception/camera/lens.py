"""A camera's lens, as `workshop calibrate-camera` measures it, and pictures freed of its distortion."""

import math
from pathlib import Path
from typing import Annotated

import msgspec
import numpy as np
from numpy.typing import NDArray

from contract.geometry import Array
from vehicle_agent.perception.camera.people_detector import opencv

Pixels = NDArray[np.uint8]
# Of OpenCV's model with two tangential and two, three or six radial coefficients.
_COEFFICIENTS = (4, 5, 8)
# A wider view is no picture of a lens of this model.
_FIELD_RAD_MAX = 2.9


class LensError(Exception):
    """A file of a lens that cannot be used; the message says what to do."""


class Lens(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """OpenCV's pinhole model with radial and tangential distortion.

    width_px, height_px  of the pictures that it was measured with
    fx_px, fy_px, cx_px, cy_px  focal lengths and principal point
    distortion           k1, k2, p1, p2, then k3, then k4 to k6
    rms_px               what the calibration left
    """

    width_px: Annotated[int, msgspec.Meta(ge=16)]
    height_px: Annotated[int, msgspec.Meta(ge=16)]
    fx_px: float
    fy_px: float
    cx_px: float
    cy_px: float
    distortion: tuple[float, ...]
    rms_px: float = 0.0

    def __post_init__(self) -> None:
        """ValueError for a lens that no camera has."""
        values = (self.fx_px, self.fy_px, self.cx_px, self.cy_px, *self.distortion)
        if len(self.distortion) not in _COEFFICIENTS or not all(map(math.isfinite, values)):
            raise ValueError("distortion has 4, 5 or 8 finite coefficients")
        if not (self.fx_px > 0.0 and self.fy_px > 0.0):
            raise ValueError("focal lengths are above 0")
        if not (0.0 < self.cx_px < self.width_px and 0.0 < self.cy_px < self.height_px):
            raise ValueError("the principal point lies outside the picture")
        if 2.0 * math.atan(0.5 * self.width_px / self.fx_px) > _FIELD_RAD_MAX:
            raise ValueError("the field of view is too wide for this model")

    def matrix(self) -> Array:
        """(3, 3) of the pinhole."""
        return np.array([[self.fx_px, 0.0, self.cx_px], [0.0, self.fy_px, self.cy_px], [0.0, 0.0, 1.0]])

    def toml(self) -> str:
        """The file of this lens."""
        values = {name: getattr(self, name) for name in self.__struct_fields__}
        values["distortion"] = list(self.distortion)
        return "".join(f"{name} = {value}\n" for name, value in values.items())


def load_lens(path: Path) -> Lens:
    """Raises LensError."""
    try:
        return msgspec.toml.decode(path.read_bytes(), type=Lens)
    except (msgspec.DecodeError, OSError) as error:
        raise LensError(f"{path}: {error}") from error


class Rectification:
    """Pictures of a lens to those of a pinhole K (3, 3) of width_px x height_px, which the profile names."""

    def __init__(self, lens: Lens, K: Array, width_px: int, height_px: int) -> None:
        """Raises CameraLibraryMissing."""
        self._cv2, self._lens = opencv(), lens
        # With points of 16 bits the picture is made in a third of the time.
        self._maps = self._cv2.initUndistortRectifyMap(
            lens.matrix(), np.array(lens.distortion), None, K, (width_px, height_px), self._cv2.CV_16SC2
        )

    def seen_share(self) -> float:
        """Which part of the new picture the lens sees; the rest of it is black."""
        whole = np.full((self._lens.height_px, self._lens.width_px), 255, dtype=np.uint8)
        return float((self._remapped(whole) > 0).mean())

    def pixels(self, picture: Pixels) -> Pixels:
        """(h, w, 3) of the lens to (height_px, width_px, 3). Raises ValueError for another size."""
        if picture.shape[:2] != (self._lens.height_px, self._lens.width_px):
            raise ValueError(
                f"pictures have {picture.shape[1]} x {picture.shape[0]} px, and the lens was measured with "
                f"{self._lens.width_px} x {self._lens.height_px}"
            )
        return self._remapped(picture)

    def _remapped(self, picture: Pixels) -> Pixels:
        straight: Pixels = self._cv2.remap(picture, *self._maps, self._cv2.INTER_LINEAR)
        return straight
