"""Quadratic problems of one actuator over a horizon, and their exact solution while no bound is met.

    min  sum x_k' Q_k x_k + R (u_k - w_k)^2 (k < N) + (x_N - x_end)' P (x_N - x_end)
    where  x_{k+1} = A_k x_k + B_k u_k + d_k

after Snow Lion, eq. 6, read right (w: the inputs that the reference itself takes): u runs to N - 1 and the
end has a cost of its own. The last state is the actuator's command and u its rate, so that bounds on rate
and command are bounds on u and on a running sum of u.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from contract.geometry import Array


class AxisProblem(NamedTuple):
    """One problem, in the symbols above; a tuple, so that kernels take it as it is.

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
def free_inputs(problem: AxisProblem) -> Array:
    """(N,) the best inputs without bounds, by the Riccati recursion."""
    A, B, d, Q, R, w, P, x_end, x0 = problem
    N, n = B.shape
    S = P.copy()
    s = np.zeros(n)
    for i in range(n):
        for j in range(n):
            s[i] -= P[i, j] * x_end[j]
    gain = np.zeros((N, n))
    push = np.zeros(N)
    SA = np.zeros((n, n))
    for k in range(N - 1, -1, -1):
        _back(A[k], B[k], d[k], Q[k], R, w[k], S, s, gain[k], push, k, SA)
    u = np.zeros(N)
    x = x0.copy()
    y = np.zeros(n)
    for k in range(N):
        total = push[k]
        for i in range(n):
            total += gain[k, i] * x[i]
        u[k] = -total
        _forward(A[k], B[k], d[k], u[k], x, y)
        x[:] = y
    return u


@njit(cache=True)
def _forward(A: Array, B: Array, d: Array, u: float, x: Array, y: Array) -> None:
    n = x.shape[0]
    for i in range(n):
        total = d[i] + B[i] * u
        for j in range(n):
            total += A[i, j] * x[j]
        y[i] = total


@njit(cache=True)
def _back(
    A: Array, B: Array, d: Array, Q: Array, R: float, w: float, S: Array, s: Array,
    gain: Array, push: Array, k: int, SA: Array,
) -> None:  # fmt: skip
    """One step back: S, s become those of the step before; gain and push[k] give u = -(gain x + push)."""
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
    bottom = R
    along = -R * w
    for i in range(n):
        bottom += B[i] * SB[i]
        along += B[i] * v[i]
    for j in range(n):
        total = 0.0
        for i in range(n):
            total += B[i] * SA[i, j]
        gain[j] = total / bottom
    push[k] = along / bottom
    for i in range(n):
        for j in range(i, n):
            total = Q[i, j] - bottom * gain[i] * gain[j]
            for m in range(n):
                total += A[m, i] * SA[m, j]
            S[i, j] = total
            S[j, i] = total
        total = -gain[i] * along
        for m in range(n):
            total += A[m, i] * v[m]
        s[i] = total


@njit(cache=True)
def end_cost(A: Array, B: Array, Q: Array, R: float, rounds: int) -> Array:
    """(n, n) the discrete algebraic Riccati equation's solution, by value iteration over `rounds` steps.

    A (n, n), B (n,), Q (n, n): of one step that goes on for ever.
    """
    n = B.shape[0]
    S = Q.copy()
    nothing = np.zeros(n)
    s = np.zeros(n)
    gain = np.zeros(n)
    push = np.zeros(1)
    SA = np.zeros((n, n))
    for _ in range(rounds):
        _back(A, B, nothing, Q, R, 0.0, S, s, gain, push, 0, SA)
    return S


@njit(cache=True)
def condensed(problem: AxisProblem) -> tuple[Array, Array]:
    """(H (N, N), g (N,)) of the same problem in the inputs alone: 1/2 u' H u + g' u, up to a constant."""
    A, B, d, Q, R, w, P, x_end, x0 = problem
    N, n = B.shape
    # effect[j] is dx_k/du_j at the present k; free is x_k without inputs.
    effect = np.zeros((N, n))
    free = x0.copy()
    y = np.zeros(n)
    zero = np.zeros(n)
    weighted = np.zeros((N, n))
    H = np.zeros((N, N))
    g = np.zeros(N)
    for k in range(N):
        _forward(A[k], B[k], d[k], 0.0, free, y)
        free[:] = y
        for j in range(k):
            _forward(A[k], B[k], zero, 0.0, effect[j], y)
            effect[j, :] = y
        effect[k, :] = B[k]
        weight = Q[k + 1] if k + 1 < N else P
        off = free if k + 1 < N else free - x_end
        for j in range(k + 1):
            for a in range(n):
                total = 0.0
                for b in range(n):
                    total += weight[a, b] * effect[j, b]
                weighted[j, a] = total
        for j in range(k + 1):
            total = 0.0
            for a in range(n):
                total += weighted[j, a] * off[a]
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
