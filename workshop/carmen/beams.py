"""The directions of a scan's readings, and from which distance on a reading is no return."""

import math
from collections.abc import Mapping

import msgspec
import numpy as np

from contract.geometry import Array

_HALF_TURN_RAD = math.pi
_FARTHEST_PARAMETERS = ("robot_front_laser_max", "robot_frontlaser_max", "laser_front_laser_max")
# A greatest reading that occurs this often is the scanner's word for "nothing seen".
_REPEATED_MIN = 50
_REPEATED_WITHIN_M = 0.006
_BELOW_REPEATED_M = 0.05


class Beams(msgspec.Struct, frozen=True):
    """Evenly spaced readings, counter-clockwise.

    start_rad, step_rad  direction of the first reading and the angle between two, from the laser's x axis
    count                readings of a scan
    farthest_m           the stated greatest distance; infinite where the log's lines do not state one
    """

    start_rad: float
    step_rad: float
    count: int
    farthest_m: float = math.inf

    @classmethod
    def of_front_laser(cls, count: int) -> "Beams":
        """A FLASER line's: half a turn from the right. An odd number includes both ends (181, 361), an even
        one leaves out the last (180, 360)."""
        gaps = count - 1 if count % 2 else count
        return cls(-0.5 * _HALF_TURN_RAD, _HALF_TURN_RAD / gaps, count)

    @property
    def angles_rad(self) -> Array:
        """(count,) directions of the readings."""
        angles: Array = self.start_rad + self.step_rad * np.arange(self.count, dtype=np.float64)
        return angles


def no_return_m(ranges_m: Array, beams: Beams, parameters: Mapping[str, str]) -> float:
    """From which reading on nothing was seen: what the log states or the greatest reading where it repeats.

    ranges_m  (n, m) readings as they are in the log
    """
    limits = [beams.farthest_m] if 0.0 < beams.farthest_m < math.inf else []
    for name in _FARTHEST_PARAMETERS:
        stated = _number(parameters.get(name, ""))
        if stated > 0.0:
            limits.append(stated)
    finite = ranges_m[np.isfinite(ranges_m)]
    if finite.size:
        greatest = float(finite.max())
        if int((finite > greatest - _REPEATED_WITHIN_M).sum()) >= _REPEATED_MIN:
            limits.append(greatest - _BELOW_REPEATED_M)
    return min(limits, default=math.inf)


def _number(text: str) -> float:
    """The first word as a number; 0 where it is none."""
    words = text.split()
    try:
        return float(words[0]) if words else 0.0
    except ValueError:
        return 0.0
