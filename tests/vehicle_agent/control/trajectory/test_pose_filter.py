"""The filter finds millimetres in centimetres of noise, and what nobody measures."""

import math

import numpy as np
import pytest

from contract.geometry import Pose2
from vehicle_agent.control.trajectory.pose_filter import (
    COMPLIANCE,
    GYRO_BIAS,
    STEER_BIAS,
    PoseFilter,
    initial_filter_state,
    predict,
    reset_at,
    update_yaw_rate,
)
from vehicle_agent.control.trajectory.pose_filter import update_pose as take_fix

BASE_M, UNDERSTEER, SLIP, DT_S = 2.6, 0.0025, 0.0096, 0.02
NOISE = (0.02, math.radians(0.3))


def weaving(
    seconds: float, seed: int, steer_bias: float, gyro_bias: float, softness: float
) -> tuple[np.ndarray, np.ndarray]:
    """(errors (n, 3) of x, y, yaw, the mean (6,) at the end) of a drive at 3 m/s that turns left and
    right."""
    rng = np.random.default_rng(seed)
    n = PoseFilter().row()
    x, y, yaw, v = 0.0, 0.0, 0.0, 3.0
    belief = reset_at(initial_filter_state(), Pose2(x, y, yaw), *NOISE, 0)
    mean, P = belief.mean, belief.covariance
    errors = []
    for k in range(round(seconds / DT_S)):
        steer = 0.12 * math.sin(0.4 * k * DT_S)
        rate = v * math.tan(steer + steer_bias) / (BASE_M + softness * UNDERSTEER * v * v)
        course = yaw + 0.5 * rate * DT_S - softness * SLIP * v * rate
        x, y, yaw = x + v * DT_S * math.cos(course), y + v * DT_S * math.sin(course), yaw + rate * DT_S
        gyro = rate + gyro_bias + rng.normal(0.0, 0.003)
        predict(mean, P, v, gyro, DT_S, SLIP, n)
        update_yaw_rate(mean, P, v, gyro, steer, BASE_M, UNDERSTEER, n)
        told = np.array((x, y, yaw)) + rng.normal(0.0, 1.0, 3) * (NOISE[0], NOISE[0], NOISE[1])
        assert take_fix(mean, P, *told.tolist(), *NOISE, n)
        errors.append((mean[0] - x, mean[1] - y, math.remainder(mean[2] - yaw, 2.0 * math.pi)))
    return np.array(errors), mean


@pytest.mark.parametrize("seed", range(3))
def test_the_pose_is_good_to_millimetres(seed: int) -> None:
    errors, _ = weaving(60.0, seed, 0.01, 0.0005, 1.0)
    settled = errors[500:]
    assert settled[:, :2].std() < 0.005
    assert np.abs(settled[:, :2]).max() < 0.018
    assert settled[:, 2].std() < math.radians(0.06)


@pytest.mark.parametrize("bias", [-0.0105, 0.0, 0.0105])
@pytest.mark.parametrize("softness", [0.8, 1.2])
def test_what_nobody_measures_is_found(bias: float, softness: float) -> None:
    _, mean = weaving(60.0, 1, bias, 0.0005, softness)
    assert mean[STEER_BIAS] == pytest.approx(bias, abs=math.radians(0.06))
    assert mean[GYRO_BIAS] == pytest.approx(0.0005, abs=0.0004)
    assert mean[COMPLIANCE] == pytest.approx(softness, abs=0.2)


def test_tyres_that_do_not_slip_are_found_too() -> None:
    _, mean = weaving(60.0, 2, 0.0, 0.0, 0.0)
    assert mean[COMPLIANCE] < 0.2


def test_a_pose_beyond_the_gate_is_not_taken() -> None:
    belief = reset_at(initial_filter_state(), Pose2(0.0, 0.0, 0.0), *NOISE, 0)
    mean, P = belief.mean.copy(), belief.covariance.copy()
    n = PoseFilter().row()
    assert not take_fix(mean, P, 5.0, 0.0, 0.0, *NOISE, n)
    assert not take_fix(mean, P, 0.0, 0.0, 1.0, *NOISE, n)
    assert np.array_equal(mean, belief.mean)
    assert take_fix(mean, P, 0.05, 0.0, 2.0 * math.pi, *NOISE, n)


def test_a_turn_of_the_heading_past_pi_is_no_surprise() -> None:
    belief = reset_at(initial_filter_state(), Pose2(0.0, 0.0, math.pi - 0.01), *NOISE, 0)
    n = PoseFilter().row()
    assert take_fix(belief.mean, belief.covariance, 0.0, 0.0, -math.pi + 0.01, *NOISE, n)
    assert abs(math.remainder(belief.mean[2] - math.pi, 2.0 * math.pi)) < 0.02
