"""Dead time and lag of the steering; bias, play, effective wheelbase and understeer of the wheels."""

from dataclasses import dataclass

import numpy as np
from numba import njit

from contract.geometry import Array, IntArray
from vehicle_agent.config import Body, Response
from vehicle_agent.control.mpc.lateral_model import dynamic_share
from vehicle_agent.identification.drive_signals import DriveSignals
from vehicle_agent.identification.pedal_fit import SUBSTEP_S, delayed, lagged
from vehicle_agent.identification.robust_fit import Fit, Prior, robust_fit

_REPORT_NOISE_RAD = 0.0005
_YAW_RATE_NOISE_RADPS = 0.003

_WINDOW_S = 3.0
_MOVING_MPS = 0.5
STEER_DEAD, STEER_LAG = range(2)
BIAS, WHEELBASE, UNDERSTEER, PLAY, TYRE_LAG = range(5)


@dataclass(frozen=True, slots=True)
class SteeringFit:
    """response: dead time and lag; turning: of the parameters above; tick_s, yaw_rate_radps, predicted_radps
    (k,) where the vehicle moves."""

    response: Fit
    turning: Fit
    gyro_bias_radps: float
    tick_s: Array
    yaw_rate_radps: Array
    predicted_radps: Array


def fit_steering(drive: DriveSignals, prior: Response, body: Body) -> SteeringFit:
    """The steering's response that predicts the reported angles and the yaw rates best."""
    response = _fit_response(drive, prior)
    gyro_bias = gyro_bias_radps(drive)
    speed = np.interp(drive.tick_s, drive.report_s, drive.speed_mps)
    wheels = np.interp(drive.tick_s, drive.report_s, drive.steer_rad)
    inside = (drive.tick_s > drive.report_s[0]) & (drive.tick_s < drive.report_s[-1])
    usable = np.flatnonzero(inside & (speed > _MOVING_MPS) & np.isfinite(drive.yaw_rate_radps))
    measured = drive.yaw_rate_radps[usable] - gyro_bias

    def predicted(p: Array) -> Array:
        rates = yaw_rates(wheels, speed, p[BIAS], p[WHEELBASE], p[UNDERSTEER], p[PLAY])
        share = 1.0 - np.exp(-0.02 / max(p[TYRE_LAG], 1e-3))
        return first_order(rates, share)[usable]

    priors = (
        Prior(prior.steer_bias_rad, 0.03, -0.15, 0.15),
        Prior(body.wheelbase_m, 0.3, 0.5 * body.wheelbase_m, 1.5 * body.wheelbase_m),
        Prior(0.0, 0.01, -0.05, 0.05),
        Prior(0.004, 0.006, 0.0, 0.08),
        Prior(0.03, 0.03, 0.001, 0.4),
    )
    windows = np.floor((drive.tick_s[usable] - drive.tick_s[0]) / _WINDOW_S).astype(np.int64)
    turning = robust_fit(lambda p: (measured - predicted(p)) / _YAW_RATE_NOISE_RADPS, priors, windows)
    return SteeringFit(
        response, turning, gyro_bias, drive.tick_s[usable], measured, predicted(turning.values)
    )


def gyro_bias_radps(drive: DriveSignals) -> float:
    """The gyroscope's bias: how the sum of its rates leaves the heading of localization."""
    rates = np.where(np.isfinite(drive.yaw_rate_radps), drive.yaw_rate_radps, 0.0)
    steps_s = np.diff(drive.tick_s, prepend=drive.tick_s[0])
    turned = np.cumsum(0.5 * (rates + np.concatenate((rates[:1], rates[:-1]))) * steps_s)
    known = np.isfinite(drive.heading_rad)
    gap = np.unwrap(turned[known] - drive.heading_rad[known])
    return float(np.polyfit(drive.tick_s[known] - drive.tick_s[0], gap, 1)[0])


def _fit_response(drive: DriveSignals, prior: Response) -> Fit:
    grid = np.arange(float(drive.tick_s[0]), float(drive.tick_s[-1]), SUBSTEP_S)
    latest = np.clip(np.searchsorted(drive.tick_s, grid + 1e-9) - 1, 0, None)
    commanded = drive.commands[latest, 0]
    at = np.clip(np.searchsorted(drive.tick_s, drive.report_s) - 1, 0, len(drive.tick_s) - 1)
    driving = drive.driving[at] & drive.driving[np.maximum(at - 50, 0)]
    chosen: IntArray = np.flatnonzero(driving & (drive.report_s < grid[-1]))
    times, reported = drive.report_s[chosen], drive.steer_rad[chosen]

    def residuals(p: Array) -> Array:
        wheels = lagged(delayed(commanded, p[STEER_DEAD]), p[STEER_LAG])
        # The value of a step holds at its end.
        expected = np.interp(times, grid + SUBSTEP_S, wheels)
        error: Array = (reported - expected) / _REPORT_NOISE_RAD
        return error

    priors = (
        Prior(prior.steer_dead_s, 0.2, 0.0, 1.0),
        Prior(prior.steer_lag_s, 0.1, 0.005, 1.0),
    )
    windows = np.floor((times - times[0]) / _WINDOW_S).astype(np.int64)
    return robust_fit(residuals, priors, windows)


@njit(cache=True)
def yaw_rates(
    wheels: Array, speeds: Array, bias: float, wheelbase: float, understeer: float, play: float
) -> Array:
    """(n,) steady yaw rates of reported wheel angles (n,) and speeds (n,), by control's model of the tyres.

    play  the wheels follow only after the steering has turned by this much the other way
    """
    rates = np.empty(len(wheels))
    half = 0.5 * play
    played = wheels[0]
    for k in range(len(wheels)):
        played = min(max(played, wheels[k] - half), wheels[k] + half)
        v = speeds[k]
        rates[k] = v * np.tan(played + bias) / (wheelbase + understeer * dynamic_share(v) * v * v)
    return rates


@njit(cache=True)
def first_order(values: Array, share: float) -> Array:
    """(n,) values after a first-order lag; share of the difference that is made up in a step."""
    result = np.empty(len(values))
    result[0] = values[0]
    for k in range(1, len(values)):
        result[k] = result[k - 1] + share * (values[k] - result[k - 1])
    return result
