"""One motion: path, then speed, then path again until neither has a violation (Snow Lion, Fig. 5).

Budgets are counts. There is always an answer: the plan, or the mildest stop without a violation on the new
path, on the previous path, or on the present steering arc.
"""

import math

import numpy as np

from contract.geometry import Array
from contract.wire.reasons import SpeedLimitReason
from vehicle_agent.planning.motion.agents import MovingDiscs, moving_discs
from vehicle_agent.planning.motion.fallback import MotionCandidate, badness, judge, on_arc, safest, stops
from vehicle_agent.planning.motion.flanks import held_at_flanks
from vehicle_agent.planning.motion.path.factors import FactorWeights, PathProblem
from vehicle_agent.planning.motion.path.frame import LineFolds
from vehicle_agent.planning.motion.path.gp_path import SolvedPath, solve_path
from vehicle_agent.planning.motion.path.path_problem import (
    OffLine,
    Road,
    first_guess,
    path_problem,
    road_from,
    start_on,
)
from vehicle_agent.planning.motion.path.path_samples import sample_path
from vehicle_agent.planning.motion.request import Motion, MotionParams, MotionRequest, WarmStart
from vehicle_agent.planning.motion.speed.path_graph import path_graph
from vehicle_agent.planning.motion.speed.profiles import profile_from_plan, rows_on_path, until_rest
from vehicle_agent.planning.motion.speed.speed_step import plan_speed
from vehicle_agent.planning.motion.validation import check_request

# What another path could mend; for the rest the same one would come out again.
_PATH_FAULTS = frozenset({"curvature", "lateral", "wall", "static", "kinematics", "start"})


def plan_motion(request: MotionRequest, params: MotionParams) -> Motion:
    """The motion for the next 8 s; never without rows.

    Raises MotionRequestError for arrays that do not fit and for a start or corridor that is not finite.
    """
    check_request(request)
    slots = round(params.horizon_s / params.row_s) + 1
    times: Array = params.row_s * np.arange(slots, dtype=np.float64)
    moving = moving_discs(request.agents, times, params.track_mps_max)
    still = _standing(moving, params.moving_m)
    moving = held_at_flanks(moving, request.start.pose_map, params.vehicle.box)
    road: Road | None = None
    try:
        road = road_from(request, params)
        s0_m, start = start_on(road, request)
        if road.folds_m - 2.0 < s0_m:
            raise LineFolds("the line folds here")
        draft, used = _refined(request, params, road, s0_m, start, still, moving)
    except LineFolds:
        return on_arc(request, params, "line_folds", moving)
    except OffLine:
        folds = road is not None and _folds_near(road, request)
        return on_arc(request, params, "line_folds" if folds else "off_line", moving)
    if draft.wrong:
        draft = safest(request, params, road, s0_m, start, moving, draft)
    return _answer(draft, request, used, moving)


def _folds_near(road: Road, request: MotionRequest) -> bool:
    """The start is where the line folds, so that there is no telling which way along it is forward."""
    if math.isinf(road.folds_m):
        return False
    frame = road.line.frames(np.array([road.folds_m]))[0]
    pose = request.start.pose_map
    return math.hypot(frame[0] - pose.x_m, frame[1] - pose.y_m) < 6.0


def _refined(
    request: MotionRequest,
    params: MotionParams,
    road: Road,
    s0_m: float,
    start: Array,
    still: Array,
    moving: MovingDiscs,
) -> tuple[MotionCandidate, int]:
    """(best candidate, iterations). Refines the path by the last speed profile, and tries again."""
    limits = params.limits
    weights = params.path.factors()
    obstacles = np.vstack([request.static_discs, still])
    top = max(limits.speed_mps_max, request.start.speed_mps)
    horizon_m = top * params.horizon_s + top**2 / (2.0 * limits.decel_mps2_comfort) + params.vehicle.length_m
    reach = np.sqrt(
        request.start.speed_mps**2 + 2.0 * limits.accel_mps2_max * np.maximum(road.s_m - s0_m, 0.0)
    )
    desired = np.minimum(np.minimum(road.speed_mps, limits.speed_mps_max), reach)
    best: MotionCandidate | None = None
    used = 0
    warm = request.warm
    while used < params.iterations_max:
        used += 1
        problem = path_problem(road, s0_m, start, obstacles, desired, params, horizon_m, weights)
        path = _best_path(problem, warm, params)
        draft = _draft(request, params, road, path, moving)
        if best is None or badness(draft.wrong) < badness(best.wrong):
            best = draft
        if not _PATH_FAULTS.intersection(draft.wrong):
            break
        # The next path has wider margins, and lateral limits by the speeds planned on this one.
        warm = WarmStart(problem.support_m(), path.states)
        if draft.speed.plan is not None:
            desired = np.interp(road.s_m, draft.rows[:, 7], np.maximum(draft.rows[:, 5], 0.5))
        weights = _stricter(weights)
    assert best is not None
    return best, used


def _stricter(weights: FactorWeights) -> FactorWeights:
    """Wider margins, more weight on lateral acceleration and less on the reference: for another try."""
    return weights._replace(
        curvature_margin_1pm=weights.curvature_margin_1pm * 3.0,
        wall_margin_m=weights.wall_margin_m + 0.05,
        lateral=weights.lateral * 2.0,
        reference=weights.reference * 0.7,
    )


def _best_path(problem: PathProblem, warm: WarmStart | None, params: MotionParams) -> SolvedPath:
    """From the path before; when the reference has moved away, also from the reference: the cheaper."""
    guess = first_guess(problem, warm)
    path = solve_path(problem, guess, params.path_iterations_max)
    if warm is not None and np.abs(guess[1:, 0] - problem.reference[1:]).max() > 0.8:
        fresh = solve_path(problem, first_guess(problem, None), params.path_iterations_max)
        if fresh.cost < path.cost - 1e-6:
            return fresh
    return path


def _standing(moving: MovingDiscs, moved_m: float) -> Array:
    """(m, 3) discs that stay where they are over the horizon: the path goes around them."""
    if not moving.discs.shape[1]:
        return np.empty((0, 3))
    way = np.hypot(*(moving.discs[-1, :, :2] - moving.discs[0, :, :2]).T)
    still: Array = moving.discs[0, way < moved_m]
    return still


def _draft(
    request: MotionRequest, params: MotionParams, road: Road, path: SolvedPath, moving: MovingDiscs
) -> MotionCandidate:
    samples = sample_path(road.line, path, params.sample_m)
    speed = plan_speed(request, params, road, samples, moving, request.static_discs)
    if speed.plan is None or speed.inside:
        return stops(request, params, road, path, samples, speed)[0]
    rows = rows_on_path(until_rest(profile_from_plan(speed.plan, params.row_s)), samples, road.line, path)
    return MotionCandidate(path, samples, speed, rows, "planned", judge(rows, request, params, "planned"))


def _why_stopped(draft: MotionCandidate) -> SpeedLimitReason:
    """The reason for a stop: the agent, or a plan that violates its limits."""
    if draft.speed.inside:
        return "footprint"
    if "agent" in draft.instead:
        return "emergency" if draft.quality == "emergency" else "yielding"
    return "infeasible"


def _answer(draft: MotionCandidate, request: MotionRequest, used: int, moving: MovingDiscs) -> Motion:
    speed, path = draft.speed, draft.path
    limited = speed.limited_by
    if draft.quality != "planned":
        limited = _why_stopped(draft)
    figures = (
        ("path_cost", path.cost),
        ("path_iterations", float(path.iterations)),
        ("search_nodes", float(speed.nodes)),
        ("speed_iterations", float(speed.plan.iterations if speed.plan else 0)),
        ("corridor_excess_m", float(speed.plan.excess_m if speed.plan else 0.0)),
        ("doubted", float(len(moving.doubted))),
    )
    support = path.first_m + path.step_m * np.arange(len(path.states))
    return Motion(
        draft.rows,
        WarmStart(support, path.states),
        not draft.wrong,
        draft.wrong,
        limited,
        draft.quality,
        used,
        request.agents.ids[speed.yields_to],
        request.agents.ids[speed.passes],
        speed.cut_s_m,
        figures,
        draft.instead,
        path_graph(speed, draft.samples, draft.rows, request),
    )
