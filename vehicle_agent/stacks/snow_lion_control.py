"""The Snow Lion stack's control with the profile's parameters."""

import math

from vehicle_agent.config import Profile
from vehicle_agent.control.actuators import Drivetrain
from vehicle_agent.control.mpc.lateral import LateralMpc
from vehicle_agent.control.mpc.lateral_model import Chassis
from vehicle_agent.control.mpc.longitudinal import LongitudinalMpc
from vehicle_agent.control.trajectory.observer import Observer
from vehicle_agent.control.trajectory.pedals import PedalController
from vehicle_agent.control.trajectory.speed_control import SpeedControl
from vehicle_agent.control.trajectory.steer_control import SteerControl
from vehicle_agent.control.trajectory.trajectory_control import TrajectoryControl
from vehicle_agent.signals.rates import TICK_NS

_TICK_S = TICK_NS * 1e-9
# Share of full braking that control uses; the rest is for emergencies.
_PLANNED_BRAKING = 0.45
# A slower steering needs more than two seconds to correct an error. The horizon must contain the correction:
# with a shorter one the rate bound makes the MPC overshoot, more each time.
_SLOW_WHEEL_RADPS = 0.2
_STEP_S, _SLOW_STEP_S = 0.05, 0.1


def control(profile: Profile) -> TrajectoryControl:
    """Model predictive control with the vehicle's identified response and limits."""
    body, limits, driving = profile.body, profile.limits, profile.driving
    chassis, drivetrain = _chassis(profile), _drivetrain(profile)
    return TrajectoryControl(
        observer=Observer(
            drivetrain=drivetrain,
            chassis=chassis,
            steer_bias_rad=profile.response.steer_bias_rad,
            dt_s=_TICK_S,
        ),
        speed=SpeedControl(
            mpc=LongitudinalMpc(
                accel_mps2_max=limits.accel_mps2_max,
                decel_mps2_max=limits.decel_mps2_max * _PLANNED_BRAKING,
                jerk_mps3_max=driving.jerk_mps3_max,
            ),
            pedal_controller=PedalController(dt_s=_TICK_S),
            decel_mps2_comfort=limits.decel_mps2_comfort,
            dt_s=_TICK_S,
        ),
        steer=SteerControl(
            mpc=LateralMpc(
                chassis=chassis,
                steer_rad_max=math.atan(body.wheelbase_m / body.turn_radius_m_min),
                steer_rate_radps_max=limits.steer_rate_radps_max,
                dt_s=_STEP_S if limits.steer_rate_radps_max >= _SLOW_WHEEL_RADPS else _SLOW_STEP_S,
            ),
            dt_s=_TICK_S,
        ),
        accel_mps2=0.75 * limits.accel_mps2_max,
        decel_mps2_comfort=limits.decel_mps2_comfort,
        dt_s=_TICK_S,
    )


def _chassis(profile: Profile) -> Chassis:
    body, tyres = profile.body, profile.tyres
    front_m = tyres.cog_ratio * body.wheelbase_m
    return Chassis(
        mass_kg=body.mass_kg,
        yaw_inertia_kgm2=tyres.yaw_inertia_kgm2,
        cog_to_front_m=front_m,
        cog_to_rear_m=body.wheelbase_m - front_m,
        cornering_front_npr=tyres.cornering_front_npr,
        cornering_rear_npr=tyres.cornering_rear_npr,
        steer_lag_s=profile.response.steer_lag_s,
    )


def _drivetrain(profile: Profile) -> Drivetrain:
    response = profile.response
    return Drivetrain(
        steer_delay_s=response.steer_dead_s,
        steer_lag_s=response.steer_lag_s,
        throttle_delay_s=response.throttle_dead_s,
        throttle_lag_s=response.throttle_lag_s,
        brake_delay_s=response.brake_dead_s,
        brake_lag_s=response.brake_lag_s,
        throttle_per_mps2=response.throttle_per_mps2,
        throttle_fade_mps=response.throttle_fade_mps,
        brake_gain=response.brake_gain,
        brake_offset=response.brake_offset,
        brake_knee_mps2=response.brake_knee_mps2,
        coast_mps2=response.coast_mps2,
    )
