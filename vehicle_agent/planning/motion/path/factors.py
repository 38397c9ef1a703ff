"""What a path costs, and its linearization: the factors of the MAP problem.

Each hinge residual max(0, wanted - got) / sigma acts on the interpolated state at a check point. Its Jacobian
touches only the two support states around that point, so the normal matrix stays block tridiagonal (band 5).
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from contract.geometry import Array, IntArray
from vehicle_agent.planning.motion.path.frame import Frame, frame_row


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


class _State(NamedTuple):
    """l, l', l'' at a check point."""

    l0: float
    l1: float
    l2: float


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


class _Hinge(NamedTuple):
    """residual >= 0 of a hinge, weighted; its Jacobian on the state is scale times (by_l0, by_l1, by_l2)."""

    residual: float
    scale: float
    by_l0: float
    by_l1: float
    by_l2: float


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
def curvature_with_slopes(frame: Frame, l0: float, l1: float, l2: float) -> tuple[float, float, float, float]:
    """Curvature of the path and its derivatives by l, l', l'' (see frame.py for the symbols)."""
    sigma, kappa = frame.sigma, frame.kappa
    b = sigma * kappa
    a = sigma - b * l0
    a1 = frame.sigma_1 * (1.0 - kappa * l0) - sigma * (frame.kappa_1 * l0 + kappa * l1)
    d = a * a + l1 * l1
    root = math.sqrt(d)
    d15, d25 = d * root, d * d * root
    c = a * l2 - l1 * a1
    by_l0 = a * b * b / d15 + (-b * l2 + l1 * (frame.sigma_1 * kappa + sigma * frame.kappa_1)) / d15
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
    return _with_check_costs(cost, x, problem, normal, slopes)


@njit(cache=True)
def _with_check_costs(
    cost: float, x: Array, problem: PathProblem, normal: NormalEquations, slopes: bool
) -> float:
    """cost and that of all hinges at the check points.

    Arrays are taken out of `problem` once: each time a kernel touches a tuple it counts references to all of
    the tuple's arrays.
    """
    frames, between, weights = problem.frames, problem.between, problem.weights
    lower, upper, disc_x, disc_ahead = problem.lower, problem.upper, problem.disc_x, problem.disc_ahead
    curvature_max, curvature_wish = problem.curvature_max, problem.curvature_wish
    obstacles, near_from, near = problem.obstacles, problem.near_from, problem.near
    clear_m = problem.disc_r + weights.collision_margin_m
    sub = between.shape[0]
    for j in range(frames.shape[0]):
        i = min(j // sub, x.shape[0] - 2)
        k = j - i * sub
        frame = frame_row(frames, j)
        state = _state_at(x, between, i, k)
        hinges = _curvature_hinges(frame, state, curvature_max[j], curvature_wish[j], weights)
        for hinge in hinges:
            if hinge.residual > 0.0:
                cost += 0.5 * hinge.residual**2
                if slopes:
                    _add_hinge(normal, between, i, k, hinge)
        pose = _body_pose(frame, state)
        for b in range(disc_x.shape[0]):
            cx, cy = pose.x + disc_x[b] * pose.cos, pose.y + disc_x[b] * pose.sin
            abreast = j + disc_ahead[b]
            if 0 <= abreast < frames.shape[0]:
                beside = frame_row(frames, abreast)
                hinge = _wall_hinge(cx, cy, beside, lower[abreast], upper[abreast], disc_x[b], pose, weights)
                if hinge.residual > 0.0:
                    cost += 0.5 * hinge.residual**2
                    if slopes:
                        _add_hinge(normal, between, i, k, hinge)
            gap, o = _nearest(cx, cy, obstacles, near, near_from[j], near_from[j + 1])
            over = clear_m - gap
            if o >= 0 and over > 0.0:
                ox, oy = obstacles[o, 0], obstacles[o, 1]
                hinge = _collision_hinge(cx, cy, ox, oy, over, disc_x[b], pose, weights.collision)
                cost += 0.5 * hinge.residual**2
                if slopes:
                    _add_hinge(normal, between, i, k, hinge)
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
def _state_at(x: Array, between: Array, i: int, k: int) -> _State:
    """The state at the k-th check point after support i; k = sub is the next support itself."""
    if k >= between.shape[0]:
        return _State(x[i + 1, 0], x[i + 1, 1], x[i + 1, 2])
    return _State(_mean(x, between, i, k, 0), _mean(x, between, i, k, 1), _mean(x, between, i, k, 2))


@njit(cache=True)
def _mean(x: Array, between: Array, i: int, k: int, a: int) -> float:
    value = 0.0
    for b in range(3):
        value += between[k, a, b] * x[i, b] + between[k, a, 3 + b] * x[i + 1, b]
    return value


@njit(cache=True)
def _curvature_hinges(
    frame: Frame, state: _State, curvature_max: float, curvature_wish: float, weights: FactorWeights
) -> tuple[_Hinge, _Hinge]:
    """More curvature than the steering allows, and than the lateral acceleration should take."""
    curvature, by_l0, by_l1, by_l2 = curvature_with_slopes(frame, state.l0, state.l1, state.l2)
    side = 1.0 if curvature >= 0.0 else -1.0
    tight = abs(curvature) - (curvature_max - weights.curvature_margin_1pm)
    fast = abs(curvature) - curvature_wish
    return (
        _Hinge(weights.curvature * tight, side * weights.curvature, by_l0, by_l1, by_l2),
        _Hinge(weights.lateral * fast, side * weights.lateral, by_l0, by_l1, by_l2),
    )


@njit(cache=True)
def _body_pose(frame: Frame, state: _State) -> _BodyPose:
    sigma, kappa = frame.sigma, frame.kappa
    a = sigma * (1.0 - kappa * state.l0)
    d2 = a * a + state.l1 * state.l1
    yaw = frame.theta + math.atan2(state.l1, a)
    normal_x, normal_y = -math.sin(frame.theta), math.cos(frame.theta)
    return _BodyPose(
        frame.x + state.l0 * normal_x,
        frame.y + state.l0 * normal_y,
        math.cos(yaw),
        math.sin(yaw),
        normal_x,
        normal_y,
        state.l1 * sigma * kappa / d2,
        a / d2,
    )


@njit(cache=True)
def _wall_hinge(
    x: float,
    y: float,
    beside: Frame,
    lower: float,
    upper: float,
    ahead: float,
    pose: _BodyPose,
    weights: FactorWeights,
) -> _Hinge:
    """A body disc at (x, y), `ahead` of the rear axle, beyond a wall of the frame that it is abreast of."""
    mx, my = -math.sin(beside.theta), math.cos(beside.theta)
    offset = (x - beside.x) * mx + (y - beside.y) * my
    below = lower + weights.wall_margin_m - offset
    above = offset - upper + weights.wall_margin_m
    turn = ahead * (-pose.sin * mx + pose.cos * my)
    by_l0 = pose.normal_x * mx + pose.normal_y * my + turn * pose.yaw_by_l0
    sign = -weights.wall if below > above else weights.wall
    return _Hinge(weights.wall * max(below, above), sign, by_l0, turn * pose.yaw_by_l1, 0.0)


@njit(cache=True, inline="always")
def _nearest(
    x: float, y: float, obstacles: Array, near: IntArray, first: int, last: int
) -> tuple[float, int]:
    """(distance from the edge, index) of the nearest obstacle of near[first:last] to (x, y); -1 for none."""
    nearest, found = np.inf, -1
    for n in range(first, last):
        o = near[n]
        dx, dy = x - obstacles[o, 0], y - obstacles[o, 1]
        reach = nearest + obstacles[o, 2]
        if reach > 0.0 and dx * dx + dy * dy < reach * reach:
            nearest, found = math.sqrt(dx * dx + dy * dy) - obstacles[o, 2], o
    return nearest, found


@njit(cache=True)
def _collision_hinge(
    x: float, y: float, ox: float, oy: float, over: float, ahead: float, pose: _BodyPose, weight: float
) -> _Hinge:
    """A body disc at (x, y), `ahead` of the rear axle, too near to an obstacle at (ox, oy) by `over`."""
    dx, dy = x - ox, y - oy
    distance = max(math.hypot(dx, dy), 1e-9)
    gx, gy = dx / distance, dy / distance
    turn = ahead * (-pose.sin * gx + pose.cos * gy)
    by_l0 = gx * pose.normal_x + gy * pose.normal_y + turn * pose.yaw_by_l0
    return _Hinge(weight * over, -weight, by_l0, turn * pose.yaw_by_l1, 0.0)


@njit(cache=True)
def _add_hinge(normal: NormalEquations, between: Array, i: int, k: int, hinge: _Hinge) -> None:
    """Adds a hinge on the state of the k-th check point after support i."""
    j6 = normal.j6
    if k >= between.shape[0]:
        j6[0], j6[1], j6[2] = hinge.scale * hinge.by_l0, hinge.scale * hinge.by_l1, hinge.scale * hinge.by_l2
        j6[3] = j6[4] = j6[5] = 0.0
        add(normal, 3 * (i + 1), hinge.residual)
        return
    for b in range(6):
        j6[b] = hinge.scale * (
            hinge.by_l0 * between[k, 0, b] + hinge.by_l1 * between[k, 1, b] + hinge.by_l2 * between[k, 2, b]
        )
    add(normal, 3 * i, hinge.residual)


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
