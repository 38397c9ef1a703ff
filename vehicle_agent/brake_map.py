"""The open-loop brake map: the pedal for a deceleration (GEM, section III-A)."""

import math

import msgspec
import numpy as np


class BrakeMap(msgspec.Struct, frozen=True):
    """b = gain * ln(a + knee) + offset, clamped to 0..1; a is a deceleration's magnitude, m/s2.

    The paper's map is gain 0.28, offset 0.90, knee 0. It brakes fully from 1.4 m/s2 on, more than requested.
    Gain, offset and knee are identified per vehicle (`fit_brake_map`).
    """

    gain: float = 0.28
    offset: float = 0.90
    knee_mps2: float = 0.0

    def __post_init__(self) -> None:
        if not (self.gain > 0.0 and self.knee_mps2 >= 0.0):
            raise ValueError("a brake map needs gain > 0 and knee_mps2 >= 0, or it would not rise")

    def brake_ratio(self, decel_mps2: float) -> float:
        """The pedal for a deceleration; 0 for none, never falling as the deceleration grows."""
        if decel_mps2 <= 0.0:
            return 0.0
        return min(1.0, max(0.0, self.gain * math.log(decel_mps2 + self.knee_mps2) + self.offset))


def fit_brake_map(brake_ratios: np.ndarray, decels_mps2: np.ndarray) -> BrakeMap:
    """The brake map that fits recorded brakings best.

    brake_ratios, decels_mps2  (n,) pedal and the steady deceleration it gave
    Least squares in gain and offset for each knee on a logarithmic grid; the best knee wins. ValueError for
    fewer than three brakings or when more pedal does not brake more.
    """
    braking = (decels_mps2 > 0.0) & (brake_ratios > 0.0) & (brake_ratios < 1.0)
    b, a = brake_ratios[braking], decels_mps2[braking]
    if len(b) < 3:
        raise ValueError("record at least three brakings between no and full pedal")
    fits: list[tuple[float, BrakeMap]] = []
    for knee in (0.0, *np.geomspace(0.01, 5.0, 100)):
        basis = np.column_stack((np.log(a + knee), np.ones(len(a))))
        (gain, offset), *_ = np.linalg.lstsq(basis, b, rcond=None)
        if gain > 0.0:
            misfit = float(np.sum((basis @ (gain, offset) - b) ** 2))
            fits.append((misfit, BrakeMap(float(gain), float(offset), float(knee))))
    if not fits:
        raise ValueError("more pedal must brake more; check the signs of the recording")
    return min(fits, key=lambda fit: fit[0])[1]
