"""The path as the maximum a posteriori of a Gaussian process (Snow Lion, "Motion planning"; GPMP).

Levenberg-Marquardt on the block-tridiagonal normal equations; the budget is a number of iterations.
"""

import math

import msgspec
import numpy as np
from numba import njit

from contract.geometry import Array
from vehicle_agent.planning.motion.path.banded import factorize, solve
from vehicle_agent.planning.motion.path.factors import (
    FactorWeights,
    NormalEquations,
    PathProblem,
    normal_equations,
    path_cost,
)
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

    def factors(self) -> FactorWeights:
        """The same as weights, for the kernels."""
        return FactorWeights(
            prior=1.0 / math.sqrt(self.noise_density),
            start=1.0 / self.start_std,
            reference=1.0 / self.reference_std_m,
            wall=1.0 / self.wall_std_m,
            collision=1.0 / self.collision_std_m,
            curvature=1.0 / self.curvature_std_1pm,
            lateral=1.0 / self.lateral_std_1pm,
            end_slope=1.0 / self.end_slope_std,
            end_bend=1.0 / self.end_bend_std_1pm,
            wall_margin_m=self.wall_margin_m,
            collision_margin_m=self.collision_margin_m,
            curvature_margin_1pm=self.curvature_margin_1pm,
        )


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
        problem,
        information(problem.step_m),
        transition(problem.step_m),
        normal_equations(x.size),
        iterations_max,
    )
    return SolvedPath(problem.first_m, problem.step_m, x, cost, iterations, converged)


@njit(cache=True)
def levenberg_marquardt(
    x: Array, problem: PathProblem, prior: Array, phi: Array, normal: NormalEquations, iterations_max: int
) -> tuple[float, int, bool]:
    """Improves x (k, 3) in place; returns (cost, linearizations, converged). Nielsen's damping update.

    normal: room for the linearization
    """
    n = x.size
    factor, step, tried = np.empty((6, n)), np.empty(n), np.empty_like(x)
    damping, grow = 1e-7, 4.0
    cost = path_cost(x, problem, prior, phi, normal, True)
    used = 1
    while used < iterations_max:
        factor[:] = normal.band
        factor[0] *= 1.0 + damping
        if not factorize(factor):
            damping *= grow
            used += 1
            continue
        step[:] = -normal.gradient
        solve(factor, step)
        predicted, largest = _move(x, step, normal, damping, tried)
        tried_cost = path_cost(tried, problem, prior, phi, normal, False)
        used += 1
        if tried_cost <= cost:
            x[:] = tried
            gain = (cost - tried_cost) / max(predicted, 1e-300)
            cost = tried_cost
            damping = max(damping * max(0.1, 1.0 - (2.0 * gain - 1.0) ** 3), 1e-12)
            grow = 4.0
            if largest < 1e-9:
                return cost, used, True
            path_cost(x, problem, prior, phi, normal, True)
        elif largest < 1e-9:
            return cost, used, True
        else:
            damping = max(damping, 1e-6) * grow
            grow *= 2.0
    return cost, used, False


@njit(cache=True)
def _move(
    x: Array, step: Array, normal: NormalEquations, damping: float, tried: Array
) -> tuple[float, float]:
    """tried = x + step; returns (the decrease of cost that the model predicts, the largest change of l)."""
    predicted, largest = 0.0, 0.0
    for i in range(step.shape[0]):
        tried[i // 3, i % 3] = x[i // 3, i % 3] + step[i]
        predicted += 0.5 * step[i] * (damping * normal.band[0, i] * step[i] - normal.gradient[i])
        if i % 3 == 0:
            largest = max(largest, abs(step[i]))
    return predicted, largest
