"""The gate's parameters, from the vehicle profile alone."""

import math
from dataclasses import dataclass

from vehicle_agent.brake_map import BrakeMap
from vehicle_agent.config import Profile
from vehicle_agent.signals.rates import PERCEPT_AGE_NS_MAX, TICK_NS


@dataclass(frozen=True, slots=True)
class GateSettings:
    """SI units; ratios are pedal positions.

    fresh_ns          the gate brakes this long after the last accepted set: two missed ticks and half a tick
                      of slack for the scheduler
    late_ns, early_ns  a set may be this old, or this far ahead of the gate's clock
    jump_ns           two steps farther apart than this mean that the clock jumped or the gate was suspended
    reports_ns        the gate brakes this long after the module's last report: two missed at 30 Hz, and slack
    sets_lost_max     at most this many sets may be missing between two consecutive ones
    comfort_ratio, comfort_steps  the brake sequence begins with this pedal, for this many steps of 20 ms
    rate_slack        the steering may be commanded this many times faster than its limit, for jitter
    stuck_*           steering is stuck when `confirmed` reports in a row lie farther than stuck_rad from all
                      angles commanded steer_delay_s +- stuck_slack_s ago, and from a wheel that follows them
                      at slow_share of the rate
    over_*            the speed monitor's tolerance above speed_mps_max
    delay_s, brake_mps2, margin_m  of the footprint test: less room than the guard keeps, so that the guard
                      acts first; a set that brakes by `braked_ratio` already is left alone
    percept_ns        an older percept is ignored
    """

    wheelbase_m: float
    front_m: float
    half_width_m: float
    steer_rad_max: float
    steer_rate_radps_max: float
    speed_mps_max: float
    comfort_ratio: float
    steer_delay_s: float
    brake_mps2: float
    comfort_steps: int = 5
    fresh_ns: int = 2 * TICK_NS + TICK_NS // 2
    late_ns: int = 2 * TICK_NS
    early_ns: int = 5_000_000
    jump_ns: int = 100_000_000
    reports_ns: int = 90_000_000
    sets_lost_max: int = 2
    rate_slack: float = 1.5
    angle_slack_rad: float = 0.01
    over_share: float = 0.3
    over_mps: float = 0.7
    stuck_rad: float = 0.035
    stuck_slack_s: float = 0.05
    slow_share: float = 0.7
    confirmed: int = 2
    standing_mps: float = 0.1
    delay_s: float = 0.27
    margin_m: float = 0.1
    braked_ratio: float = 0.3
    percept_ns: int = PERCEPT_AGE_NS_MAX


def gate_settings(profile: Profile) -> GateSettings:
    """The gate's parameters for a profile; the comfortable brake is the pedal for 2 m/s2."""
    body, limits, response = profile.body, profile.limits, profile.response
    brakes = BrakeMap(response.brake_gain, response.brake_offset, response.brake_knee_mps2)
    return GateSettings(
        wheelbase_m=body.wheelbase_m,
        front_m=body.front_overhang_m,
        half_width_m=0.5 * body.width_m,
        steer_rad_max=math.atan(body.wheelbase_m / body.turn_radius_m_min),
        steer_rate_radps_max=limits.steer_rate_radps_max,
        speed_mps_max=limits.speed_mps_max,
        comfort_ratio=brakes.brake_ratio(2.0),
        steer_delay_s=response.steer_delay_s,
        brake_mps2=limits.decel_mps2_max,
    )
