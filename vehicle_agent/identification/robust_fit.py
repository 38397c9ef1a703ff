"""Robust least squares with standard deviations that hold for errors that are correlated within a window."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from contract.geometry import Array, IntArray


@dataclass(frozen=True, slots=True)
class Fit:
    """values (k,), std (k,), residuals (n,) in units of the noise, priors left out."""

    values: Array
    std: Array
    residuals: Array


@dataclass(frozen=True, slots=True)
class Prior:
    """What is known without the drive: a parameter's value and the standard deviation of it."""

    value: float
    std: float
    low: float
    high: float


def robust_fit(residuals: Callable[[Array], Array], priors: tuple[Prior, ...], windows: IntArray) -> Fit:
    """The parameters with the least soft-L1 cost of the residuals and of the priors.

    residuals  parameters (k,) -> (n,), divided by the noise of a measurement
    windows    (n,) the window of each residual; errors of different windows are independent

    The covariance is the sandwich of cluster-robust regression (Liang, Zeger 1986).
    """
    value = np.array([prior.value for prior in priors])
    scale = np.array([prior.std for prior in priors])
    low, high = (np.array([getattr(prior, name) for prior in priors]) for name in ("low", "high"))

    def all_residuals(z: Array) -> Array:
        return np.concatenate((residuals(value + scale * z), z))

    found = least_squares(
        all_residuals,
        np.zeros(len(priors)),
        bounds=((low - value) / scale, (high - value) / scale),
        loss="soft_l1",
        f_scale=3.0,
        diff_step=1e-3,
        x_scale=1.0,
        ftol=1e-5,
        xtol=1e-5,
        max_nfev=60,
    )
    n = len(windows)
    plain = np.asarray(found.fun[:n])
    # scipy scales the rows of the Jacobian by the loss; the residuals are scaled alike.
    weighted = plain / np.sqrt(np.sqrt(1.0 + (plain / 3.0) ** 2))
    jacobian = np.asarray(found.jac)
    scores = np.zeros((int(windows.max()) + 1, len(priors)))
    np.add.at(scores, windows, jacobian[:n] * weighted[:, None])
    bread = np.linalg.pinv(jacobian.T @ jacobian)
    meat = scores.T @ scores + jacobian[n:].T @ jacobian[n:]
    covariance = bread @ meat @ bread
    std: Array = scale * np.sqrt(np.maximum(np.diag(covariance), 0.0))
    return Fit(value + scale * found.x, std, plain)
