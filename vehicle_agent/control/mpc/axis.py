"""One actuator's problem solved: exactly where no bound is met, by OSQP where one is."""

import msgspec
import numpy as np

from contract.geometry import Array
from vehicle_agent.control.mpc.bounded import InputBounds, solved, within
from vehicle_agent.control.mpc.problem import AxisProblem, condensed, free_inputs


class WarmStart(msgspec.Struct, frozen=True):
    """What a solve starts from: the last inputs (N,) and multipliers (2 N,)."""

    inputs: Array
    prices: Array


class AxisSolution(msgspec.Struct, frozen=True):
    """inputs (N,); bounded: a bound was met; iterations of OSQP, 0 without it."""

    inputs: Array
    guess: WarmStart
    bounded: bool
    feasible: bool
    iterations: int


def no_guess(steps: int) -> WarmStart:
    return WarmStart(np.zeros(steps), np.zeros(2 * steps))


def best_inputs(problem: AxisProblem, bounds: InputBounds, dt_s: float, guess: WarmStart) -> AxisSolution:
    """Inputs (N,) for a problem whose last state is the command.

    Inputs that are best without bounds and keep all of them are best with them too; then OSQP is not called.
    Otherwise OSQP starts from the guess.
    """
    inputs = free_inputs(problem)
    command = float(problem.x0[-1])
    if within(inputs, command, bounds, dt_s):
        return AxisSolution(inputs, WarmStart(inputs, np.zeros_like(guess.prices)), False, True, 0)
    H, g = condensed(problem)
    answer = solved(H, g, command, bounds, dt_s, guess.inputs, guess.prices)
    return AxisSolution(
        answer.inputs, WarmStart(answer.inputs, answer.prices), True, answer.feasible, answer.iterations
    )
