"""Coming to rest at a given place on the line."""

import math

import msgspec

from vehicle_agent.planning.selector import SpeedCommand


class Approach(msgspec.Struct, frozen=True):
    """Constant comfortable deceleration to the stop.

    delay_s           from a brake command to its effect: the vehicle still rolls on meanwhile
    decel_mps2_firm   for a stop that is nearer than comfort allows, or already behind
    arrived_m         nearer than this the vehicle just stands still
    """

    decel_mps2: float = 0.6
    decel_mps2_firm: float = 2.5
    delay_s: float = 0.25
    arrived_m: float = 0.06

    def command(self, stop_m: float, speed_mps: float, name: str = "stop") -> SpeedCommand:
        """The speed to have with `stop_m` still to go; v = sqrt(2 a d), d less what the delay uses up."""
        if stop_m <= self.arrived_m:
            firm = self.decel_mps2_firm if stop_m < -0.5 else self.decel_mps2
            return SpeedCommand(name, 0.0, -firm)
        free_m = max(stop_m - self.delay_s * speed_mps, 0.0)
        allowed_mps = math.sqrt(2.0 * self.decel_mps2 * free_m)
        if speed_mps <= allowed_mps:
            return SpeedCommand(name, allowed_mps, -self.decel_mps2 if speed_mps > 0.9 * allowed_mps else 0.0)
        needed_mps2 = speed_mps**2 / (2.0 * max(free_m, 0.05))
        return SpeedCommand(name, allowed_mps, -min(max(needed_mps2, self.decel_mps2), self.decel_mps2_firm))
