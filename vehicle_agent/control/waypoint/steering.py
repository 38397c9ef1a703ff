"""The angular half of the twist controller: a turn rate becomes a front-wheel angle (GEM, section III-B)."""

import math

import msgspec


class BicycleSteering(msgspec.Struct, frozen=True):
    """delta = atan(L omega / v), limited in angle and rate.

    speed_mps_min  a lower speed counts as this: at rest any turn rate would need full lock
    """

    wheelbase_m: float = 2.6
    steer_rad_max: float = 0.4795
    steer_rate_radps_max: float = 0.6
    speed_mps_min: float = 0.5
    dt_s: float = 0.02

    def steer_rad(
        self, turn_radps: float, speed_mps: float, before_rad: float, trim_rad: float = 0.0
    ) -> float:
        """The next command after `before_rad`, for wheels that stand trim_rad to the left of the command."""
        wanted = math.atan(self.wheelbase_m * turn_radps / max(speed_mps, self.speed_mps_min))
        wanted = min(max(wanted - trim_rad, -self.steer_rad_max), self.steer_rad_max)
        reach = self.steer_rate_radps_max * self.dt_s
        return before_rad + min(max(wanted - before_rad, -reach), reach)
