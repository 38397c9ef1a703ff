"""When what control learns of the vehicle ends at its bound: the vehicle is not the one of its profile."""

import msgspec

from vehicle_agent.signals import Ego, Fault, VehicleMotion

# A correction with noise is at its bound from this share of it on.
AT_BOUND_SHARE = 0.98


class LearnedBoundsState(msgspec.Struct, frozen=True):
    """For how long each correction has been at its bound; the present faults."""

    steering_s: float = 0.0
    pedals_s: float = 0.0
    faults: tuple[Fault, ...] = ()


class LearnedBounds(msgspec.Struct, frozen=True):
    """A correction that stays at its bound no longer corrects, so the vehicle must not go on by it.

    after_s       a correction at its bound for this long is a fault; time off the bound counts down
    standing_mps  a slower vehicle stands: it shows nothing, and the fault ends. What was learned begins
                  again from the profile, so that a vehicle that was repaired, or was only pushed, drives
                  again after an operator's resume. One that is still unlike its profile stops again
    """

    after_s: float = 1.5
    standing_mps: float = 0.1
    dt_s: float = 0.02

    def step(
        self,
        state: LearnedBoundsState,
        steering_at_bound: bool,
        pedals_at_bound: bool,
        ego: Ego,
        motion: VehicleMotion,
    ) -> tuple[LearnedBoundsState, bool]:
        """(the state after this tick, what was learned must begin again)."""
        if not motion.enabled or abs(motion.speed_mps) < self.standing_mps:
            return LearnedBoundsState(), bool(state.faults)
        steering_s = self._counted(state.steering_s, steering_at_bound)
        pedals_s = self._counted(state.pedals_s, pedals_at_bound)
        known = {fault.code: fault for fault in state.faults}
        faults = list(known.values())
        if steering_s >= self.after_s and "steering_unlike_profile" not in known:
            faults.append(Fault("steering_unlike_profile", "stop", ego.stamp_ns))
        if pedals_s >= self.after_s and "pedals_unlike_profile" not in known:
            faults.append(Fault("pedals_unlike_profile", "stop", ego.stamp_ns))
        return LearnedBoundsState(steering_s, pedals_s, tuple(faults)), False

    def _counted(self, at_bound_s: float, at_bound: bool) -> float:
        return max(0.0, at_bound_s + (self.dt_s if at_bound else -self.dt_s))
