import math

import numpy as np
import pytest

from contract.geometry import Array
from simulator.sensors.inertial_unit import InertialNoise, InertialUnit
from simulator.sensors.scene.ground import Ground, GroundParams
from simulator.sensors.wheel_odometry import WheelErrors, WheelOdometry
from tests.simulator.sensors.scene.campus import a_street

QUIET = InertialNoise(*([0.0] * 9))
PERFECT = WheelErrors(0.0, 0.0, 0.0, 0.0, tick_rad=1e-6)
EVERY_10_MS = np.arange(0, 2_000_000_000, 10_000_000, dtype=np.int64)


def circle(speed_mps: float, radius_m: float, pitch_rad: float = 0.0, roll_rad: float = 0.0):
    """T_map_base on a circle to the left, with a constant attitude against the horizontal."""
    cp, sp, cr, sr = math.cos(pitch_rad), math.sin(pitch_rad), math.cos(roll_rad), math.sin(roll_rad)
    tilt = np.array([[cp, 0.0, sp], [0.0, 1.0, 0.0], [-sp, 0.0, cp]]) @ np.array(
        [[1.0, 0.0, 0.0], [0.0, cr, -sr], [0.0, sr, cr]]
    )

    def poses(times_ns: np.ndarray) -> Array:
        yaw = speed_mps / radius_m * times_ns * 1e-9
        found: Array = np.zeros((len(yaw), 4, 4))
        turn = np.zeros((len(yaw), 3, 3))
        turn[:, 0, 0] = turn[:, 1, 1] = np.cos(yaw)
        turn[:, 1, 0], turn[:, 0, 1], turn[:, 2, 2] = np.sin(yaw), -np.sin(yaw), 1.0
        found[:, :3, :3] = turn @ tilt
        found[:, 0, 3], found[:, 1, 3] = radius_m * np.sin(yaw), -radius_m * np.cos(yaw)
        found[:, 3, 3] = 1.0
        return found

    return poses


def unit(noise: InertialNoise = QUIET, seed: int = 1) -> InertialUnit:
    return InertialUnit(np.eye(4), noise, np.random.default_rng(seed))


def test_circle_shows_centripetal_force_gravity_and_yaw_rate() -> None:
    samples = unit().samples(circle(4.0, 10.0), EVERY_10_MS)
    assert samples.specific_force_mps2.mean(axis=0) == pytest.approx([0.0, 1.6, 9.81], abs=1e-3)
    assert samples.rates_radps.mean(axis=0) == pytest.approx([0.0, 0.0, 0.4], abs=1e-6)


def test_nose_up_and_left_side_up_show_in_the_force_at_rest() -> None:
    # A positive pitch about y lowers the nose.
    force = unit().samples(circle(0.0, 10.0, pitch_rad=-0.05, roll_rad=0.02), EVERY_10_MS).specific_force_mps2
    assert force[0, 0] == pytest.approx(9.81 * math.sin(0.05), abs=1e-6)
    assert force[0, 1] == pytest.approx(9.81 * math.sin(0.02) * math.cos(0.05), abs=1e-6)


def test_crown_of_the_road_shows_in_the_unit_of_a_parked_vehicle() -> None:
    ground = Ground(a_street(), 3, GroundParams(grade_ratio=0.0))
    pose = ground.poses(np.array([[30.0, -1.75, 0.0]]))
    force = unit().samples(lambda t: np.repeat(pose, len(t), axis=0), EVERY_10_MS).specific_force_mps2
    assert force[0, 1] == pytest.approx(9.81 * 0.02, rel=0.05)


def test_bias_walks_on_from_call_to_call() -> None:
    noise = InertialNoise(*([0.0] * 6), rate_walk_radps=0.01)
    ends = []
    for seed in range(200):
        one = unit(noise, seed)
        one.samples(circle(0.0, 1.0), EVERY_10_MS)
        ends.append(one.samples(circle(0.0, 1.0), EVERY_10_MS + 2_000_000_000).rates_radps[-1, 2])
    assert np.std(ends) == pytest.approx(0.01 * math.sqrt(3.99), rel=0.15)


def test_units_of_other_seeds_have_other_biases_and_scales() -> None:
    still = circle(0.0, 1.0)
    means = [
        unit(InertialNoise(), seed).samples(still, EVERY_10_MS).specific_force_mps2.mean(axis=0)
        for seed in (1, 2)
    ]
    assert np.abs(means[0] - means[1]).max() > 0.003
    same = [unit(InertialNoise(), 1).samples(still, EVERY_10_MS).rates_radps.tobytes() for _ in range(2)]
    assert same[0] == same[1]


def test_perfect_wheels_give_speed_and_yaw_rate() -> None:
    readings = WheelOdometry(PERFECT, np.random.default_rng(1)).readings(circle(3.0, 12.0), EVERY_10_MS)
    assert readings.speed_mps.mean() == pytest.approx(3.0, abs=1e-3)
    assert readings.yaw_rate_radps.mean() == pytest.approx(0.25, abs=1e-3)


def test_wheels_that_pull_uphill_report_too_much_way() -> None:
    errors = WheelErrors(0.0, 0.0, 0.006, 0.0, tick_rad=1e-6)
    uphill = WheelOdometry(errors, np.random.default_rng(1)).readings(
        lambda t: straight(t, 3.0, slope=0.05), EVERY_10_MS
    )
    assert uphill.speed_mps.mean() == pytest.approx(3.0 * (1.0 + 0.006 * 9.81 * 0.05), rel=2e-4)


def straight(times_ns: np.ndarray, speed_mps: float, slope: float) -> Array:
    angle = math.atan(slope)
    found: Array = np.tile(np.eye(4), (len(times_ns), 1, 1))
    found[:, 0, 0] = found[:, 2, 2] = math.cos(angle)
    found[:, 2, 0], found[:, 0, 2] = math.sin(angle), -math.sin(angle)
    way = speed_mps * times_ns * 1e-9
    found[:, 0, 3], found[:, 2, 3] = way * math.cos(angle), way * math.sin(angle)
    return found


def test_worn_tyre_turns_the_odometry() -> None:
    errors = WheelErrors(0.0, 0.01, 0.0, 0.0, tick_rad=1e-6)
    rates = [
        WheelOdometry(errors, np.random.default_rng(seed)).readings(
            lambda t: straight(t, 3.0, 0.0), EVERY_10_MS
        ).yaw_rate_radps.mean()
        for seed in range(5)
    ]  # fmt: skip
    assert max(abs(rate) for rate in rates) > 0.01


def test_whole_ticks_lose_no_way() -> None:
    errors = WheelErrors(0.0, 0.0, 0.0, 0.0)
    readings = WheelOdometry(errors, np.random.default_rng(1)).readings(
        lambda t: straight(t, 1.0, 0.0), EVERY_10_MS
    )
    assert (readings.speed_mps * 0.01).sum() == pytest.approx(1.99, abs=2.0 * math.pi / 512.0 * 0.28 + 1e-9)
    assert len(set(np.round(readings.speed_mps, 6))) > 1
