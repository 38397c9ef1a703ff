"""The path as the maximum a posteriori of a Gaussian process (Snow Lion, "Motion planning"; GPMP).

Levenberg-Marquardt on the block-tridiagonal normal equations; the budget is a number of iterations.
"""

import math

import msgspec
import numpy as np
from numba import njit

from contract.geometry import Array, IntArray
from vehicle_agent.planning.motion.path.banded import factorize, solve
from vehicle_agent.planning.motion.path.factors import path_cost
from vehicle_agent.planning.motion.path.gp_prior import (
    information,
    interpolation,
    states_between,
    transition,
)


class PathWeights(msgspec.Struct, frozen=True):
    """Standard deviations of the factors, and margins that the hinges keep.

    noise_density  Qc of l''' (1/m^5 .. m^2 m^-5): larger follows the reference more closely
    """

    noise_density: float = 1e-4
    start_std: float = 1e-5
    reference_std_m: float = 0.3
    wall_std_m: float = 0.03
    collision_std_m: float = 0.05
    curvature_std_1pm: float = 0.002
    lateral_std_1pm: float = 0.03
    end_slope_std: float = 0.05
    end_bend_std_1pm: float = 0.02
    wall_margin_m: float = 0.05
    collision_margin_m: float = 0.25
    curvature_margin_1pm: float = 0.01

    def vector(self) -> Array:
        """(12,) in the order of factors.py."""
        stds = (
            math.sqrt(self.noise_density),
            self.start_std,
            self.reference_std_m,
            self.wall_std_m,
            self.collision_std_m,
            self.curvature_std_1pm,
            self.lateral_std_1pm,
            self.end_slope_std,
            self.end_bend_std_1pm,
        )
        margins = (self.wall_margin_m, self.collision_margin_m, self.curvature_margin_1pm)
        return np.array([*(1.0 / std for std in stds), *margins])


class PathProblem(msgspec.Struct, frozen=True):
    """Everything that the path's cost depends on; arrays as in `factors.path_cost`."""

    first_m: float
    step_m: float
    start: np.ndarray
    reference: np.ndarray
    between: np.ndarray
    frames: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    curvature_max: np.ndarray
    curvature_wish: np.ndarray
    disc_x: np.ndarray
    disc_r: float
    disc_ahead: np.ndarray
    obstacles: np.ndarray
    near_from: np.ndarray
    near: np.ndarray
    weights: np.ndarray

    def support_m(self) -> Array:
        """(k,) s of the support states."""
        support: Array = self.first_m + self.step_m * np.arange(len(self.reference), dtype=np.float64)
        return support


class SolvedPath(msgspec.Struct, frozen=True):
    """states (k, 3) (l, l', l'') at first_m + i step_m; cost; iterations used; converged."""

    first_m: float
    step_m: float
    states: np.ndarray
    cost: float
    iterations: int
    converged: bool

    def at(self, s_m: Array) -> Array:
        """(m, 3) states at s_m (m,)."""
        states: Array = states_between(self.states, self.step_m, self.first_m, s_m)
        return states


def between_supports(step_m: float, sub: int) -> Array:
    """(sub, 3, 6) interpolation matrices at 0, 1/sub, ... of a step; the first picks the support itself."""
    return np.stack([_matrix(step_m, j * step_m / sub) for j in range(sub)])


def _matrix(step_m: float, tau_m: float) -> Array:
    if tau_m == 0.0:
        return np.eye(3, 6)
    matrix: Array = interpolation(step_m, tau_m)
    return matrix


def solve_path(problem: PathProblem, initial: Array, iterations_max: int) -> SolvedPath:
    """The path of least cost near `initial` (k, 3) after at most iterations_max linearizations."""
    x = np.ascontiguousarray(initial, dtype=np.float64).copy()
    cost, iterations, converged = levenberg_marquardt(
        x,
        problem.start,
        problem.reference,
        information(problem.step_m),
        transition(problem.step_m),
        problem.between,
        problem.frames,
        problem.lower,
        problem.upper,
        problem.curvature_max,
        problem.curvature_wish,
        problem.disc_x,
        problem.disc_r,
        problem.disc_ahead,
        problem.obstacles,
        problem.near_from,
        problem.near,
        problem.weights,
        iterations_max,
    )
    return SolvedPath(problem.first_m, problem.step_m, x, cost, iterations, converged)


@njit(cache=True)
def levenberg_marquardt(
    x: Array,
    start: Array,
    reference: Array,
    prior: Array,
    phi: Array,
    between: Array,
    frames: Array,
    lower: Array,
    upper: Array,
    curvature_max: Array,
    curvature_wish: Array,
    disc_x: Array,
    disc_r: float,
    disc_ahead: IntArray,
    obstacles: Array,
    near_from: IntArray,
    near: IntArray,
    weights: Array,
    iterations_max: int,
) -> tuple[float, int, bool]:
    """Improves x (k, 3) in place; returns (cost, linearizations, converged). Nielsen's damping update."""
    n = x.size
    band, gradient = np.zeros((6, n)), np.zeros(n)
    none, no_gradient = np.zeros((6, 1)), np.zeros(1)
    factor, step, tried = np.empty((6, n)), np.empty(n), np.empty_like(x)
    damping, grow = 1e-7, 4.0
    cost = path_cost(
        x, start, reference, prior, phi, between, frames, lower, upper, curvature_max, curvature_wish,
        disc_x, disc_r, disc_ahead, obstacles, near_from, near, weights, band, gradient, True,
    )  # fmt: skip
    used = 1
    while used < iterations_max:
        factor[:] = band
        factor[0] *= 1.0 + damping
        if not factorize(factor):
            damping *= grow
            used += 1
            continue
        step[:] = -gradient
        solve(factor, step)
        largest = 0.0
        predicted = 0.0
        for i in range(n):
            tried[i // 3, i % 3] = x[i // 3, i % 3] + step[i]
            predicted += 0.5 * step[i] * (damping * band[0, i] * step[i] - gradient[i])
            if i % 3 == 0:
                largest = max(largest, abs(step[i]))
        tried_cost = path_cost(
            tried, start, reference, prior, phi, between, frames, lower, upper, curvature_max, curvature_wish,
            disc_x, disc_r, disc_ahead, obstacles, near_from, near, weights, none, no_gradient, False,
        )  # fmt: skip
        used += 1
        if tried_cost <= cost:
            x[:] = tried
            gain = (cost - tried_cost) / max(predicted, 1e-300)
            cost = tried_cost
            damping = max(damping * max(0.1, 1.0 - (2.0 * gain - 1.0) ** 3), 1e-12)
            grow = 4.0
            if largest < 1e-9:
                return cost, used, True
            path_cost(
                x, start, reference, prior, phi, between, frames, lower, upper, curvature_max, curvature_wish,
                disc_x, disc_r, disc_ahead, obstacles, near_from, near, weights, band, gradient, True,
            )  # fmt: skip
        elif largest < 1e-9:
            return cost, used, True
        else:
            damping = max(damping, 1e-6) * grow
            grow *= 2.0
    return cost, used, False
