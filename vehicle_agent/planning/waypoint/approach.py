"""Coming to rest at a given place on the line."""

import math

import msgspec

from contract.wire.reasons import SpeedLimitReason
from vehicle_agent.planning.waypoint.selector import SpeedCommand


class Approach(msgspec.Struct, frozen=True):
    """Constant comfortable deceleration to the stop.

    delay_s           from a brake command to its effect; the vehicle rolls on meanwhile
    ramp_s            what the jerk limit adds to it at ramp_mps and above; a slow vehicle brakes already
    decel_mps2_firm   for a stop that is nearer than comfort allows, or already behind
    arrived_m         nearer than this the vehicle stands still
    """

    decel_mps2: float = 0.6
    decel_mps2_firm: float = 2.5
    delay_s: float = 0.25
    ramp_s: float = 0.3
    ramp_mps: float = 2.0
    arrived_m: float = 0.06

    def command(self, stop_m: float, speed_mps: float, name: SpeedLimitReason = "stop") -> SpeedCommand:
        """The speed with `stop_m` still to go.

        v = sqrt(2 a d), with d less the way driven during the delay.
        """
        if stop_m <= self.arrived_m:
            firm = self.decel_mps2_firm if stop_m < -0.5 else self.decel_mps2
            return SpeedCommand(name, 0.0, -firm)
        late_s = self.delay_s + self.ramp_s * min(1.0, speed_mps / self.ramp_mps)
        free_m = max(stop_m - late_s * speed_mps, 0.0)
        allowed_mps = math.sqrt(2.0 * self.decel_mps2 * free_m)
        needed_mps2 = speed_mps**2 / (2.0 * max(free_m, 0.05))
        # Far from the stop the deceleration that it needs is no reason to brake yet; it fades in.
        share = min(max(2.0 * needed_mps2 / self.decel_mps2 - 1.0, 0.0), 1.0)
        return SpeedCommand(name, allowed_mps, -share * min(needed_mps2, self.decel_mps2_firm))
