"""The solution of one actuator's problem: exact if it meets no bound, otherwise by OSQP."""

import msgspec
import numpy as np

from contract.geometry import Array
from vehicle_agent.control.mpc.bounded import InputBounds, are_within, solve_bounded
from vehicle_agent.control.mpc.problem import AxisProblem, condense, unconstrained_inputs


class WarmStart(msgspec.Struct, frozen=True):
    """The start of a solve: the last inputs (N,) and multipliers (2 N,)."""

    inputs: Array
    multipliers: Array


class AxisSolution(msgspec.Struct, frozen=True):
    """inputs (N,); bounded: a bound is met; iterations of OSQP, 0 without it."""

    inputs: Array
    warm_start: WarmStart
    bounded: bool
    feasible: bool
    iterations: int


def cold_start(steps: int) -> WarmStart:
    return WarmStart(np.zeros(steps), np.zeros(2 * steps))


def solve_axis(problem: AxisProblem, bounds: InputBounds, dt_s: float, warm_start: WarmStart) -> AxisSolution:
    """The best inputs (N,) of a problem whose last state is the command.

    If the best inputs without bounds keep all bounds, they are the solution. Otherwise OSQP starts from
    warm_start.
    """
    inputs = unconstrained_inputs(problem)
    command = float(problem.x0[-1])
    if are_within(inputs, command, bounds, dt_s):
        return AxisSolution(inputs, WarmStart(inputs, np.zeros_like(warm_start.multipliers)), False, True, 0)
    H, g = condense(problem)
    solution = solve_bounded(H, g, command, bounds, dt_s, warm_start.inputs, warm_start.multipliers)
    return AxisSolution(
        solution.inputs,
        WarmStart(solution.inputs, solution.multipliers),
        True,
        solution.feasible,
        solution.iterations,
    )
