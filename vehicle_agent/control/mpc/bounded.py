"""The same problems where a bound is met: OSQP with a fixed pattern (Snow Lion, eq. 6).

Variables are the inputs over their bound. Rows: the inputs themselves, and the command they add up to. Both
are met by standing still, so that no problem is infeasible as long as the command it starts from is within
bounds.
"""

import math
from functools import cache

import msgspec
import numpy as np
import osqp
from scipy import sparse

from contract.geometry import Array, IntArray

# What OSQP says of an answer that may be driven: solved, and solved less exactly than asked for.
SOLVED = (1, 2)
# A count, never a time; the tolerance is in parts of the bounds.
ITERATIONS = 800
EPS = 3e-4
RHO = 0.1


class InputBounds(msgspec.Struct, frozen=True):
    """rate: of the input, either way; command_min and command_max: of the sum."""

    rate: float
    command_min: float
    command_max: float


class QpSolution(msgspec.Struct, frozen=True):
    """inputs (N,) within the bounds; prices (2 N,) OSQP's multipliers; feasible: OSQP did not give up."""

    inputs: Array
    prices: Array
    feasible: bool
    iterations: int


def within(inputs: Array, command: float, bounds: InputBounds, dt_s: float) -> bool:
    """Do inputs (N,) from `command` on keep the bounds as they are?"""
    commands = command + dt_s * np.cumsum(inputs)
    return bool(
        np.abs(inputs).max() <= bounds.rate
        and commands.min() >= bounds.command_min
        and commands.max() <= bounds.command_max
    )


def solved(
    H: Array, g: Array, command: float, bounds: InputBounds, dt_s: float, inputs: Array, prices: Array
) -> QpSolution:
    """Minimise 1/2 u' H u + g' u within bounds, started from a guess: inputs (N,) and prices (2 N,).

    command must lie within its bounds. The answer depends on the arguments alone: the workspace works without
    scaling, all that changes is given anew each time, and its step size starts from the same value and
    adapts by counts; so nothing of earlier problems stays in it.
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
    workspace.warm_start(x=inputs / bounds.rate, y=prices)
    answer = workspace.solve(raise_error=False)
    good = bool(answer.info.status_val in SOLVED and np.isfinite(answer.x).all())
    wanted = answer.x * bounds.rate if good else inputs
    kept = np.ascontiguousarray(answer.y) if good else np.zeros(2 * n)
    return QpSolution(kept_within(wanted, command, bounds, dt_s), kept, good, int(answer.info.iter))


def prepare(steps: int) -> None:
    """Set the workspace for that many inputs up, so that no solve waits for it."""
    _workspace(steps)


def kept_within(inputs: Array, command: float, bounds: InputBounds, dt_s: float) -> Array:
    """The inputs (N,) with whatever is beyond a bound taken off, first to last."""
    out = np.clip(inputs, -bounds.rate, bounds.rate)
    for k in range(len(out)):
        reached = min(max(command + out[k] * dt_s, bounds.command_min), bounds.command_max)
        out[k] = (reached - command) / dt_s
        command = reached
    return out


@cache
def _workspace(n: int) -> tuple[osqp.OSQP, tuple[IntArray, IntArray]]:
    """OSQP's memory for n inputs, and where the upper triangle of H lies, column by column."""
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
