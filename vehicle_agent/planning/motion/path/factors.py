"""What a path costs, and its linearization: the factors of the MAP problem.

Each hinge residual max(0, wanted - got) / sigma acts on the interpolated state at a check point. Its Jacobian
touches only the two support states around that point, so the normal matrix stays block tridiagonal (band 5).
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from contract.geometry import Array, IntArray


class FactorWeights(NamedTuple):
    """1 / sigma of each factor (the prior's is 1 / sqrt(Qc)), and margins in m and 1/m."""

    prior: float
    start: float
    reference: float
    wall: float
    collision: float
    curvature: float
    lateral: float
    end_slope: float
    end_bend: float
    wall_margin_m: float
    collision_margin_m: float
    curvature_margin_1pm: float


class PathProblem(NamedTuple):
    """Everything that the path's cost depends on; a tuple, so that kernels take it as it is.

    first_m, step_m  s of the first support state, and from one to the next
    start            (3,) l, l', l'' at the first support; reference (k,) wanted l at each
    between          (sub, 3, 6) interpolation at the check points from each support on; the first is that one
    frames           (c, 7) at the check points, c = (k - 1) sub + 1
    lower, upper     (c,) walls; curvature_max, curvature_wish (c,)
    disc_x           (b,) body discs ahead of the rear axle; disc_ahead (b,) the same in check points; disc_r
    obstacles        (m, 3) x, y, radius; near[near_from[j]:near_from[j + 1]] can matter at check point j
    """

    first_m: float
    step_m: float
    start: Array
    reference: Array
    between: Array
    frames: Array
    lower: Array
    upper: Array
    curvature_max: Array
    curvature_wish: Array
    disc_x: Array
    disc_r: float
    disc_ahead: IntArray
    obstacles: Array
    near_from: IntArray
    near: IntArray
    weights: FactorWeights

    def support_m(self) -> Array:
        """(k,) s of the support states."""
        support: Array = self.first_m + self.step_m * np.arange(len(self.reference), dtype=np.float64)
        return support


class NormalEquations(NamedTuple):
    """band (6, 3 k) of the normal matrix, gradient (3 k,), and a row j6 (6,) to work in."""

    band: Array
    gradient: Array
    j6: Array


class _CheckPoint(NamedTuple):
    """The path at check point j: its frame (7,), its state (3,), and where that comes from.

    inside  (3, 6) interpolates the state from the two supports from support `at` on; is_last: it is the
            state of the last support itself
    """

    j: int
    frame: Array
    state: Array
    inside: Array
    at: int
    is_last: bool


class _BodyPose(NamedTuple):
    """The rear axle at a check point: place, heading, the line's normal, and the heading's derivatives."""

    x: float
    y: float
    cos: float
    sin: float
    normal_x: float
    normal_y: float
    yaw_by_l0: float
    yaw_by_l1: float


def normal_equations(n: int) -> NormalEquations:
    """Room for the linearization of n unknowns."""
    return NormalEquations(np.zeros((6, n)), np.zeros(n), np.zeros(6))


@njit(cache=True)
def add(normal: NormalEquations, at: int, residual: float) -> None:
    """Adds one scalar residual with the Jacobian normal.j6 on the states from index `at` on."""
    j6, gradient = normal.j6, normal.gradient
    n = gradient.shape[0]
    for a in range(6):
        if j6[a] == 0.0 or at + a >= n:
            continue
        gradient[at + a] += j6[a] * residual
        for b in range(a, 6):
            if at + b < n:
                normal.band[b - a, at + a] += j6[a] * j6[b]


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
    x: Array, problem: PathProblem, prior: Array, phi: Array, normal: NormalEquations, slopes: bool
) -> float:
    """Half the sum of squared residuals at the support states x (k, 3).

    With `slopes`, `normal` becomes the linearization. prior (3, 3) Q^-1 and phi (3, 3) of one step.
    """
    if slopes:
        normal.band[:] = 0.0
        normal.gradient[:] = 0.0
    cost = _support_cost(x, problem, normal, slopes)
    scale = problem.weights.prior * problem.weights.prior
    cost += _prior_cost(x, prior, phi, scale, normal.band, normal.gradient, slopes)
    state = np.empty(3)
    for j in range(problem.frames.shape[0]):
        point = _check_point(x, problem, j, state)
        cost = _with_curvature_cost(cost, point, problem, normal, slopes)
        pose = _body_pose(point)
        for b in range(problem.disc_x.shape[0]):
            cost = _with_wall_cost(cost, b, point, pose, problem, normal, slopes)
            cost = _with_collision_cost(cost, b, point, pose, problem, normal, slopes)
    return cost


@njit(cache=True)
def _support_cost(x: Array, problem: PathProblem, normal: NormalEquations, slopes: bool) -> float:
    """Of the factors on one support state each: start, reference and end."""
    k, weights = x.shape[0], problem.weights
    cost = 0.0
    for i in range(3):
        cost += _unary(x, 0, i, problem.start[i], weights.start, normal, slopes)
    for i in range(1, k):
        cost += _unary(x, i, 0, problem.reference[i], weights.reference, normal, slopes)
    cost += _unary(x, k - 1, 1, 0.0, weights.end_slope, normal, slopes)
    cost += _unary(x, k - 1, 2, 0.0, weights.end_bend, normal, slopes)
    return cost


@njit(cache=True)
def _unary(
    x: Array, i: int, axis: int, wanted: float, weight: float, normal: NormalEquations, slopes: bool
) -> float:
    residual = weight * (x[i, axis] - wanted)
    if slopes:
        normal.j6[:] = 0.0
        normal.j6[axis] = weight
        add(normal, 3 * i, residual)
    cost: float = 0.5 * residual * residual
    return cost


@njit(cache=True)
def _check_point(x: Array, problem: PathProblem, j: int, state: Array) -> _CheckPoint:
    """Check point j; its state is written to `state` (3,)."""
    sub = problem.between.shape[0]
    i = min(j // sub, x.shape[0] - 2)
    is_last = j - i * sub >= sub
    inside = problem.between[0] if is_last else problem.between[j - i * sub]
    at = i + 1 if is_last else i
    for a in range(3):
        if is_last:
            state[a] = x[at, a]
        else:
            state[a] = 0.0
            for b in range(3):
                state[a] += inside[a, b] * x[i, b] + inside[a, 3 + b] * x[i + 1, b]
    return _CheckPoint(j, problem.frames[j], state, inside, at, is_last)


@njit(cache=True)
def _with_curvature_cost(
    cost: float, point: _CheckPoint, problem: PathProblem, normal: NormalEquations, slopes: bool
) -> float:
    """cost and that of more curvature than the steering allows, or than the lateral acceleration should."""
    weights, state = problem.weights, point.state
    curvature, by_l0, by_l1, by_l2 = curvature_with_slopes(point.frame, state[0], state[1], state[2])
    side = 1.0 if curvature >= 0.0 else -1.0
    for is_lateral in range(2):
        limit = problem.curvature_max[point.j] - weights.curvature_margin_1pm
        weight = weights.curvature
        if is_lateral:
            limit, weight = problem.curvature_wish[point.j], weights.lateral
        over = abs(curvature) - limit
        if over > 0.0:
            cost += 0.5 * (weight * over) ** 2
            if slopes:
                _spread(normal.j6, by_l0, by_l1, by_l2, point, side * weight)
                add(normal, 3 * point.at, weight * over)
    return cost


@njit(cache=True)
def _body_pose(point: _CheckPoint) -> _BodyPose:
    frame, state = point.frame, point.state
    sigma, kappa = frame[3], frame[5]
    a = sigma * (1.0 - kappa * state[0])
    d2 = a * a + state[1] * state[1]
    yaw = frame[2] + math.atan2(state[1], a)
    normal_x, normal_y = -math.sin(frame[2]), math.cos(frame[2])
    return _BodyPose(
        frame[0] + state[0] * normal_x,
        frame[1] + state[0] * normal_y,
        math.cos(yaw),
        math.sin(yaw),
        normal_x,
        normal_y,
        state[1] * sigma * kappa / d2,
        a / d2,
    )


@njit(cache=True)
def _with_wall_cost(
    cost: float,
    b: int,
    point: _CheckPoint,
    pose: _BodyPose,
    problem: PathProblem,
    normal: NormalEquations,
    slopes: bool,
) -> float:
    """cost and that of body disc b beyond a wall, at the check point that the disc is abreast of."""
    ahead, weights = problem.disc_x[b], problem.weights
    abreast = point.j + problem.disc_ahead[b]
    if not 0 <= abreast < problem.frames.shape[0]:
        return cost
    x, y = pose.x + ahead * pose.cos, pose.y + ahead * pose.sin
    frame = problem.frames[abreast]
    mx, my = -math.sin(frame[2]), math.cos(frame[2])
    offset = (x - frame[0]) * mx + (y - frame[1]) * my
    below = problem.lower[abreast] + weights.wall_margin_m - offset
    above = offset - problem.upper[abreast] + weights.wall_margin_m
    over = max(below, above)
    if over > 0.0:
        cost += 0.5 * (weights.wall * over) ** 2
        if slopes:
            turn = ahead * (-pose.sin * mx + pose.cos * my)
            by_l0 = pose.normal_x * mx + pose.normal_y * my + turn * pose.yaw_by_l0
            sign = -weights.wall if below > above else weights.wall
            _spread(normal.j6, by_l0, turn * pose.yaw_by_l1, 0.0, point, sign)
            add(normal, 3 * point.at, weights.wall * over)
    return cost


@njit(cache=True)
def _with_collision_cost(
    cost: float,
    b: int,
    point: _CheckPoint,
    pose: _BodyPose,
    problem: PathProblem,
    normal: NormalEquations,
    slopes: bool,
) -> float:
    """cost and that of body disc b too near to its nearest obstacle."""
    ahead, weights = problem.disc_x[b], problem.weights
    x, y = pose.x + ahead * pose.cos, pose.y + ahead * pose.sin
    gap, o = _nearest_obstacle(x, y, problem, point.j)
    over = problem.disc_r + weights.collision_margin_m - gap
    if o >= 0 and over > 0.0:
        cost += 0.5 * (weights.collision * over) ** 2
        if slopes:
            dx, dy = x - problem.obstacles[o, 0], y - problem.obstacles[o, 1]
            distance = max(math.hypot(dx, dy), 1e-9)
            gx, gy = dx / distance, dy / distance
            turn = ahead * (-pose.sin * gx + pose.cos * gy)
            by_l0 = gx * pose.normal_x + gy * pose.normal_y + turn * pose.yaw_by_l0
            _spread(normal.j6, by_l0, turn * pose.yaw_by_l1, 0.0, point, -weights.collision)
            add(normal, 3 * point.at, weights.collision * over)
    return cost


@njit(cache=True)
def _nearest_obstacle(x: float, y: float, problem: PathProblem, j: int) -> tuple[float, int]:
    """(distance from the edge, index) of the obstacle nearest to (x, y) at check point j; -1 for none."""
    nearest, found = np.inf, -1
    for n in range(problem.near_from[j], problem.near_from[j + 1]):
        o = problem.near[n]
        dx, dy = x - problem.obstacles[o, 0], y - problem.obstacles[o, 1]
        reach = nearest + problem.obstacles[o, 2]
        if reach > 0.0 and dx * dx + dy * dy < reach * reach:
            nearest, found = math.sqrt(dx * dx + dy * dy) - problem.obstacles[o, 2], o
    return nearest, found


@njit(cache=True)
def _spread(j6: Array, by_l0: float, by_l1: float, by_l2: float, point: _CheckPoint, scale: float) -> None:
    """Carries derivatives by an interpolated state (l, l', l'') over to the two support states around it."""
    for b in range(6):
        if point.is_last:
            on_state = by_l0 if b == 0 else (by_l1 if b == 1 else by_l2)
            j6[b] = scale * on_state if b < 3 else 0.0
        else:
            inside = point.inside
            j6[b] = scale * (by_l0 * inside[0, b] + by_l1 * inside[1, b] + by_l2 * inside[2, b])


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
