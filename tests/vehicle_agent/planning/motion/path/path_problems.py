"""Path problems with every factor at work."""

import numpy as np

from contract.geometry import Array
from tests.vehicle_agent.planning.motion.scenes import a_corridor, a_request
from vehicle_agent.planning.motion.path.factors import PathProblem, normal_equations, path_cost
from vehicle_agent.planning.motion.path.gp_prior import information, transition
from vehicle_agent.planning.motion.path.path_problem import path_problem, road_from
from vehicle_agent.planning.motion.request import MotionParams


def problem_with(
    *,
    obstacles: Array,
    room_m: float = 1.5,
    start: tuple[float, float, float] = (0.0, 0.0, 0.0),
    curvature_1pm: float = 0.0,
    swing_m: float = 0.0,
) -> PathProblem:
    """40 m of road with the reference swinging aside and back."""
    params = MotionParams()
    corridor = a_corridor(curvature_1pm)
    reference = swing_m * ((corridor.s_m > 12.0) & (corridor.s_m < 26.0))
    road = road_from(a_request(corridor, room_m=room_m, reference_l_m=reference), params)
    desired = np.full(len(road.s_m), 4.0)
    weights = params.path.factors()
    return path_problem(road, 0.0, np.array(start), obstacles, desired, params, 40.5, weights)


def a_problem(seed: int) -> PathProblem:
    """Random start, bend, swing and obstacles beside the way."""
    random = np.random.default_rng(seed)
    curvature = float(random.uniform(-0.08, 0.08))
    count = 12
    s = random.uniform(6.0, 38.0, count)
    aside = random.choice([-1.0, 1.0], count) * random.uniform(1.3, 2.2, count)
    half = np.sinc(0.5 * curvature * s / np.pi)
    middle, turn = 0.5 * curvature * s, curvature * s
    x, y = s * half * np.cos(middle), s * half * np.sin(middle)
    obstacles = np.column_stack([x - aside * np.sin(turn), y + aside * np.cos(turn), np.full(count, 0.25)])
    start = (float(random.uniform(-0.5, 0.5)), float(random.uniform(-0.2, 0.2)), 0.0)
    return problem_with(
        obstacles=obstacles,
        room_m=1.0,
        start=start,
        curvature_1pm=curvature,
        swing_m=float(random.uniform(-1.0, 1.0)),
    )


def cost_and_slopes(problem: PathProblem, x: Array) -> tuple[float, Array, Array]:
    """(cost, (6, 3 k) band of the normal matrix, (3 k,) gradient) at x (k, 3)."""
    normal = normal_equations(x.size)
    prior, phi = information(problem.step_m), transition(problem.step_m)
    cost = path_cost(np.ascontiguousarray(x), problem, prior, phi, normal, True)
    return cost, normal.band, normal.gradient
