"""Brake and throttle maps, dead times and lags, from commands and reported speeds.

The speed of each window of the drive is predicted from its measured beginning by integrating the pedals'
accelerations. Friction and pedals depend on the speed so weakly that the measured one is used for them, and
the prediction is a sum. In a turn the vehicle also moves sideways and rotates, so the same force gives it
less acceleration: its energy is m v^2 / 2 (1 + c k^2) with the curvature k, and c is fitted too.
"""

from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from contract.geometry import Array, BoolArray, IntArray
from vehicle_agent.config import Response
from vehicle_agent.identification.drive_signals import DT_S, DriveSignals
from vehicle_agent.identification.robust_fit import Fit, Prior, robust_fit

SUBSTEP_S = 0.01
# The pedal at which throttle_per_mps2 holds; a throttle may be more or less than proportional.
THROTTLE_AT = 0.3
_GRAVITY_MPS2 = 9.81
_WINDOW_S = 3.0
_MOVING_MPS = 0.15
_SPEED_NOISE_MPS = 0.005
_REPORTS_MIN = 12
(
    BRAKE_GAIN, BRAKE_OFFSET, BRAKE_LOG_KNEE, BRAKE_FADE, THROTTLE_PER, THROTTLE_FADE, ROLLING, DRAG,
    SLOPE_X, SLOPE_Y, THROTTLE_DEAD, THROTTLE_LAG, BRAKE_DEAD, BRAKE_LAG, THROTTLE_POWER,
    TURNING,
) = range(16)  # fmt: skip


@dataclass(frozen=True, slots=True)
class PedalFit:
    """fit: of the parameters above; report_s, speed_mps, predicted_mps (k,) of the reports in windows;
    mean_mps: of the drive while it braked."""

    fit: Fit
    report_s: Array
    speed_mps: Array
    predicted_mps: Array
    mean_mps: float


def pedal_priors(prior: Response) -> tuple[Prior, ...]:
    """What is known before the drive: the order of magnitude of each parameter."""
    return (
        Prior(prior.brake_gain, 0.3, 0.02, 2.0),
        Prior(prior.brake_offset, 0.5, -1.0, 2.0),
        Prior(float(np.log(max(prior.brake_knee_mps2, 0.02))), 1.0, -6.0, 2.0),
        Prior(0.0, 0.03, -0.1, 0.15),
        Prior(prior.throttle_per_mps2, 0.3, 0.05, 3.0),
        Prior(1.0 / prior.throttle_fade_mps, 0.1, 0.0, 0.5),
        Prior(prior.coast_mps2, 0.2, -0.5, 1.5),
        Prior(0.0, 0.05, -0.2, 0.5),
        Prior(0.0, 0.03, -0.2, 0.2),
        Prior(0.0, 0.03, -0.2, 0.2),
        Prior(prior.throttle_dead_s, 0.2, 0.0, 1.0),
        Prior(prior.throttle_lag_s, 0.1, 0.005, 1.0),
        Prior(prior.brake_dead_s, 0.2, 0.0, 1.0),
        Prior(prior.brake_lag_s, 0.1, 0.005, 1.0),
        Prior(1.0, 0.15, 0.5, 2.0),
        Prior(3.0, 1.5, 0.0, 10.0),
    )


def fit_pedals(drive: DriveSignals, prior: Response, wheelbase_m: float) -> PedalFit:
    """The pedals' response that predicts the drive's speeds best."""
    model = _PedalModel(drive, wheelbase_m)
    fit = robust_fit(model.residuals, pedal_priors(prior), model.windows)
    braking = (drive.commands[:, 2] > 0.05) & drive.driving
    speed = np.interp(drive.tick_s, drive.report_s, drive.speed_mps)
    mean_mps = float(speed[braking & (speed > _MOVING_MPS)].mean())
    predicted = model.measured - _SPEED_NOISE_MPS * fit.residuals
    return PedalFit(fit, model.times, model.measured, predicted, mean_mps)


class _PedalModel:
    """Predicts the reported speeds; grid: one value every SUBSTEP_S from the first tick on."""

    def __init__(self, drive: DriveSignals, wheelbase_m: float) -> None:
        first_s, last_s = float(drive.tick_s[0]), float(drive.tick_s[-1])
        self._grid = np.arange(first_s, last_s, SUBSTEP_S)
        latest = np.clip(np.searchsorted(drive.tick_s, self._grid + 1e-9) - 1, 0, None)
        self._throttle, self._brake = drive.commands[latest, 1], drive.commands[latest, 2]
        speed = np.interp(self._grid, drive.report_s, drive.speed_mps)
        self._speed = _smooth(speed)
        heading = drive.heading_rad.copy()
        heading[~np.isfinite(heading)] = 0.0
        self._cos, self._sin = np.cos(heading[latest]), np.sin(heading[latest])
        steer = np.interp(self._grid, drive.report_s, drive.steer_rad)
        curvature = np.tan(_smooth(steer)) / wheelbase_m
        self._curvature2 = curvature**2
        self._bending = self._speed**2 * curvature * np.gradient(curvature, SUBSTEP_S)
        chosen, self.windows = _windows(drive)
        self.times, self.measured = drive.report_s[chosen], drive.speed_mps[chosen]
        self._counts = np.maximum(np.bincount(self.windows), 1)

    def residuals(self, p: Array) -> Array:
        """(n,) measured less predicted, over the noise; the mean of each window is its free start speed."""
        gone = np.concatenate(([0.0], np.cumsum(self._accels(p)) * SUBSTEP_S))
        grid = np.append(self._grid, self._grid[-1] + SUBSTEP_S)
        error = self.measured - np.interp(self.times, grid, gone)
        mean = np.bincount(self.windows, error) / self._counts
        residuals: Array = (error - mean[self.windows]) / _SPEED_NOISE_MPS
        return residuals

    def _accels(self, p: Array) -> Array:
        throttle = _mean_of_steps(lagged(delayed(self._throttle, p[THROTTLE_DEAD]), p[THROTTLE_LAG]))
        brake = _mean_of_steps(lagged(delayed(self._brake, p[BRAKE_DEAD]), p[BRAKE_LAG]))
        opened = THROTTLE_AT * (np.maximum(throttle, 0.0) / THROTTLE_AT) ** p[THROTTLE_POWER]
        drive = opened / p[THROTTLE_PER] * np.maximum(0.0, 1.0 - p[THROTTLE_FADE] * self._speed)
        braking = brake_decels(brake, p) * (1.0 - p[BRAKE_FADE] * self._speed)
        slope = _GRAVITY_MPS2 * (p[SLOPE_X] * self._cos + p[SLOPE_Y] * self._sin)
        friction = p[ROLLING] + p[DRAG] * self._speed + p[TURNING] * self._bending
        accels: Array = (drive - braking - friction - slope) / (1.0 + p[TURNING] * self._curvature2)
        return accels


def brake_decels(brake: Array, p: Array) -> Array:
    """(n,) decelerations of a brake map's pedals at rest; none at no pedal."""
    exponent = np.clip((brake - p[BRAKE_OFFSET]) / p[BRAKE_GAIN], -30.0, 5.0)
    decels: Array = np.where(brake > 0.0, np.maximum(0.0, np.exp(exponent) - np.exp(p[BRAKE_LOG_KNEE])), 0.0)
    return decels


def delayed(values: Array, delay_s: float) -> Array:
    """Values on the grid after a dead time, which need not be a multiple of the grid's step."""
    steps = delay_s / SUBSTEP_S
    whole = int(np.floor(steps))
    share = steps - whole
    padded = np.concatenate((np.full(whole + 1, values[0]), values))
    later: Array = (1.0 - share) * padded[1 : len(values) + 1] + share * padded[: len(values)]
    return later


def lagged(values: Array, lag_s: float) -> Array:
    """Values on the grid after a first-order lag."""
    share = 1.0 - np.exp(-SUBSTEP_S / lag_s)
    start = [(1.0 - share) * values[0]]
    result: Array = lfilter([share], [1.0, share - 1.0], values, zi=start)[0]
    return result


def _mean_of_steps(ends: Array) -> Array:
    """The mean over each step of a value that is known at the ends of the steps."""
    means: Array = 0.5 * (ends + np.concatenate((ends[:1], ends[:-1])))
    return means


def _smooth(values: Array) -> Array:
    """The mean over 0.11 s about each value of the grid."""
    smooth: Array = np.convolve(np.pad(values, 5, mode="edge"), np.full(11, 1.0 / 11.0), "valid")
    return smooth


def _windows(drive: DriveSignals) -> tuple[IntArray, IntArray]:
    """((k,) reports that can be predicted, (k,) window of each): moving, by-wire driving, no gap."""
    times, speeds = drive.report_s, drive.speed_mps
    at = np.clip(np.searchsorted(drive.tick_s, times) - 1, 0, len(drive.tick_s) - 1)
    # Commands of the last second must be known too.
    gaps = np.diff(drive.tick_s, prepend=drive.tick_s[0] - DT_S) > 0.1
    known = _without_in_last(~drive.driving | gaps, round(1.0 / DT_S))
    usable = known[at] & (speeds > _MOVING_MPS)
    broken = ~usable | (np.diff(times, prepend=times[0]) > 0.1)
    piece = np.cumsum(broken)
    starts = np.maximum.accumulate(np.where(broken, times, -np.inf))
    window = np.floor((times - starts) / _WINDOW_S).astype(np.int64)
    chosen = np.flatnonzero(usable)
    _, number, count = np.unique(
        np.column_stack((piece[chosen], window[chosen])), axis=0, return_inverse=True, return_counts=True
    )
    number = number.ravel()
    full = count[number] >= _REPORTS_MIN
    _, renumbered = np.unique(number[full], return_inverse=True)
    return chosen[full], renumbered.astype(np.int64)


def _without_in_last(flags: BoolArray, count: int) -> BoolArray:
    """(n,) whether none of the last `count` flags and the present one is set."""
    total = np.cumsum(flags, dtype=np.int64)
    before = np.concatenate((np.zeros(count, np.int64), total))[: len(total)]
    none: BoolArray = (total - before) == 0
    return none
