"""From an acceleration to throttle and brake, and how to stand."""

import msgspec

from vehicle_agent.brake_map import BrakeMap
from vehicle_agent.control.actuators import Drivetrain


class PedalState(msgspec.Struct, frozen=True):
    """The pedals of the last tick; braking: the foot is on the brake's side; holding: the vehicle is kept
    standing."""

    throttle_ratio: float = 0.0
    brake_ratio: float = 0.0
    braking: bool = False
    holding: bool = True


class PedalController(msgspec.Struct, frozen=True):
    """The inverse of the identified response.

    change_mps2     the foot changes pedals this far beyond coasting, so that it does not dance between them
    hold_ratio, hold_ratio_1ps  the brake that keeps the vehicle standing, and how fast it comes
    release_1ps     how fast it goes
    """

    drivetrain: Drivetrain = Drivetrain()
    throttle_ratio_max: float = 0.8
    change_mps2: float = 0.06
    hold_ratio: float = 0.5
    hold_ratio_1ps: float = 1.0
    release_1ps: float = 5.0
    dt_s: float = 0.02

    def step(self, foot: PedalState, accel_mps2: float, speed_mps: float) -> PedalState:
        """The pedals that give a nominal vehicle on the level this acceleration."""
        d = self.drivetrain
        beyond = accel_mps2 + d.coast_mps2
        braking = beyond < (self.change_mps2 if foot.braking else -self.change_mps2)
        if braking:
            pedal = BrakeMap(d.brake_gain, d.brake_offset, d.brake_knee_mps2).brake_ratio(-beyond)
            return PedalState(0.0, pedal, True, False)
        fade = max(0.2, 1.0 - speed_mps / d.throttle_fade_mps)
        throttle = min(max(beyond * d.throttle_per_mps2 / fade, 0.0), self.throttle_ratio_max)
        # Letting go of the brake at once would let the vehicle roll back before the throttle has come.
        brake = max(0.0, foot.brake_ratio - self.release_1ps * self.dt_s) if foot.holding else 0.0
        return PedalState(throttle, brake, False, brake > 0.0)

    def held(self, foot: PedalState) -> PedalState:
        """Keep standing: the brake comes gently."""
        reach = self.hold_ratio_1ps * self.dt_s
        brake = foot.brake_ratio + min(max(self.hold_ratio - foot.brake_ratio, -reach), reach)
        return PedalState(0.0, brake, True, True)
