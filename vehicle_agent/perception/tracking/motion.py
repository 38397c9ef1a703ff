"""How tracked objects move: an interacting multiple model filter over constant velocity and coordinated turn.

Each track has two models of the same state x, y, vx, vy (map frame) and turn rate: one that goes on steadily,
and one that starts, stops or turns. Blom and Bar-Shalom, "The interacting multiple model algorithm for
systems with Markovian switching coefficients" (1988); the turn: Bar-Shalom, Li, Kirubarajan, "Estimation with
Applications to Tracking and Navigation" (2001), section 11.7.
"""

import math

import numpy as np
from numba import njit

from contract.geometry import Array

STEADY, MANOEUVRE = range(2)
MODELS = 2
PX, PY, VX, VY, TURN = range(5)
STATES = 5
# Columns of a measurement: position, velocity or NaN, variances of both.
ZX, ZY, ZVX, ZVY, Z_VAR, ZV_VAR = range(6)
Z_COLUMNS = 6
# A turn rate below this is none, 1/s.
_STRAIGHT = 1e-4


@njit(cache=True)
def predict(means: Array, covariances: Array, weights: Array, noise: Array, stay: float, dt_s: float) -> None:
    """Moves all tracks on by dt_s, in place.

    means (n, 2, 5), covariances (n, 2, 5, 5), weights (n, 2) of the models
    noise  (n, 2, 2) standard deviations of acceleration (m/s2) and of the turn rate's change (1/s2) by model;
           0 for the turn rate: the track goes straight
    stay   probability that a model goes on for a scan
    """
    mixed = np.empty((MODELS, STATES))
    mixed_covariances = np.empty((MODELS, STATES, STATES))
    for n in range(means.shape[0]):
        _mix(means[n], covariances[n], weights[n], stay, mixed, mixed_covariances)
        for m in range(MODELS):
            jacobian = _turned(mixed[m], dt_s)
            means[n, m] = mixed[m]
            moved = covariances[n, m]
            _transformed(jacobian, mixed_covariances[m], moved)
            accel2 = noise[n, m, 0] ** 2
            for axis in range(2):
                moved[axis, axis] += 0.25 * dt_s**4 * accel2
                moved[axis, axis + 2] += 0.5 * dt_s**3 * accel2
                moved[axis + 2, axis] += 0.5 * dt_s**3 * accel2
                moved[axis + 2, axis + 2] += dt_s**2 * accel2
            moved[TURN, TURN] += (noise[n, m, 1] * dt_s) ** 2


@njit(cache=True)
def _transformed(jacobian: Array, covariance: Array, result: Array) -> None:
    """Sets result to jacobian covariance jacobian'."""
    half = np.zeros((STATES, STATES))
    for i in range(STATES):
        for k in range(STATES):
            if jacobian[i, k] != 0.0:
                for j in range(STATES):
                    half[i, j] += jacobian[i, k] * covariance[k, j]
    for i in range(STATES):
        for j in range(STATES):
            total = 0.0
            for k in range(STATES):
                total += half[i, k] * jacobian[j, k]
            result[i, j] = total


@njit(cache=True)
def _mix(
    mean: Array, covariance: Array, weight: Array, stay: float, mixed: Array, mixed_covariance: Array
) -> None:
    """The models' common start (the interaction step); weight becomes that before the measurement."""
    into = np.empty(MODELS)
    for m in range(MODELS):
        into[m] = stay * weight[m] + (1.0 - stay) * weight[1 - m]
        own = stay * weight[m] / into[m]
        mixed[m] = own * mean[m] + (1.0 - own) * mean[1 - m]
        mixed_covariance[m] = 0.0
        for k in range(MODELS):
            share = own if k == m else 1.0 - own
            for i in range(STATES):
                for j in range(STATES):
                    off = (mean[k, i] - mixed[m, i]) * (mean[k, j] - mixed[m, j])
                    mixed_covariance[m, i, j] += share * (covariance[k, i, j] + off)
    weight[:] = into


@njit(cache=True)
def _turned(state: Array, dt_s: float) -> Array:
    """Moves a state on, in place; the Jacobian (5, 5)."""
    jacobian = np.zeros((STATES, STATES))
    for i in range(STATES):
        jacobian[i, i] = 1.0
    vx, vy, turn = state[VX], state[VY], state[TURN]
    if abs(turn) < _STRAIGHT:
        jacobian[PX, VX] = jacobian[PY, VY] = dt_s
        jacobian[PX, TURN], jacobian[PY, TURN] = -0.5 * dt_s**2 * vy, 0.5 * dt_s**2 * vx
        jacobian[VX, TURN], jacobian[VY, TURN] = -dt_s * vy, dt_s * vx
        state[PX] += dt_s * vx
        state[PY] += dt_s * vy
        return jacobian
    angle = turn * dt_s
    sin, cos = math.sin(angle), math.cos(angle)
    along, aside = sin / turn, (1.0 - cos) / turn
    along_by = (dt_s * cos - along) / turn
    aside_by = (dt_s * sin - aside) / turn
    jacobian[PX, VX], jacobian[PX, VY], jacobian[PX, TURN] = along, -aside, along_by * vx - aside_by * vy
    jacobian[PY, VX], jacobian[PY, VY], jacobian[PY, TURN] = aside, along, aside_by * vx + along_by * vy
    jacobian[VX, VX], jacobian[VX, VY], jacobian[VX, TURN] = cos, -sin, -dt_s * (sin * vx + cos * vy)
    jacobian[VY, VX], jacobian[VY, VY], jacobian[VY, TURN] = sin, cos, dt_s * (cos * vx - sin * vy)
    state[PX] += along * vx - aside * vy
    state[PY] += aside * vx + along * vy
    state[VX], state[VY] = cos * vx - sin * vy, sin * vx + cos * vy
    return jacobian


@njit(cache=True)
def combined(means: Array, covariances: Array, weights: Array) -> tuple[Array, Array]:
    """((n, 5), (n, 5, 5)) mean and covariance over the models."""
    n = means.shape[0]
    mean, covariance = np.zeros((n, STATES)), np.zeros((n, STATES, STATES))
    for t in range(n):
        for m in range(MODELS):
            mean[t] += weights[t, m] * means[t, m]
        for m in range(MODELS):
            for i in range(STATES):
                for j in range(STATES):
                    off = (means[t, m, i] - mean[t, i]) * (means[t, m, j] - mean[t, j])
                    covariance[t, i, j] += weights[t, m] * (covariances[t, m, i, j] + off)
    return mean, covariance


@njit(cache=True)
def update(means: Array, covariances: Array, weights: Array, rows: np.ndarray, measured: Array) -> None:
    """Corrects tracks by their measurements, in place.

    rows (k,) of the tracks, measured (k, 6): see the columns above; NaN velocity: none

    The errors of one measurement's values are independent, so they are taken one after the other: the same
    result without an inverse.
    """
    likelihood = np.empty(MODELS)
    gain = np.empty(STATES)
    for k in range(rows.shape[0]):
        t = rows[k]
        size = 2 if math.isnan(measured[k, ZVX]) else 4
        for m in range(MODELS):
            mean, covariance = means[t, m], covariances[t, m]
            exponent, spread_product = 0.0, 1.0
            for i in range(size):
                spread = covariance[i, i] + measured[k, Z_VAR if i < 2 else ZV_VAR]
                innovation = measured[k, i] - mean[i]
                exponent += innovation * innovation / spread
                spread_product *= spread
                for j in range(STATES):
                    gain[j] = covariance[j, i] / spread
                for j in range(STATES):
                    mean[j] += gain[j] * innovation
                    for n in range(STATES):
                        covariance[j, n] -= gain[j] * gain[n] * spread
            likelihood[m] = math.exp(-0.5 * min(exponent, 60.0)) / math.sqrt(spread_product)
        total = 0.0
        for m in range(MODELS):
            weights[t, m] = max(weights[t, m] * likelihood[m], 1e-12)
            total += weights[t, m]
        for m in range(MODELS):
            weights[t, m] /= total


def doubt_velocities(
    means: Array, weights: Array, rows: np.ndarray, measured: Array, agree_mps: Array, doubted_mps: Array
) -> None:
    """Raises the variance of measured velocities that disagree with their tracks, in place.

    rows (k,) of the tracks, measured (k, 6); agree_mps, doubted_mps (k,) as in `KindMotion`

    A finder that measures a shift between two turns takes another person's points for it now and then. Such
    a velocity is far from what the places say, whereas that of who sets off is near it in each scan.
    """
    own = np.einsum("km,kms->ks", weights[rows], means[rows][:, :, VX:TURN])
    off = np.hypot(measured[:, ZVX] - own[:, 0], measured[:, ZVY] - own[:, 1])
    doubted = off > agree_mps
    measured[doubted, ZV_VAR] = doubted_mps[doubted] ** 2


@njit(cache=True)
def gate_distances(mean: Array, covariance: Array, measured: Array) -> tuple[Array, Array]:
    """((n, k) squared Mahalanobis distances of positions, (n, k) logarithms of the spread's determinant).

    mean (n, 5), covariance (n, 5, 5) as `combined` gives them; measured (k, 6)
    """
    n, k = mean.shape[0], measured.shape[0]
    squared, log_spread = np.empty((n, k)), np.empty((n, k))
    for t in range(n):
        for d in range(k):
            a = covariance[t, PX, PX] + measured[d, Z_VAR]
            b = covariance[t, PX, PY]
            c = covariance[t, PY, PY] + measured[d, Z_VAR]
            det = max(a * c - b * b, 1e-12)
            dx, dy = measured[d, ZX] - mean[t, PX], measured[d, ZY] - mean[t, PY]
            squared[t, d] = (c * dx * dx - 2.0 * b * dx * dy + a * dy * dy) / det
            log_spread[t, d] = math.log(det)
    return squared, log_spread
