"""Throttle and brake for an acceleration, and at a stand."""

import msgspec

from vehicle_agent.brake_map import BrakeMap
from vehicle_agent.control.actuators import Drivetrain


class PedalState(msgspec.Struct, frozen=True):
    """The pedals of the last tick; braking: the brake is selected; holding: the brake holds the vehicle."""

    throttle_ratio: float = 0.0
    brake_ratio: float = 0.0
    braking: bool = False
    holding: bool = True


class PedalController(msgspec.Struct, frozen=True):
    """The inverse of the response.

    hysteresis_mps2  pedals change this far beyond coasting, so that they do not alternate
    hold_ratio, hold_ratio_1ps  the brake that holds the vehicle, and the rate at which it is applied
    release_1ps      rate at which it is released
    """

    throttle_ratio_max: float = 0.8
    hysteresis_mps2: float = 0.06
    hold_ratio: float = 0.5
    hold_ratio_1ps: float = 1.0
    release_1ps: float = 5.0
    dt_s: float = 0.02

    def step(
        self, pedals: PedalState, accel_mps2: float, speed_mps: float, drivetrain: Drivetrain
    ) -> PedalState:
        """The pedals that give a vehicle of this response, on level ground, this acceleration."""
        d = drivetrain
        above_coast = accel_mps2 + d.coast_mps2
        braking = above_coast < (self.hysteresis_mps2 if pedals.braking else -self.hysteresis_mps2)
        if braking:
            pedal = BrakeMap(d.brake_gain, d.brake_offset, d.brake_knee_mps2).brake_ratio(-above_coast)
            return PedalState(0.0, pedal, True, False)
        fade = max(0.2, 1.0 - speed_mps / d.throttle_fade_mps)
        throttle = min(max(above_coast * d.throttle_per_mps2 / fade, 0.0), self.throttle_ratio_max)
        # If the brake were released at once, the vehicle would roll back before the throttle acts.
        brake = max(0.0, pedals.brake_ratio - self.release_1ps * self.dt_s) if pedals.holding else 0.0
        return PedalState(throttle, brake, False, brake > 0.0)

    def hold(self, pedals: PedalState) -> PedalState:
        """The pedals that hold the vehicle: the brake is applied gently."""
        reach = self.hold_ratio_1ps * self.dt_s
        brake = pedals.brake_ratio + min(max(self.hold_ratio - pedals.brake_ratio, -reach), reach)
        return PedalState(0.0, brake, True, True)
