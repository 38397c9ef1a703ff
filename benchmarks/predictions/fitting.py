"""The fits to recorded deviations: the sudden step, and a pace that people come back to."""

import numpy as np
from scipy.optimize import least_squares

from benchmarks.predictions.deviations import HORIZONS_S, Deviations
from contract.geometry import Array
from vehicle_agent.planning.motion.request import SuddenStep

STEP_QUANTILE = 0.999
# Shorter horizons show the recordings' own lag of velocities; the vehicle cannot answer them either.
_STEP_FROM_S = 0.75
_STEP_UNTIL_S = 2.0


def fitted_step(found: Deviations) -> SuddenStep:
    """The step that covers STEP_QUANTILE of the deviations across at each horizon, by least squares."""
    times = np.array([t for t in HORIZONS_S if _STEP_FROM_S <= t <= _STEP_UNTIL_S])
    columns = [k for k, t in enumerate(HORIZONS_S) if _STEP_FROM_S <= t <= _STEP_UNTIL_S]
    reached = np.nanquantile(np.abs(found.across_m[:, columns]), STEP_QUANTILE, axis=0)
    best = least_squares(
        lambda p: step_m(SuddenStep(p[0], p[1]), times) - reached, (1.4, 0.5), bounds=(0.05, 5.0)
    )
    return SuddenStep(float(best.x[0]), float(best.x[1]))


def step_m(step: SuddenStep, times_s: Array) -> Array:
    """How far a step out of a straight way has led after each time."""
    reached: Array = step.mps * (times_s - step.rise_s * (1.0 - np.exp(-times_s / step.rise_s)))
    return reached


def covered(found: Deviations, step: SuddenStep) -> Array:
    """(h,) the share of deviations across that the step covers."""
    inside = np.abs(found.across_m) <= step_m(step, np.array(HORIZONS_S))
    return _shares(inside, found.across_m)


def within_sigmas(found: Deviations, sigma_m: Array, sigmas: float) -> tuple[Array, Array]:
    """((h,), (h,)) the share of deviations along and across within so many standard deviations (h,)."""
    along = _shares(np.abs(found.along_m) <= sigmas * sigma_m, found.along_m)
    return along, _shares(np.abs(found.across_m) <= sigmas * sigma_m, found.across_m)


def fitted_pace(found: Deviations) -> tuple[float, float]:
    """(pace_mps, time constant s): the speed relaxes to a pace that all people share, by least squares."""
    known = np.isfinite(found.along_m)

    def errors(p: Array) -> Array:
        residuals: Array = (paced_m(found.speed_mps, p[0], p[1]) - found.along_m)[known]
        return residuals

    best = least_squares(errors, (1.2, 5.0), bounds=((0.3, 0.5), (2.5, 100.0)))
    return float(best.x[0]), float(best.x[1])


def paced_m(speed_mps: Array, pace_mps: float, relax_s: float) -> Array:
    """(n, h) how far ahead of constant velocity a person is whose speed relaxes to the pace."""
    t = np.array(HORIZONS_S)
    ahead: Array = (pace_mps - speed_mps)[:, None] * (t - relax_s * (1.0 - np.exp(-t / relax_s)))
    return ahead


def rms_m(errors: Array) -> Array:
    """(h,) over all observations that have this horizon."""
    root: Array = np.sqrt(np.nanmean(errors**2, axis=0))
    return root


def _shares(inside: Array, values: Array) -> Array:
    known = np.isfinite(values)
    shares: Array = (inside & known).sum(axis=0) / known.sum(axis=0)
    return shares
