"""Quadratic problems of one actuator over a horizon, and their exact solution without bounds.

    min  sum x_k' Q_k x_k + R (u_k - w_k)^2 (k < N) + (x_N - x_end)' P (x_N - x_end)
    where  x_{k+1} = A_k x_k + B_k u_k + d_k

after Snow Lion, eq. 6, corrected: u runs to N - 1, and the end has a cost of its own. w are the inputs that
the reference itself needs. The last state is the actuator's command and u its rate, so bounds on rate and
command are bounds on u and on a running sum of u.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from contract.geometry import Array


class AxisProblem(NamedTuple):
    """One problem, in the symbols above. A tuple, so that kernels take it.

    A (N, n, n), B (N, n), d (N, n), Q (N, n, n) symmetric, w (N,), P (n, n) cost of the end, x_end (n,) where
    that cost is zero, x0 (n,)
    """

    A: Array
    B: Array
    d: Array
    Q: Array
    R: float
    w: Array
    P: Array
    x_end: Array
    x0: Array


@njit(cache=True)
def unconstrained_inputs(problem: AxisProblem) -> Array:
    """(N,) the best inputs without bounds, by the Riccati recursion."""
    A, B, d, Q, R, w, P, x_end, x0 = problem
    N, n = B.shape
    S = P.copy()
    s = np.zeros(n)
    for i in range(n):
        for j in range(n):
            s[i] -= P[i, j] * x_end[j]
    gain = np.zeros((N, n))
    feedforward = np.zeros(N)
    SA = np.zeros((n, n))
    for k in range(N - 1, -1, -1):
        _backward_step(A[k], B[k], d[k], Q[k], R, w[k], S, s, gain[k], feedforward, k, SA)
    u = np.zeros(N)
    x = x0.copy()
    y = np.zeros(n)
    for k in range(N):
        total = feedforward[k]
        for i in range(n):
            total += gain[k, i] * x[i]
        u[k] = -total
        _forward_step(A[k], B[k], d[k], u[k], x, y)
        x[:] = y
    return u


@njit(cache=True)
def _forward_step(A: Array, B: Array, d: Array, u: float, x: Array, y: Array) -> None:
    n = x.shape[0]
    for i in range(n):
        total = d[i] + B[i] * u
        for j in range(n):
            total += A[i, j] * x[j]
        y[i] = total


@njit(cache=True)
def _backward_step(
    A: Array, B: Array, d: Array, Q: Array, R: float, w: float, S: Array, s: Array,
    gain: Array, feedforward: Array, k: int, SA: Array,
) -> None:  # fmt: skip
    """One step back: S and s become those of the step before; u = -(gain x + feedforward[k])."""
    n = B.shape[0]
    SB = np.zeros(n)
    v = np.zeros(n)
    for i in range(n):
        for j in range(n):
            total = 0.0
            for m in range(n):
                total += S[i, m] * A[m, j]
            SA[i, j] = total
            SB[i] += S[i, j] * B[j]
            v[i] += S[i, j] * d[j]
        v[i] += s[i]
    input_cost = R
    input_gradient = -R * w
    for i in range(n):
        input_cost += B[i] * SB[i]
        input_gradient += B[i] * v[i]
    for j in range(n):
        total = 0.0
        for i in range(n):
            total += B[i] * SA[i, j]
        gain[j] = total / input_cost
    feedforward[k] = input_gradient / input_cost
    for i in range(n):
        for j in range(i, n):
            total = Q[i, j] - input_cost * gain[i] * gain[j]
            for m in range(n):
                total += A[m, i] * SA[m, j]
            S[i, j] = total
            S[j, i] = total
        total = -gain[i] * input_gradient
        for m in range(n):
            total += A[m, i] * v[m]
        s[i] = total


@njit(cache=True)
def end_cost(A: Array, B: Array, Q: Array, R: float, rounds: int) -> Array:
    """(n, n) the solution of the discrete algebraic Riccati equation, by value iteration over `rounds` steps.

    A (n, n), B (n,), Q (n, n): of one step, repeated for ever.
    """
    n = B.shape[0]
    S = Q.copy()
    no_offset = np.zeros(n)
    s = np.zeros(n)
    gain = np.zeros(n)
    feedforward = np.zeros(1)
    SA = np.zeros((n, n))
    for _ in range(rounds):
        _backward_step(A, B, no_offset, Q, R, 0.0, S, s, gain, feedforward, 0, SA)
    return S


@njit(cache=True)
def condense(problem: AxisProblem) -> tuple[Array, Array]:
    """(H (N, N), g (N,)) of the same problem in the inputs alone: 1/2 u' H u + g' u, up to a constant."""
    A, B, d, Q, R, w, P, x_end, x0 = problem
    N, n = B.shape
    # effect[j] is dx_k/du_j at the current k; free is x_k without inputs.
    effect = np.zeros((N, n))
    free = x0.copy()
    y = np.zeros(n)
    zero = np.zeros(n)
    weighted = np.zeros((N, n))
    H = np.zeros((N, N))
    g = np.zeros(N)
    for k in range(N):
        _forward_step(A[k], B[k], d[k], 0.0, free, y)
        free[:] = y
        for j in range(k):
            _forward_step(A[k], B[k], zero, 0.0, effect[j], y)
            effect[j, :] = y
        effect[k, :] = B[k]
        weight = Q[k + 1] if k + 1 < N else P
        error = free if k + 1 < N else free - x_end
        for j in range(k + 1):
            for a in range(n):
                total = 0.0
                for b in range(n):
                    total += weight[a, b] * effect[j, b]
                weighted[j, a] = total
        for j in range(k + 1):
            total = 0.0
            for a in range(n):
                total += weighted[j, a] * error[a]
            g[j] += 2.0 * total
            for i in range(j + 1):
                total = 0.0
                for a in range(n):
                    total += weighted[j, a] * effect[i, a]
                H[i, j] += 2.0 * total
    for j in range(N):
        H[j, j] += 2.0 * R
        g[j] -= 2.0 * R * w[j]
        for i in range(j):
            H[j, i] = H[i, j]
    return H, g
