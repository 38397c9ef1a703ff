"""Limits of a command: steering angle and rate, throttle, speed."""

import msgspec

from vehicle_agent.signals.poor_position import position_limit_mps

# Tolerance above the limit: the overshoot of a healthy speed controller, and some slack.
_OVER_SHARE, _OVER_MPS = 0.15, 0.3


class Limits(msgspec.Struct, frozen=True):
    """SI units. When the speed limit falls (poor position), the allowed speed falls at `slow_mps2`."""

    steer_rad_max: float
    steer_rate_radps_max: float
    speed_mps_max: float
    throttle_ratio_max: float = 0.7
    slow_mps2: float = 0.8

    def speed_mps(self, before_mps: float, position_std_m: float, dt_s: float) -> float:
        """The speed allowed now, given the one allowed in the last tick."""
        allowed = min(position_limit_mps(position_std_m), self.speed_mps_max)
        return max(allowed, before_mps - self.slow_mps2 * max(dt_s, 0.0))

    def is_over(self, speed_mps: float, allowed_mps: float) -> bool:
        return speed_mps > (1.0 + _OVER_SHARE) * allowed_mps + _OVER_MPS

    def steer_rad(self, before_rad: float, wanted_rad: float, dt_s: float) -> float:
        """The wanted front-wheel angle within angle and rate."""
        wanted = min(max(wanted_rad, -self.steer_rad_max), self.steer_rad_max)
        reach = self.steer_rate_radps_max * dt_s
        return before_rad + min(max(wanted - before_rad, -reach), reach)
