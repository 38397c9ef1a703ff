"""Whether a camera can be believed: black, covered, dazzled, frozen or upside down."""

import zlib
from typing import Literal

import msgspec
import numpy as np

from vehicle_agent.signals.pictures import Picture

CameraState = Literal["good", "black", "covered", "dazzled", "frozen", "upside_down", "silent"]

# Every so many rows and columns are looked at: 4,800 pixels of 640 x 480.
_EVERY = 8
_SATURATED = 250


class CameraCondition(msgspec.Struct, frozen=True):
    """What is known of one camera.

    stamp_ns     of its newest picture, -1 before the first
    state        pictures count as evidence of people only if it is `good`
    since_ns     of the state
    checksum     of the newest picture; same: pictures in a row that had the same one
    upright, turned  recent regions with a person as the camera is mounted, and with the picture turned round
    """

    camera: str
    stamp_ns: int = -1
    state: CameraState = "silent"
    since_ns: int = 0
    checksum: int = 0
    same: int = 0
    upright: float = 0.0
    turned: float = 0.0


class CameraRules(msgspec.Struct, frozen=True):
    """When a camera is not believed.

    black_level      mean of 255 below which the lens cap is on, or the sensor is dead
    contrast_min     standard deviation of 255 below which something covers the lens
    dazzled_ratio    share of saturated pixels
    same_max         pictures in a row that are equal bit for bit; a sensor's noise never repeats
    silent_ns        a camera without a picture for so long is silent
    turned_min       regions that show a person upside down, before the camera is said to be
    turned_lead      and so many times as many as show one upright
    memory_ratio     of these counts after one more picture
    """

    black_level: float = 6.0
    contrast_min: float = 4.0
    dazzled_ratio: float = 0.35
    same_max: int = 3
    silent_ns: int = 1_000_000_000
    turned_min: float = 4.0
    turned_lead: float = 3.0
    memory_ratio: float = 0.99

    def after_picture(self, known: CameraCondition, picture: Picture) -> CameraCondition:
        """The condition after a picture; one that is not newer changes nothing."""
        if picture.stamp_ns <= known.stamp_ns:
            return known
        looked_at = picture.pixels[::_EVERY, ::_EVERY]
        checksum = zlib.crc32(looked_at.tobytes())
        same = known.same + 1 if known.stamp_ns >= 0 and checksum == known.checksum else 0
        after = msgspec.structs.replace(
            known, stamp_ns=picture.stamp_ns, checksum=checksum, same=same,
            upright=self.memory_ratio * known.upright, turned=self.memory_ratio * known.turned,
        )  # fmt: skip
        return self._with_state(after, self._state(after, looked_at))

    def after_regions(self, known: CameraCondition, upright: int, turned: int) -> CameraCondition:
        """The condition after regions of its picture were looked at: how many had a person either way up."""
        after = msgspec.structs.replace(known, upright=known.upright + upright, turned=known.turned + turned)
        if after.state in ("good", "upside_down"):
            return self._with_state(after, "upside_down" if self._is_turned(after) else "good")
        return after

    def at(self, known: CameraCondition, now_ns: int) -> CameraCondition:
        """The condition at a time: silent if no picture has come."""
        if now_ns - known.stamp_ns > self.silent_ns:
            return self._with_state(known, "silent")
        return known

    def _state(self, condition: CameraCondition, pixels: np.ndarray) -> CameraState:
        level, contrast = float(pixels.mean()), float(pixels.std())
        if level < self.black_level:
            return "black"
        if condition.same >= self.same_max:
            return "frozen"
        if float((pixels.min(axis=2) >= _SATURATED).mean()) > self.dazzled_ratio:
            return "dazzled"
        if contrast < self.contrast_min:
            return "covered"
        return "upside_down" if self._is_turned(condition) else "good"

    def _is_turned(self, condition: CameraCondition) -> bool:
        return condition.turned >= self.turned_min and condition.turned > self.turned_lead * condition.upright

    @staticmethod
    def _with_state(condition: CameraCondition, state: CameraState) -> CameraCondition:
        if state == condition.state:
            return condition
        return msgspec.structs.replace(condition, state=state, since_ns=condition.stamp_ns)
