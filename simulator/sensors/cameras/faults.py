"""Faults of a camera, for tests of what must notice them."""

from typing import Literal

import msgspec
import numpy as np

from contract.geometry import Array
from simulator.sensors.cameras.camera import CameraSurroundings, SceneCamera, Shot
from vehicle_agent.signals.pictures import Picture

CameraFault = Literal["dead", "black", "frozen", "covered", "upside_down"]

_COVER_LEVEL = 90


class FaultyCamera:
    """A camera whose `fault` may be set at any time; None while it works.

    dead         no picture at all
    black        every pixel is 0
    frozen       the last picture again and again, with new stamps
    covered      a hand or a leaf before the lens: one grey
    upside_down  mounted the wrong way round
    """

    def __init__(self, camera: SceneCamera) -> None:
        self.fault: CameraFault | None = None
        self.camera = camera
        self._last: Shot | None = None

    def take(self, T_map_base: Array, stamp_ns: int, around: CameraSurroundings) -> Shot | None:
        """The picture, as the fault leaves it; None if the camera is dead."""
        if self.fault == "dead":
            return None
        if self.fault == "frozen" and self._last is not None:
            picture = msgspec.structs.replace(self._last.picture, stamp_ns=stamp_ns)
            return Shot(picture, self._last.numbers, self._last.hidden)
        shot = self.camera.take(T_map_base, stamp_ns, around)
        self._last = shot
        return Shot(self._faulty(shot.picture), shot.numbers, shot.hidden)

    def _faulty(self, picture: Picture) -> Picture:
        pixels = picture.pixels
        if self.fault == "black":
            pixels = np.zeros_like(pixels)
        elif self.fault == "covered":
            pixels = np.full_like(pixels, _COVER_LEVEL)
        elif self.fault == "upside_down":
            pixels = np.ascontiguousarray(pixels[::-1, ::-1])
        return msgspec.structs.replace(picture, pixels=pixels)
