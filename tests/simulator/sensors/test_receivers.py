import math
from dataclasses import replace

import numpy as np
import pytest

from contract.geometry import Pose2
from contract.roads.model import Origin
from contract.roads.projection import project
from simulator.sensors.gnss import GnssNoise, GnssReceiver
from simulator.sensors.imu import Imu, ImuNoise
from simulator.vehicle.plant import PlantView

ORIGIN = Origin(31.3, 121.4)
TRUTH = PlantView(Pose2(120.0, -80.0, 3.1), 2.0, 0.4, 0.1, 0.0, 0.0, 0.07, 0.0, 1.0)
EXACT = GnssNoise(0.0, 0.0, 0.0, 0.0)


def a_receiver(noise: GnssNoise, seed: int = 1) -> GnssReceiver:
    return GnssReceiver(ORIGIN, noise, np.random.default_rng(seed))


def offsets_m(noise: GnssNoise, count: int) -> np.ndarray:
    receiver = a_receiver(noise)
    places = []
    for k in range(count):
        fix = receiver.fix(k * 20_000_000, TRUTH)
        assert fix is not None
        places.append(project(ORIGIN, fix.latitude_deg, fix.longitude_deg))
    return np.array(places) - [120.0, -80.0]


def test_a_fix_without_noise_is_the_pose_on_the_shared_projection() -> None:
    fix = a_receiver(EXACT).fix(5, TRUTH)
    assert fix is not None
    assert project(ORIGIN, fix.latitude_deg, fix.longitude_deg) == pytest.approx((120.0, -80.0), abs=1e-6)
    assert (fix.stamp_ns, fix.heading_rad, fix.speed_mps, fix.yaw_rate_radps) == (5, 3.1, 2.0, 0.07)


def test_noise_has_two_centimetres_and_three_tenths_of_a_degree() -> None:
    assert offsets_m(GnssNoise(), 3000).std(axis=0) == pytest.approx([0.02, 0.02], rel=0.06)
    receiver = a_receiver(GnssNoise())
    fixes = [receiver.fix(0, TRUTH) for _ in range(3000)]
    headings = np.array([fix.heading_rad for fix in fixes if fix is not None])
    errors = np.remainder(headings - 3.1 + math.pi, 2.0 * math.pi) - math.pi
    assert errors.std() == pytest.approx(math.radians(0.3), rel=0.06)
    assert (np.abs(headings) <= math.pi).all()


def test_drift_wanders_slowly_and_keeps_its_spread() -> None:
    noise = GnssNoise(position_std_m=0.0, drift_std_m=0.5, drift_time_s=5.0)
    offsets = offsets_m(noise, 20_000)
    assert np.abs(np.diff(offsets, axis=0)).max() < 0.25
    assert 0.25 < offsets.std() < 0.75


def test_a_silent_receiver_gives_nothing_and_its_later_noise_is_the_same_as_without_the_outage() -> None:
    steady, interrupted = a_receiver(GnssNoise()), a_receiver(GnssNoise())
    for k in range(6):
        interrupted.silent = k in (2, 3)
        assert (interrupted.fix(k, TRUTH) is None) == interrupted.silent
        last = steady.fix(k, TRUTH)
    interrupted.silent = False
    assert last is not None
    assert interrupted.fix(6, TRUTH) == steady.fix(6, TRUTH)


def test_the_inertial_sensor_keeps_its_bias_and_spreads_around_it() -> None:
    noise = ImuNoise(0.05, 0.003, 0.01, 0.0005)
    imu = Imu(noise, np.random.default_rng(4))
    samples = [imu.sample(k, TRUTH) for k in range(4000)]
    accels = np.array([sample.accel_mps2 for sample in samples])
    assert accels.std() == pytest.approx(0.05, rel=0.05)
    assert abs(accels.mean() - 0.4) < 0.04
    assert abs(np.mean([sample.yaw_rate_radps for sample in samples]) - 0.07) < 0.003


def test_slope_shows_in_the_forward_acceleration_of_a_unit_that_feels_gravity() -> None:
    uphill = replace(TRUTH, grade_ratio=0.05)
    for gravity, expected in ((False, 0.4), (True, 0.4 + 9.81 * math.sin(math.atan(0.05)))):
        imu = Imu(ImuNoise(0.0, 0.0, 0.0, 0.0, gravity=gravity), np.random.default_rng(4))
        assert imu.sample(0, uphill).accel_mps2 == pytest.approx(expected)
