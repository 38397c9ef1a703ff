"""The linear half of the twist controller: a speed command becomes throttle or brake (GEM, Fig. 3)."""

import math

import msgspec

from vehicle_agent.brake_map import BrakeMap


class TwistState(msgspec.Struct, frozen=True):
    """What the controller remembers: the limited command, the filtered IMU, the integral, the last pedals."""

    accel_command_mps2: float = 0.0
    accel_filtered_mps2: float = 0.0
    integral_ratio: float = 0.0
    throttle_ratio: float = 0.0
    brake_ratio: float = 0.0


class TwistController(msgspec.Struct, frozen=True):
    """speed error -> P -> limited acceleration command -> PI throttle, or the open-loop brake map.

    speed_gain_1ps    acceleration command per speed error
    accel_filter_s    low-pass on the IMU; the paper's tau is 2 s, identify it per vehicle. It starts again
                      after braking: otherwise the throttle would act against a past deceleration
    throttle_per_mps2, throttle_integral   PI on the acceleration error (1/(m/s2), 1/(m/s2)/s)
    throttle_feed     pedal per commanded acceleration: feed-forward of the PI
    throttle_filter_s the output filter "in favour of a smooth ride"
    coast_mps2        deceleration with neither pedal; the brake adds the rest
    jerk_mps3_max     rate limit of the acceleration command, full stops excepted
    hold_ratio        brake at standstill
    """

    brakes: BrakeMap = BrakeMap()
    speed_gain_1ps: float = 1.0
    accel_mps2_max: float = 0.8
    decel_mps2_max: float = 2.5
    accel_filter_s: float = 2.0
    throttle_per_mps2: float = 0.04
    throttle_integral: float = 0.08
    throttle_feed: float = 0.4
    throttle_ratio_max: float = 0.7
    throttle_filter_s: float = 0.2
    coast_mps2: float = 0.12
    jerk_mps3_max: float = 2.0
    hold_ratio: float = 0.5
    hold_below_mps: float = 0.08
    dt_s: float = 0.02

    def step(
        self,
        state: TwistState,
        wanted_mps: float,
        slope_mps2: float,
        speed_mps: float,
        accel_mps2: float,
        brake_share: float = 1.0,
    ) -> TwistState:
        """The pedals for the speed `wanted_mps`, which changes by `slope_mps2`.

        brake_share  the brake's deceleration over that of its map
        """
        if wanted_mps <= 0.0 and speed_mps < self.hold_below_mps:
            return TwistState(
                0.0, 0.0, 0.0, 0.0, _step_towards(state.brake_ratio, self.hold_ratio, 2.0 * self.dt_s)
            )
        requested = slope_mps2 + self.speed_gain_1ps * (wanted_mps - speed_mps)
        limited = min(max(requested, -self.decel_mps2_max), self.accel_mps2_max)
        command = _step_towards(state.accel_command_mps2, limited, self.jerk_mps3_max * self.dt_s)
        if command < -self.coast_mps2:
            brake = self.brakes.brake_ratio((-command - self.coast_mps2) / brake_share)
            return TwistState(command, 0.0, 0.0, 0.0, brake)
        filtered = _low_pass(state.accel_filtered_mps2, accel_mps2, self.accel_filter_s, self.dt_s)
        return self._with_throttle(state, command, filtered)

    def full_stop(self) -> TwistState:
        """The state of full braking."""
        return TwistState(-self.decel_mps2_max, 0.0, 0.0, 0.0, 1.0)

    def _with_throttle(self, state: TwistState, command: float, filtered: float) -> TwistState:
        error = command - filtered
        integral = state.integral_ratio + self.throttle_integral * error * self.dt_s
        integral = min(max(integral, 0.0), self.throttle_ratio_max)
        wanted = self.throttle_feed * (command + self.coast_mps2) + self.throttle_per_mps2 * error + integral
        wanted = min(max(wanted, 0.0), self.throttle_ratio_max)
        throttle = _low_pass(state.throttle_ratio, wanted, self.throttle_filter_s, self.dt_s)
        return TwistState(command, filtered, integral, throttle, 0.0)


def _low_pass(value: float, target: float, tau_s: float, dt_s: float) -> float:
    return target if tau_s <= 0.0 else value + (target - value) * (1.0 - math.exp(-dt_s / tau_s))


def _step_towards(value: float, target: float, step: float) -> float:
    return value + min(max(target - value, -step), step)
