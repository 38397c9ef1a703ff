"""perception: what its worker gets from the tick, and what passes inside it before road users are tracked."""

import msgspec
import numpy as np


class SeenObjects(msgspec.Struct, frozen=True):
    """Objects found in one scan, without identities. Rows belong together; an empty scan has none.

    stamp_ns             end of the scan
    kinds (n,) int64     index into TRACK_KINDS; `other` where the finder cannot tell
    scores (n,)          how sure the finder is of kind and place, 0 to 1
    poses_base (n, 3)    x, y, yaw of the middle of the outline, base frame at stamp_ns
    sizes_m (n, 3)       length along yaw, width, height
    velocities_base_mps  (n, 2) over ground, along the axes of that base frame; NaN where the finder has none
    is_fitted (n,)       bool: the box is fitted to the returns of two sides, to some cm; empty: none is
    visible_m (n,)       height of the part that returns show, from its lowest to its top; NaN where that was
                         not looked at; empty: nowhere
    """

    stamp_ns: int
    kinds: np.ndarray
    scores: np.ndarray
    poses_base: np.ndarray
    sizes_m: np.ndarray
    velocities_base_mps: np.ndarray
    is_fitted: np.ndarray = msgspec.field(default_factory=lambda: np.empty(0, np.bool_))
    visible_m: np.ndarray = msgspec.field(default_factory=lambda: np.empty(0))

    def fitted(self) -> np.ndarray:
        """(n,) bool: `is_fitted`, also where it is empty."""
        return self.is_fitted if len(self.is_fitted) else np.zeros(len(self.kinds), np.bool_)

    def visible(self) -> np.ndarray:
        """(n,) `visible_m`, also where it is empty."""
        return self.visible_m if len(self.visible_m) else np.full(len(self.kinds), np.nan)


class EgoMotion(msgspec.Struct, frozen=True, tag="ego_motion"):
    """The vehicle's motion in one tick, from which the perception worker reckons its way between two scans.

    Speed and yaw rate, not a pose: a corrected pose would move everything that stands.

    waved_on_ns  the task's: an operator has looked, and no person is where the vehicle does not see
    """

    stamp_ns: int
    speed_mps: float
    yaw_rate_radps: float
    waved_on_ns: int = 0
