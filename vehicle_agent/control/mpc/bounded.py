"""The same problems when a bound is met: OSQP with a fixed sparsity pattern (Snow Lion, eq. 6).

Variables are the inputs over their bound. Rows are the inputs, and the command as their sum. Zero inputs keep
both bounds, so every problem is feasible whose first command is within its bounds.
"""

import math
from functools import cache

import msgspec
import numpy as np
import osqp
from scipy import sparse

from contract.geometry import Array, IntArray

# OSQP's status of a usable solution: solved, and solved less exactly than requested.
SOLVED = (1, 2)
# A count, never a time; the tolerance is in parts of the bounds.
ITERATIONS = 800
EPS = 3e-4
RHO = 0.1


class InputBounds(msgspec.Struct, frozen=True):
    """rate: bound of the input, both ways; command_min and command_max: bounds of the command."""

    rate: float
    command_min: float
    command_max: float


class QpSolution(msgspec.Struct, frozen=True):
    """inputs (N,) within the bounds; multipliers (2 N,) of OSQP; feasible: OSQP found a solution."""

    inputs: Array
    multipliers: Array
    feasible: bool
    iterations: int


def are_within(inputs: Array, command: float, bounds: InputBounds, dt_s: float) -> bool:
    """True if the inputs (N,), applied from `command` on, keep all bounds."""
    commands = command + dt_s * np.cumsum(inputs)
    return bool(
        np.abs(inputs).max() <= bounds.rate
        and commands.min() >= bounds.command_min
        and commands.max() <= bounds.command_max
    )


def solve_bounded(
    H: Array, g: Array, command: float, bounds: InputBounds, dt_s: float, inputs: Array, multipliers: Array
) -> QpSolution:
    """The minimum of 1/2 u' H u + g' u within bounds, from a start: inputs (N,), multipliers (2 N,).

    command must lie within its bounds. The solution depends on the arguments alone: there is no scaling, all
    changing values are set each time, and the step size starts from the same value and adapts by counts. So
    the workspace keeps nothing of earlier problems.
    """
    n = len(g)
    workspace, triangle = _workspace(n)
    # The first step size fits problems whose curvatures lie around 1, and they reach from that of the last
    # input alone to that of all inputs together.
    cost = 1.0 / (bounds.rate**2 * math.sqrt(float(H[n - 1, n - 1]) * float(np.trace(H))))
    span = bounds.rate * dt_s
    workspace.update(
        Px=(H[triangle] * (bounds.rate * bounds.rate * cost)),
        q=g * (bounds.rate * cost),
        l=np.concatenate((np.full(n, -1.0), np.full(n, (bounds.command_min - command) / span))),
        u=np.concatenate((np.full(n, 1.0), np.full(n, (bounds.command_max - command) / span))),
    )
    workspace.update_settings(rho=RHO)
    workspace.warm_start(x=inputs / bounds.rate, y=multipliers)
    result = workspace.solve(raise_error=False)
    is_solved = bool(result.info.status_val in SOLVED and np.isfinite(result.x).all())
    unclamped = result.x * bounds.rate if is_solved else inputs
    new_multipliers = np.ascontiguousarray(result.y) if is_solved else np.zeros(2 * n)
    return QpSolution(
        clamp_inputs(unclamped, command, bounds, dt_s), new_multipliers, is_solved, int(result.info.iter)
    )


def prepare(steps: int) -> None:
    """Sets up the workspace for that many inputs, so that no solve waits for it."""
    _workspace(steps)


def clamp_inputs(inputs: Array, command: float, bounds: InputBounds, dt_s: float) -> Array:
    """The inputs (N,), limited to the bounds from first to last."""
    clamped = np.clip(inputs, -bounds.rate, bounds.rate)
    for k in range(len(clamped)):
        reached = min(max(command + clamped[k] * dt_s, bounds.command_min), bounds.command_max)
        clamped[k] = (reached - command) / dt_s
        command = reached
    return clamped


@cache
def _workspace(n: int) -> tuple[osqp.OSQP, tuple[IntArray, IntArray]]:
    """OSQP's workspace for n inputs, and the indices of the upper triangle of H, column by column."""
    columns, rows = np.nonzero(np.tril(np.ones((n, n))))
    pattern = sparse.csc_matrix(np.triu(np.ones((n, n))))
    sums = sparse.csc_matrix(np.vstack((np.eye(n), np.tril(np.ones((n, n))))))
    workspace = osqp.OSQP()
    workspace.setup(
        P=pattern,
        q=np.zeros(n),
        A=sums,
        l=np.full(2 * n, -1.0),
        u=np.full(2 * n, 1.0),
        verbose=False,
        scaling=0,
        adaptive_rho=1,
        adaptive_rho_interval=20,
        adaptive_rho_tolerance=2.0,
        rho=RHO,
        eps_abs=EPS,
        eps_rel=EPS,
        max_iter=ITERATIONS,
        check_termination=10,
        polishing=False,
        warm_starting=True,
    )
    return workspace, (rows, columns)
