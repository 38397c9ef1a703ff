"""How much stronger the brake is than its map says, learned from steady brakings."""

import math

import msgspec

from vehicle_agent.signals import Ego, VehicleMotion


class BrakeGainState(msgspec.Struct, frozen=True):
    """share: deceleration over that of the map. steady_s: time for which command_mps2 held."""

    share: float = 1.0
    steady_s: float = 0.0
    command_mps2: float = 0.0


class BrakeGain(msgspec.Struct, frozen=True):
    """A slow mean of measured over mapped deceleration, within bounds.

    settle_s        time constant, of braking: some stops. Slopes up and down average out over it
    after_s         a braking counts after this time of a steady command: dead time, lag and the filter of the
                    acceleration are over
    steady_mps2     a command that moves farther is another braking
    decel_mps2_min  a gentler braking says more of the road than of the brake
    foreign_ratio   a reported brake this far above the command is the guard's, the gate's or the driver's
    share_min, share_max  a weaker or stronger brake is a fault or another vehicle's profile
    """

    coast_mps2: float = 0.12
    settle_s: float = 15.0
    after_s: float = 1.2
    steady_mps2: float = 0.15
    decel_mps2_min: float = 0.3
    speed_mps_min: float = 0.3
    foreign_ratio: float = 0.1
    share_min: float = 0.7
    share_max: float = 1.4
    dt_s: float = 0.02

    def is_at_bound(self, state: BrakeGainState) -> bool:
        return not self.share_min < state.share < self.share_max

    def step(
        self, state: BrakeGainState, command_mps2: float, brake_ratio: float, ego: Ego, motion: VehicleMotion
    ) -> BrakeGainState:
        """The state after a tick. command_mps2, brake_ratio: commanded in the last one."""
        mapped_mps2 = (-command_mps2 - self.coast_mps2) / state.share
        braking = 0.0 < brake_ratio < 1.0 and mapped_mps2 > self.decel_mps2_min
        braking = braking and motion.brake_ratio <= brake_ratio + self.foreign_ratio
        if not (braking and ego.speed_mps > self.speed_mps_min and math.isfinite(ego.accel_mps2)):
            return BrakeGainState(state.share)
        if abs(command_mps2 - state.command_mps2) > self.steady_mps2:
            return BrakeGainState(state.share, 0.0, command_mps2)
        steady_s = state.steady_s + self.dt_s
        if steady_s < self.after_s:
            return BrakeGainState(state.share, steady_s, state.command_mps2)
        measured = (-ego.accel_mps2 - self.coast_mps2) / mapped_mps2
        bounded = min(max(measured, 0.5 * self.share_min), 2.0 * self.share_max)
        share = state.share + (bounded - state.share) * self.dt_s / self.settle_s
        share = min(max(share, self.share_min), self.share_max)
        return BrakeGainState(share, steady_s, state.command_mps2)
