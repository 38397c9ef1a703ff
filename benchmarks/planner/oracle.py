"""An independent solution of the path's optimum: a factor graph in gtsam, with its own residuals.

Needs the extra `oracle`. Nothing of the planner's factors is used: residuals are numpy expressions of the
states, and their Jacobians are complex-step derivatives, exact to rounding (Squire and Trapp 1998). What is
shared is the problem's data: frames, walls, obstacles, weights.
"""

import time
from collections.abc import Callable

import gtsam
import numpy as np
from numpy.typing import NDArray

from benchmarks.planner.scenes import SceneMaker
from benchmarks.reporting.report import Row
from contract.geometry import Array
from vehicle_agent.planning.motion.path.factors import PathProblem
from vehicle_agent.planning.motion.path.gp_path import solve_path
from vehicle_agent.planning.motion.path.path_problem import path_problem, road_from
from vehicle_agent.planning.motion.request import MotionParams, MotionRequest

Complex = NDArray[np.complex128]
Residual = Callable[[Complex], Complex]
_TINY = 1e-30


def oracle_path(problem: PathProblem, guess: Array, iterations_max: int = 300) -> tuple[Array, float]:
    """((k, 3) states of least cost, CPU seconds of the optimizer) from the guess (k, 3)."""
    graph = gtsam.NonlinearFactorGraph()
    k = len(problem.reference)
    weights = problem.weights
    unit = gtsam.noiseModel.Unit.Create
    for i in range(3):
        graph.add(gtsam.CustomFactor(unit(1), [0], _error(_unary(i, problem.start[i], weights.start), 1)))
    for i in range(1, k):
        wanted = float(problem.reference[i])
        graph.add(gtsam.CustomFactor(unit(1), [i], _error(_unary(0, wanted, weights.reference), 1)))
    graph.add(gtsam.CustomFactor(unit(1), [k - 1], _error(_unary(1, 0.0, weights.end_slope), 1)))
    graph.add(gtsam.CustomFactor(unit(1), [k - 1], _error(_unary(2, 0.0, weights.end_bend), 1)))
    for i in range(k - 1):
        graph.add(gtsam.CustomFactor(unit(3), [i, i + 1], _error(_prior(problem.step_m, weights.prior), 2)))
    sub = len(problem.between)
    for j in range(len(problem.frames)):
        i = min(j // sub, k - 2)
        residual, size = _checks(problem, j, (j - i * sub) * problem.step_m / sub)
        graph.add(gtsam.CustomFactor(unit(size), [i, i + 1], _error(residual, 2)))
    initial = gtsam.Values()
    for i in range(k):
        initial.insert(i, np.array(guess[i]))
    params = gtsam.LevenbergMarquardtParams()
    params.setMaxIterations(iterations_max)
    params.setRelativeErrorTol(1e-16)
    params.setAbsoluteErrorTol(1e-13)
    params.setlambdaUpperBound(1e12)
    optimizer = gtsam.LevenbergMarquardtOptimizer(graph, initial, params)
    begun = time.process_time()
    found = optimizer.optimize()
    spent_s = time.process_time() - begun
    return np.stack([found.atVector(i) for i in range(k)]), spent_s


def _error(residual: Residual, states: int) -> Callable[..., Array]:
    """A gtsam error function: the residual, and its Jacobians by a complex step, all columns at once."""
    size = 3 * states
    steps = np.vstack([np.zeros((1, size)), 1j * _TINY * np.eye(size)])

    def error(this: gtsam.CustomFactor, values: gtsam.Values, jacobians: list[Array] | None) -> Array:
        keys = this.keys()
        x = np.concatenate([values.atVector(key) for key in keys])
        if jacobians is None:
            return np.ascontiguousarray(residual(x[None].astype(np.complex128))[0].real)
        out = residual(x + steps)
        slopes = out[1:].imag.T / _TINY
        for n in range(states):
            jacobians[n] = np.asfortranarray(slopes[:, 3 * n : 3 * n + 3])
        return np.ascontiguousarray(out[0].real)

    return error


def _unary(axis: int, wanted: float, weight: float) -> Residual:
    return lambda x: weight * (x[:, axis : axis + 1] - wanted)


def _prior(step: float, weight: float) -> Residual:
    """White noise on jerk: the whitened difference between Phi x_i and x_i+1."""
    n = np.arange(3)
    factorial = np.array([1.0, 1.0, 2.0])
    power = np.subtract.outer(2 - n, 2 - n)
    spread = step ** (5.0 - n[:, None] - n[None, :]) / (5.0 - n[:, None] - n[None, :])
    spread /= factorial[2 - n][:, None] * factorial[2 - n][None, :]
    phi = np.where(power >= 0, step ** np.maximum(power, 0) / factorial[np.maximum(power, 0)], 0.0)
    white = np.linalg.cholesky(np.linalg.inv(spread)).T * weight
    return lambda x: (x[:, :3] @ phi.T - x[:, 3:]) @ white.T


def _checks(problem: PathProblem, j: int, tau: float) -> tuple[Residual, int]:
    """Curvature, lateral acceleration, walls and obstacles at one check point, tau after its first state."""
    px, py, theta, sigma, sigma_1, kappa, kappa_1 = problem.frames[j]
    w, step = problem.weights, problem.step_m
    t = tau / step
    powers = t ** np.arange(6)
    slope = np.array([0.0, *(n * t ** (n - 1) for n in range(1, 6))]) / step
    bend = np.array([0.0, 0.0, *(n * (n - 1) * t ** (n - 2) for n in range(2, 6))]) / step**2
    # Coefficients of the quintic through two states, by solving for them.
    ends = np.zeros((6, 6))
    ends[0, 0] = 1.0
    ends[1, 1] = 1.0 / step
    ends[2, 2] = 2.0 / step**2
    ends[3] = 1.0
    ends[4] = np.arange(6) / step
    ends[5] = np.arange(6) * (np.arange(6) - 1) / step**2
    state = np.stack([powers, slope, bend]) @ np.linalg.inv(ends)
    near = problem.obstacles[problem.near[problem.near_from[j] : problem.near_from[j + 1]]]
    beside = j + problem.disc_ahead
    walled = np.flatnonzero((beside >= 0) & (beside < len(problem.frames)))
    others = problem.frames[beside[walled]]
    low, high = problem.lower[beside[walled]], problem.upper[beside[walled]]

    def residual(x: Complex) -> Complex:
        l0, l1, l2 = (x @ state.T).T
        # p' and p'' of p = r + l n in the frame's axes.
        ahead = sigma * (1.0 - kappa * l0)
        ahead_1 = sigma_1 * (1.0 - kappa * l0) - sigma * (kappa_1 * l0 + kappa * l1)
        along_2 = ahead_1 - sigma * kappa * l1
        aside_2 = ahead * sigma * kappa + l2
        pace = np.sqrt(ahead**2 + l1**2)
        curvature = (ahead * aside_2 - l1 * along_2) / pace**3
        bent = _magnitude(curvature)
        tight = w.curvature * _hinge(bent - problem.curvature_max[j] + w.curvature_margin_1pm)
        lateral = w.lateral * _hinge(bent - problem.curvature_wish[j])
        cos = (np.cos(theta) * ahead - np.sin(theta) * l1) / pace
        sin = (np.sin(theta) * ahead + np.cos(theta) * l1) / pace
        x_m, y_m = px - l0 * np.sin(theta), py + l0 * np.cos(theta)
        disc_x = x_m[:, None] + problem.disc_x * cos[:, None]
        disc_y = y_m[:, None] + problem.disc_x * sin[:, None]
        offset = (disc_y[:, walled] - others[:, 1]) * np.cos(others[:, 2])
        offset = offset - (disc_x[:, walled] - others[:, 0]) * np.sin(others[:, 2])
        below, above = low + w.wall_margin_m - offset, offset - high + w.wall_margin_m
        walls = w.wall * _hinge(np.where(below.real > above.real, below, above))
        rows = [tight[:, None], lateral[:, None], walls]
        if len(near):
            gaps = np.sqrt((disc_x[:, :, None] - near[:, 0]) ** 2 + (disc_y[:, :, None] - near[:, 1]) ** 2)
            gaps = gaps - near[:, 2]
            nearest = np.argmin(gaps[:1].real, axis=2)[0]
            gap = gaps[:, np.arange(len(nearest)), nearest]
            rows.append(w.collision * _hinge(problem.disc_r + w.collision_margin_m - gap))
        return np.concatenate(rows, axis=1)

    return residual, 2 + len(walled) + (len(problem.disc_x) if len(near) else 0)


def _hinge(value: Complex) -> Complex:
    return np.where(value.real > 0.0, value, 0.0)


def _magnitude(value: Complex) -> Complex:
    return np.where(value.real < 0.0, -value, value)


def oracle_figures(maker: SceneMaker, scenes: int) -> Row:
    """Our path against gtsam's on random scenes: the largest difference, and how much faster ours is."""
    params = MotionParams()
    differences, ours_s, theirs_s = [], [], []
    for seed in range(scenes):
        problem = _scene_problem(maker, seed, params)
        guess = np.zeros((len(problem.reference), 3))
        guess[:, 0] = problem.reference
        guess[0] = problem.start
        solve_path(problem, guess, 300)
        begun = time.process_time()
        ours = solve_path(problem, guess, 300)
        ours_s.append(time.process_time() - begun)
        theirs, spent_s = oracle_path(problem, guess)
        theirs_s.append(spent_s)
        differences.append(float(np.abs(ours.states[:, 0] - theirs[:, 0]).max()))
    ratio = float(np.sum(theirs_s) / np.sum(ours_s))
    print(f"gtsam: {scenes} paths, differences {np.sort(differences)}, {ratio:.0f} x slower")
    return {
        "oracle_difference_m": float(np.max(differences)),
        "oracle_ratio": ratio,
        "gp_path_ms": 1e3 * float(np.median(ours_s)),
    }


def _scene_problem(maker: SceneMaker, seed: int, params: MotionParams) -> PathProblem:
    """The path through a scene's standing things, from the middle of the road."""
    scene = maker.scene(seed)
    corridor = scene.corridor()
    wide = np.ones(len(corridor.s_m))
    room = np.maximum(np.minimum(corridor.left_m, corridor.right_m) - 0.9, 0.3)
    swing = 0.4 * ((corridor.s_m > scene.s_m + 10.0) & (corridor.s_m < scene.s_m + 22.0))
    request = MotionRequest(corridor, scene.start, swing, -room, room, 4.17 * wide)
    road = road_from(request, params)
    cells = np.column_stack([scene.static_points, np.full(len(scene.static_points), 0.12)])
    desired = np.full(len(road.s_m), 3.5)
    start = np.array([0.2, 0.02, 0.0])
    return path_problem(road, scene.s_m, start, cells, desired, params, 42.0, params.path.factors())
