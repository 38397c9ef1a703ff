"""A Gaussian process on l(s) whose third derivative is white noise: prior and interpolation.

Between support states x = (l, l', l'') a step delta apart, x_k+1 = Phi x_k + w with w ~ N(0, Q). The mean
between two states is the quintic that joins them, so the path is twice continuously differentiable.
Source: Snow Lion, "Motion planning", with GPMP (Mukadam et al. 2018, eq. 13-19) one derivative higher.
"""

import numpy as np
from numba import njit

from contract.geometry import Array


@njit(cache=True)
def transition(step: float) -> Array:
    """(3, 3) Phi(step)."""
    return np.array([[1.0, step, 0.5 * step * step], [0.0, 1.0, step], [0.0, 0.0, 1.0]])


@njit(cache=True)
def covariance(step: float) -> Array:
    """(3, 3) Q(step) for unit power spectral density."""
    s2 = step * step
    s3, s4 = s2 * step, s2 * s2
    return np.array(
        [
            [s4 * step / 20.0, s4 / 8.0, s3 / 6.0],
            [s4 / 8.0, s3 / 3.0, s2 / 2.0],
            [s3 / 6.0, s2 / 2.0, step],
        ]
    )


@njit(cache=True)
def information(step: float) -> Array:
    """(3, 3) Q(step)^-1, in closed form."""
    s2 = step * step
    s3, s4 = s2 * step, s2 * s2
    return np.array(
        [
            [720.0 / (s4 * step), -360.0 / s4, 60.0 / s3],
            [-360.0 / s4, 192.0 / s3, -36.0 / s2],
            [60.0 / s3, -36.0 / s2, 9.0 / step],
        ]
    )


@njit(cache=True)
def interpolation(step: float, tau: float) -> Array:
    """(3, 6) [Lambda Psi]: the state tau after the first of two states, x = Lambda x_k + Psi x_k+1."""
    psi = covariance(tau) @ transition(step - tau).T @ information(step)
    out = np.empty((3, 6))
    out[:, :3] = transition(tau) - psi @ transition(step)
    out[:, 3:] = psi
    return out


@njit(cache=True)
def states_between(x: Array, step: float, first: float, s: Array) -> Array:
    """(m, 3) states at s (m,), clipped to the supports x (k, 3) at first + i step."""
    out = np.empty((s.shape[0], 3))
    last = x.shape[0] - 2
    for j in range(s.shape[0]):
        along = min(max((s[j] - first) / step, 0.0), last + 1.0)
        i = min(int(along), last)
        t, d = along - i, step
        # Quintic Hermite; the same as interpolation(step, t * step) @ (x_i, x_i+1).
        p0, v0, a0 = x[i, 0], x[i, 1] * d, x[i, 2] * d * d
        p1, v1, a1 = x[i + 1, 0], x[i + 1, 1] * d, x[i + 1, 2] * d * d
        e = p1 - p0 - v0 - 0.5 * a0
        f = v1 - v0 - a0
        g = a1 - a0
        c3 = 10.0 * e - 4.0 * f + 0.5 * g
        c4 = -15.0 * e + 7.0 * f - g
        c5 = 6.0 * e - 3.0 * f + 0.5 * g
        out[j, 0] = p0 + t * (v0 + t * (0.5 * a0 + t * (c3 + t * (c4 + t * c5))))
        out[j, 1] = (v0 + t * (a0 + t * (3.0 * c3 + t * (4.0 * c4 + t * 5.0 * c5)))) / d
        out[j, 2] = (a0 + t * (6.0 * c3 + t * (12.0 * c4 + t * 20.0 * c5))) / (d * d)
    return out
