"""The difference between the wheel angle and the reported angle, learned from the yaw rate."""

import math

import msgspec

from vehicle_agent.control.learned_bounds import AT_BOUND_SHARE
from vehicle_agent.signals import Ego, VehicleMotion


class SteeringTrim(msgspec.Struct, frozen=True):
    """A first-order mean of atan(L omega / v) - steer, rad: a bent linkage, a cross slope, drifting tyres.

    Waypoint followers have no integral for it, since in a curve their error is not zero. The yaw rate shows
    it everywhere.

    settle_s       time constant
    speed_mps_min  slower, the noise of the yaw rate is too large to learn from
    trim_rad_max   a larger difference is a fault, which the gate's steering monitor detects
    initial_rad    of the profile
    """

    wheelbase_m: float = 2.6
    settle_s: float = 2.5
    speed_mps_min: float = 0.8
    trim_rad_max: float = 0.03
    initial_rad: float = 0.0
    dt_s: float = 0.02

    def step(self, trim_rad: float, ego: Ego, motion: VehicleMotion) -> float:
        """The next trim; unchanged while the vehicle is slow or the yaw rate is not finite."""
        if ego.speed_mps < self.speed_mps_min or not math.isfinite(ego.yaw_rate_radps):
            return trim_rad
        effective_rad = math.atan(self.wheelbase_m * ego.yaw_rate_radps / ego.speed_mps)
        deviation_rad = min(max(effective_rad - motion.steer_rad, -0.1), 0.1)
        trim_rad += (deviation_rad - trim_rad) * self.dt_s / self.settle_s
        return min(max(trim_rad, -self.trim_rad_max), self.trim_rad_max)

    def is_at_bound(self, trim_rad: float) -> bool:
        return abs(trim_rad) >= AT_BOUND_SHARE * self.trim_rad_max
