"""What a receiver or an inertial sensor says where it is, becomes what the rear axle does."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from contract.roads.model import Origin
from contract.roads.projection import project
from contract.transforms import transform_of
from vehicle_agent.receivers.mounting import Antenna, at_axle, imu_sample
from vehicle_agent.receivers.vectornav import STANDARD_GRAVITY_MPS2, InertialReading
from vehicle_agent.signals import GnssFix

angles = st.floats(-3.1, 3.1)
metres = st.floats(-4.0, 4.0)


@given(angles, metres, metres, angles, st.floats(-65.0, 65.0))
def test_the_fix_moves_by_the_lever_arm_in_the_vehicles_direction(
    yaw_rad: float, x_m: float, y_m: float, turned_rad: float, latitude_deg: float
) -> None:
    fix = GnssFix(1, latitude_deg, 121.39, yaw_rad + turned_rad, 2.0, 0.0, 0.02)
    moved = at_axle(fix, Antenna(x_m, y_m, turned_rad))
    east_m, north_m = project(Origin(latitude_deg, 121.39), moved.latitude_deg, moved.longitude_deg)
    lever = np.array(
        [math.cos(yaw_rad) * x_m - math.sin(yaw_rad) * y_m, math.sin(yaw_rad) * x_m + math.cos(yaw_rad) * y_m]
    )
    assert [east_m, north_m] == pytest.approx((-lever).tolist(), abs=2e-3)
    assert math.cos(moved.heading_rad - yaw_rad) == pytest.approx(1.0, abs=1e-9)
    assert (moved.stamp_ns, moved.position_std_m, moved.speed_mps) == (1, 0.02, 2.0)


def test_the_axle_is_slower_than_an_antenna_ahead_of_it_in_a_turn() -> None:
    """At 3 m/s and 0.5 rad/s an antenna 2 m ahead, 0.4 m to the left goes 2.8 m/s ahead, 1 m/s aside."""
    fix = GnssFix(1, 31.0, 121.0, 0.0, math.hypot(2.8, 1.0), 0.5, 0.02)
    assert at_axle(fix, Antenna(2.0, 0.4)).speed_mps == pytest.approx(3.0)


@given(st.floats(-0.2, 0.2), st.floats(-0.2, 0.2), st.floats(-2.0, 2.0), st.floats(-1.0, 1.0))
def test_gravity_is_taken_out_on_slopes_and_however_the_sensor_is_mounted(
    pitch_rad: float, roll_rad: float, accel_mps2: float, yaw_rate_radps: float
) -> None:
    """The sensor sits level in the vehicle; the road climbs (pitch) and leans to the right (roll)."""
    up_frd = np.array(
        [
            math.sin(pitch_rad),
            -math.sin(roll_rad) * math.cos(pitch_rad),
            -math.cos(roll_rad) * math.cos(pitch_rad),
        ]
    )
    accel = np.array([accel_mps2, 0.0, 0.0]) + STANDARD_GRAVITY_MPS2 * up_frd
    rates = np.array([0.0, 0.0, -yaw_rate_radps])
    sample = imu_sample(InertialReading(9, accel, rates, roll_rad, pitch_rad), np.eye(3))
    assert sample.stamp_ns == 9
    assert sample.accel_mps2 == pytest.approx(accel_mps2, abs=1e-9)
    assert sample.yaw_rate_radps == pytest.approx(yaw_rate_radps)


def test_a_sensor_that_looks_back_says_the_same_of_the_vehicle() -> None:
    """It is turned by half a turn about the vertical: its x axis is the vehicle's back."""
    turn = transform_of(0.0, 0.0, math.pi, np.zeros(3))[:3, :3]
    reading = InertialReading(
        1, np.array([-0.7, 0.0, -STANDARD_GRAVITY_MPS2]), np.array([0.0, 0.0, -0.2]), 0.0, 0.0
    )
    sample = imu_sample(reading, turn)
    assert sample.accel_mps2 == pytest.approx(0.7)
    assert sample.yaw_rate_radps == pytest.approx(0.2)


def test_without_an_attitude_the_road_counts_as_level() -> None:
    reading = InertialReading(1, np.array([0.3, 0.0, -9.8]), np.zeros(3), None, None)
    assert imu_sample(reading, np.eye(3)).accel_mps2 == pytest.approx(0.3)
