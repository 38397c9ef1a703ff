"""How far the wheels stand beside what the steering reports, learned from how the vehicle turns."""

import math

import msgspec

from vehicle_agent.signals import Ego, VehicleMotion


class SteeringTrim(msgspec.Struct, frozen=True):
    """A first-order mean of atan(L omega / v) - steer, rad: a bent linkage, a cross slope, tyres that drift.

    Waypoint followers have no integral that would find it, for in a curve their error is not zero; the turn
    rate shows it everywhere.

    settle_s   time constant; learned above speed_mps_min, where the turn rate's noise is small beside it
    trim_rad_max  more than this is a fault to be found by the watch on the steering, not to be steered away
    """

    wheelbase_m: float = 2.6
    settle_s: float = 2.5
    speed_mps_min: float = 0.8
    trim_rad_max: float = 0.03
    dt_s: float = 0.02

    def step(self, trim_rad: float, ego: Ego, motion: VehicleMotion) -> float:
        """The next trim; unchanged while the vehicle is slow, or moves as no wheel angle explains."""
        if ego.speed_mps < self.speed_mps_min or not math.isfinite(ego.yaw_rate_radps):
            return trim_rad
        turned_rad = math.atan(self.wheelbase_m * ego.yaw_rate_radps / ego.speed_mps)
        off_rad = min(max(turned_rad - motion.steer_rad, -0.1), 0.1)
        trim_rad += (off_rad - trim_rad) * self.dt_s / self.settle_s
        return min(max(trim_rad, -self.trim_rad_max), self.trim_rad_max)
