"""Receivers and inertial sensors where they are on the vehicle: what they say, of its rear axle. Pure."""

import math

import msgspec
import numpy as np

from contract.geometry import Array, wrap_angle
from vehicle_agent.receivers.vectornav import STANDARD_GRAVITY_MPS2, InertialReading
from vehicle_agent.signals import GnssFix, ImuSample

# WGS 84.
_EQUATOR_M, _ECCENTRICITY2 = 6_378_137.0, 6.694379990141e-3
# From x forward, y right, z down to x forward, y left, z up (REP-103).
_FLU_FRD = np.diag([1.0, -1.0, -1.0])


class Antenna(msgspec.Struct, frozen=True):
    """x_m, y_m  of the antenna in the vehicle's frame; yaw_rad: of the direction that its heading is of."""

    x_m: float = 0.0
    y_m: float = 0.0
    yaw_rad: float = 0.0


def at_axle(fix: GnssFix, antenna: Antenna) -> GnssFix:
    """The fix of an antenna as one of the rear axle's centre.

    The axle's own speed is that of the antenna, less the turning of the vehicle about the axle.
    """
    yaw_rad = wrap_angle(fix.heading_rad - antenna.yaw_rad)
    cos, sin = math.cos(yaw_rad), math.sin(yaw_rad)
    east_m = -(cos * antenna.x_m - sin * antenna.y_m)
    north_m = -(sin * antenna.x_m + cos * antenna.y_m)
    latitude_rad = math.radians(fix.latitude_deg)
    bend = 1.0 - _ECCENTRICITY2 * math.sin(latitude_rad) ** 2
    meridian_m = _EQUATOR_M * (1.0 - _ECCENTRICITY2) / bend**1.5
    parallel_m = _EQUATOR_M / math.sqrt(bend) * math.cos(latitude_rad)
    swing_mps = fix.yaw_rate_radps * antenna.x_m
    ahead_mps = math.sqrt(max(0.0, fix.speed_mps**2 - swing_mps**2))
    return msgspec.structs.replace(
        fix,
        latitude_deg=fix.latitude_deg + math.degrees(north_m / meridian_m),
        longitude_deg=fix.longitude_deg + math.degrees(east_m / parallel_m),
        heading_rad=yaw_rad,
        speed_mps=ahead_mps + fix.yaw_rate_radps * antenna.y_m,
    )


def imu_sample(reading: InertialReading, R_base_sensor: Array) -> ImuSample:
    """The vehicle's acceleration ahead and its yaw rate. R_base_sensor: (3, 3), both frames x forward, z up.

    Without an attitude of the sensor the road counts as level: 1 degree of slope is 0.17 m/s2.
    """
    accel_base = R_base_sensor @ _FLU_FRD @ reading.accel_sensor_mps2
    rates_base = R_base_sensor @ _FLU_FRD @ reading.rates_sensor_radps
    gravity_mps2 = 0.0
    if reading.pitch_rad is not None and reading.roll_rad is not None:
        up_sensor = _FLU_FRD @ _up_frd(reading.roll_rad, reading.pitch_rad)
        gravity_mps2 = STANDARD_GRAVITY_MPS2 * float((R_base_sensor @ up_sensor)[0])
    return ImuSample(reading.stamp_ns, float(accel_base[0]) - gravity_mps2, float(rates_base[2]))


def _up_frd(roll_rad: float, pitch_rad: float) -> Array:
    """The direction up in the sensor's frame (x forward, y right, z down)."""
    return -np.array(
        [
            -math.sin(pitch_rad),
            math.sin(roll_rad) * math.cos(pitch_rad),
            math.cos(roll_rad) * math.cos(pitch_rad),
        ]
    )
