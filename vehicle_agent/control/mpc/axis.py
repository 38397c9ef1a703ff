"""One actuator's problem solved: exactly where no bound is met, by OSQP where one is."""

import msgspec
import numpy as np

from contract.geometry import Array
from vehicle_agent.control.mpc.bounded import InputBounds, solved, within
from vehicle_agent.control.mpc.problem import condensed, free_inputs


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


def best_inputs(
    A: Array, B: Array, d: Array, Q: Array, R: float, w: Array, P: Array, x_end: Array, x0: Array,
    bounds: InputBounds, dt_s: float, guess: WarmStart,
) -> AxisSolution:  # fmt: skip
    """Inputs (N,) for the problem of `problem.py`, whose last state is the command.

    While the inputs that are best without bounds keep them all they are best with them too, and OSQP is not
    asked. Otherwise OSQP starts from the guess.
    """
    inputs = free_inputs(A, B, d, Q, R, w, P, x_end, x0)
    if within(inputs, float(x0[-1]), bounds, dt_s):
        return AxisSolution(inputs, WarmStart(inputs, np.zeros_like(guess.prices)), False, True, 0)
    H, g = condensed(A, B, d, Q, R, w, P, x_end, x0)
    answer = solved(H, g, float(x0[-1]), bounds, dt_s, guess.inputs, guess.prices)
    return AxisSolution(
        answer.inputs, WarmStart(answer.inputs, answer.prices), True, answer.feasible, answer.iterations
    )
