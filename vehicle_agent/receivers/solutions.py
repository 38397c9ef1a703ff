"""Position solutions as receivers state them, and the fixes that localization takes."""

import math

import msgspec

from contract.geometry import wrap_angle
from vehicle_agent.signals import GnssFix


class Solution(msgspec.Struct, frozen=True):
    """One epoch of a receiver.

    utc_ns          the time of the solution, None where the receiver does not know the date yet
    course_rad      of the motion over ground, clockwise from north
    heading_rad     of the vehicle, clockwise from north, None without two antennas
    position_std_m  the greater of the horizontal standard deviations, as the receiver states it (GST, hAcc)
    """

    utc_ns: int | None
    latitude_deg: float
    longitude_deg: float
    speed_mps: float
    course_rad: float | None
    heading_rad: float | None
    position_std_m: float


# A course below this speed is the direction of noise.
COURSE_SPEED_MPS = 0.5
# Fixes farther apart tell no rate of turn.
_RATE_NS_MAX = 2_000_000_000


class FixTracker:
    """Solutions to fixes: a heading from the course while the vehicle moves, and the yaw rate between fixes.

    no_heading  solutions before the vehicle has moved, of a receiver with one antenna: no fix
    """

    def __init__(self) -> None:
        self.no_heading = 0
        self._yaw_rad: float | None = None
        self._stamp_ns = 0

    def fix(self, stamp_ns: int, solution: Solution) -> GnssFix | None:
        """The fix of a solution that came at stamp_ns (the vehicle's clock)."""
        bearing_rad = solution.heading_rad
        if bearing_rad is None and solution.speed_mps >= COURSE_SPEED_MPS:
            bearing_rad = solution.course_rad
        before_rad, before_ns = self._yaw_rad, self._stamp_ns
        if bearing_rad is not None:
            self._yaw_rad = wrap_angle(0.5 * math.pi - bearing_rad)
            self._stamp_ns = stamp_ns
        if self._yaw_rad is None:
            self.no_heading += 1
            return None
        yaw_rate_radps = 0.0
        if bearing_rad is not None and before_rad is not None and 0 < stamp_ns - before_ns <= _RATE_NS_MAX:
            yaw_rate_radps = wrap_angle(self._yaw_rad - before_rad) / (1e-9 * (stamp_ns - before_ns))
        return GnssFix(
            stamp_ns, solution.latitude_deg, solution.longitude_deg, self._yaw_rad, solution.speed_mps,
            yaw_rate_radps, solution.position_std_m,
        )  # fmt: skip
