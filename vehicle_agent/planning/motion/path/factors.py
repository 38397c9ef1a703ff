"""What a path costs, and its linearization: the factors of the MAP problem.

Each hinge residual max(0, wanted - got) / sigma acts on the interpolated state at a check point, so its
Jacobian touches the two support states around it and the normal matrix stays block tridiagonal (band 5).
"""

import math

import numpy as np
from numba import njit

from contract.geometry import Array, IntArray

# Columns of `weights`: 1 / sigma of each factor; PRIOR is 1 / sqrt(Qc); *_MARGIN are lengths in m, 1/m.
(
    PRIOR,
    START,
    REFERENCE,
    WALL,
    COLLISION,
    CURVATURE,
    LATERAL,
    END_1,
    END_2,
    WALL_MARGIN,
    COLLISION_MARGIN,
    CURVATURE_MARGIN,
) = range(12)


@njit(cache=True)
def add(band: Array, gradient: Array, at: int, j6: Array, residual: float) -> None:
    """One scalar residual with Jacobian j6 (6,) on the states from index `at` on."""
    n = gradient.shape[0]
    for a in range(6):
        if j6[a] == 0.0 or at + a >= n:
            continue
        gradient[at + a] += j6[a] * residual
        for b in range(a, 6):
            if at + b < n:
                band[b - a, at + a] += j6[a] * j6[b]


@njit(cache=True)
def curvature_with_slopes(frame: Array, l0: float, l1: float, l2: float) -> tuple[float, float, float, float]:
    """Curvature of the path and its derivatives by l, l', l'' (see frame.py for the symbols)."""
    sigma, kappa = frame[3], frame[5]
    b = sigma * kappa
    a = sigma - b * l0
    a1 = frame[4] * (1.0 - kappa * l0) - sigma * (frame[6] * l0 + kappa * l1)
    d = a * a + l1 * l1
    root = math.sqrt(d)
    d15, d25 = d * root, d * d * root
    c = a * l2 - l1 * a1
    by_l0 = a * b * b / d15 + (-b * l2 + l1 * (frame[4] * kappa + sigma * frame[6])) / d15
    by_l0 += 3.0 * a * b * c / d25
    by_l1 = -a1 / d15 - 3.0 * l1 * c / d25
    return b / root + c / d15, by_l0, by_l1, a / d15


@njit(cache=True)
def path_cost(
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
    band: Array,
    gradient: Array,
    slopes: bool,
) -> float:
    """Half the sum of squared residuals; with `slopes`, also the normal matrix and the gradient.

    x (k, 3) support states; start (3,); reference (k,) wanted l; prior (3, 3) Q^-1; phi (3, 3);
    between (sub, 3, 6) interpolation at the check points after each support, the first is the support;
    frames (c, 7), lower, upper, curvature_max, curvature_wish (c,) at the check points, c = (k - 1) sub + 1;
    disc_x (b,) body discs ahead of the rear axle, disc_ahead (b,) the same in check points;
    obstacles (m, 3); near[near_from[j]:near_from[j + 1]] those that can matter at check point j.
    """
    k, sub, checks = x.shape[0], between.shape[0], frames.shape[0]
    cost = 0.0
    j6 = np.zeros(6)
    if slopes:
        band[:] = 0.0
        gradient[:] = 0.0
    for i in range(3):
        cost += _unary(x, 0, i, start[i], weights[START], band, gradient, j6, slopes)
    for i in range(1, k):
        cost += _unary(x, i, 0, reference[i], weights[REFERENCE], band, gradient, j6, slopes)
    cost += _unary(x, k - 1, 1, 0.0, weights[END_1], band, gradient, j6, slopes)
    cost += _unary(x, k - 1, 2, 0.0, weights[END_2], band, gradient, j6, slopes)
    cost += _prior_cost(x, prior, phi, weights[PRIOR] * weights[PRIOR], band, gradient, slopes)
    state = np.empty(3)
    on_state = np.empty(3)
    for j in range(checks):
        i = min(j // sub, k - 2)
        inside = between[j - i * sub] if j - i * sub < sub else between[0]
        at_last = j - i * sub >= sub
        at = i + 1 if at_last else i
        for a in range(3):
            if at_last:
                state[a] = x[at, a]
            else:
                state[a] = 0.0
                for b in range(3):
                    state[a] += inside[a, b] * x[i, b] + inside[a, 3 + b] * x[i + 1, b]
        frame = frames[j]
        curvature, by_l0, by_l1, by_l2 = curvature_with_slopes(frame, state[0], state[1], state[2])
        side = 1.0 if curvature >= 0.0 else -1.0
        for kind in range(2):
            limit = curvature_wish[j] if kind else curvature_max[j] - weights[CURVATURE_MARGIN]
            weight = weights[LATERAL] if kind else weights[CURVATURE]
            over = abs(curvature) - limit
            if over > 0.0:
                cost += 0.5 * (weight * over) ** 2
                if slopes:
                    on_state[0], on_state[1], on_state[2] = by_l0, by_l1, by_l2
                    _spread(j6, on_state, inside, at_last, side * weight)
                    add(band, gradient, 3 * at, j6, weight * over)
        sigma, kappa = frame[3], frame[5]
        a_ = sigma * (1.0 - kappa * state[0])
        d2 = a_ * a_ + state[1] * state[1]
        yaw = frame[2] + math.atan2(state[1], a_)
        yaw_by_l0, yaw_by_l1 = state[1] * sigma * kappa / d2, a_ / d2
        cos, sin = math.cos(yaw), math.sin(yaw)
        nx, ny = -math.sin(frame[2]), math.cos(frame[2])
        px, py = frame[0] + state[0] * nx, frame[1] + state[0] * ny
        on_state[2] = 0.0
        for b in range(disc_x.shape[0]):
            cx, cy = px + disc_x[b] * cos, py + disc_x[b] * sin
            beside = j + disc_ahead[b]
            if 0 <= beside < checks:
                other = frames[beside]
                mx, my = -math.sin(other[2]), math.cos(other[2])
                offset = (cx - other[0]) * mx + (cy - other[1]) * my
                below = lower[beside] + weights[WALL_MARGIN] - offset
                above = offset - upper[beside] + weights[WALL_MARGIN]
                over = max(below, above)
                if over > 0.0:
                    cost += 0.5 * (weights[WALL] * over) ** 2
                    if slopes:
                        turn = disc_x[b] * (-sin * mx + cos * my)
                        on_state[0] = nx * mx + ny * my + turn * yaw_by_l0
                        on_state[1] = turn * yaw_by_l1
                        sign = -weights[WALL] if below > above else weights[WALL]
                        _spread(j6, on_state, inside, at_last, sign)
                        add(band, gradient, 3 * at, j6, weights[WALL] * over)
            nearest, who = np.inf, -1
            for n in range(near_from[j], near_from[j + 1]):
                o = near[n]
                dx, dy = cx - obstacles[o, 0], cy - obstacles[o, 1]
                reach = nearest + obstacles[o, 2]
                if reach > 0.0 and dx * dx + dy * dy < reach * reach:
                    nearest, who = math.sqrt(dx * dx + dy * dy) - obstacles[o, 2], o
            over = disc_r + weights[COLLISION_MARGIN] - nearest
            if who >= 0 and over > 0.0:
                cost += 0.5 * (weights[COLLISION] * over) ** 2
                if slopes:
                    dx, dy = cx - obstacles[who, 0], cy - obstacles[who, 1]
                    distance = max(math.hypot(dx, dy), 1e-9)
                    gx, gy = dx / distance, dy / distance
                    turn = disc_x[b] * (-sin * gx + cos * gy)
                    on_state[0] = gx * nx + gy * ny + turn * yaw_by_l0
                    on_state[1] = turn * yaw_by_l1
                    _spread(j6, on_state, inside, at_last, -weights[COLLISION])
                    add(band, gradient, 3 * at, j6, weights[COLLISION] * over)
    return cost


@njit(cache=True)
def _unary(
    x: Array,
    i: int,
    axis: int,
    wanted: float,
    weight: float,
    band: Array,
    gradient: Array,
    j6: Array,
    slopes: bool,
) -> float:
    residual = weight * (x[i, axis] - wanted)
    if slopes:
        j6[:] = 0.0
        j6[axis] = weight
        add(band, gradient, 3 * i, j6, residual)
    cost: float = 0.5 * residual * residual
    return cost


@njit(cache=True)
def _spread(j6: Array, on_state: Array, inside: Array, at_last: bool, scale: float) -> None:
    """A Jacobian on an interpolated state, carried to the two support states around it."""
    for b in range(6):
        if at_last:
            j6[b] = scale * on_state[b] if b < 3 else 0.0
        else:
            j6[b] = scale * (
                on_state[0] * inside[0, b] + on_state[1] * inside[1, b] + on_state[2] * inside[2, b]
            )


@njit(cache=True)
def _prior_cost(
    x: Array, prior: Array, phi: Array, scale: float, band: Array, gradient: Array, slopes: bool
) -> float:
    """Half the squared Mahalanobis length of every e_i = Phi x_i - x_i+1."""
    cost = 0.0
    block = np.zeros((3, 6))
    block[:, :3] = phi
    for a in range(3):
        block[a, 3 + a] = -1.0
    weighted = scale * (prior @ block)
    normal = block.T @ weighted
    error = np.empty(3)
    for i in range(x.shape[0] - 1):
        for a in range(3):
            error[a] = -x[i + 1, a]
            for b in range(3):
                error[a] += phi[a, b] * x[i, b]
        for a in range(3):
            for b in range(3):
                cost += 0.5 * scale * error[a] * prior[a, b] * error[b]
        if slopes:
            for a in range(6):
                for b in range(3):
                    gradient[3 * i + a] += weighted[b, a] * error[b]
                for b in range(a, 6):
                    band[b - a, 3 * i + a] += normal[a, b]
    return cost
