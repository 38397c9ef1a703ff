"""One motion: path, then speed, then path again until nothing is wrong with them (Snow Lion, Fig. 5).

The room and its budgets know counts only. There is always an answer: the plan, or the mildest stop on the new
path, on the path before, or on the present steering arc that an independent check finds nothing wrong with.
"""

import math

import msgspec
import numpy as np

from contract.geometry import Array
from vehicle_agent.planning.motion.agents import MovingDiscs, check_agents, moving_discs
from vehicle_agent.planning.motion.checker import violations
from vehicle_agent.planning.motion.factors import CURVATURE_MARGIN, LATERAL, REFERENCE, WALL_MARGIN
from vehicle_agent.planning.motion.frame import LineFolds
from vehicle_agent.planning.motion.gp_path import PathProblem, SolvedPath, solve_path
from vehicle_agent.planning.motion.path_problem import (
    OffLine,
    Road,
    first_guess,
    path_problem,
    road_from,
    start_on,
)
from vehicle_agent.planning.motion.path_samples import PathSamples, sample_path
from vehicle_agent.planning.motion.profiles import (
    profile_from_plan,
    rows_on_arc,
    rows_on_path,
    stop_profiles,
    until_rest,
)
from vehicle_agent.planning.motion.request import (
    Motion,
    MotionParams,
    MotionRequest,
    MotionRequestError,
    Quality,
    WarmStart,
)
from vehicle_agent.planning.motion.speed_step import Speed, plan_speed

_CONTACT = frozenset({"agent", "static", "footprint"})


class Draft(msgspec.Struct, frozen=True):
    """One try: a path with its speed, rows, and what is wrong with them."""

    path: SolvedPath
    samples: PathSamples
    speed: Speed
    rows: np.ndarray
    quality: Quality
    wrong: tuple[str, ...]


def plan_motion(request: MotionRequest, params: MotionParams) -> Motion:
    """The motion for the next 8 s; never without rows.

    Raises MotionRequestError for arrays that do not fit and for a start or corridor that is not finite.
    """
    check_request(request)
    times = params.row_s * np.arange(round(params.horizon_s / params.row_s) + 1)
    moving = moving_discs(request.agents, times, params.track_mps_max)
    try:
        road = road_from(request, params)
        s0_m, start = start_on(road, request)
        if road.folds_m - 2.0 < s0_m:
            raise LineFolds("the line folds here")
        draft, used = _refined(request, params, road, s0_m, start, moving)
    except LineFolds:
        return _on_arc(request, params, "line_folds", moving)
    except OffLine:
        return _on_arc(request, params, "off_line", moving)
    if draft.wrong:
        draft = _safest(request, params, road, s0_m, start, moving, draft)
    return _answer(draft, request, used, moving)


def check_request(request: MotionRequest) -> None:
    """Raises MotionRequestError with what is wrong."""
    corridor = request.corridor
    n = len(corridor.s_m)
    if n == 0:
        raise MotionRequestError("the corridor has no stations")
    for name in ("reference_l_m", "lower_l_m", "upper_l_m", "speed_mps_max"):
        values = getattr(request, name)
        if values.shape != (n,):
            raise MotionRequestError(f"{name} has shape {values.shape}, not {(n,)}")
        if np.isnan(values).any():
            raise MotionRequestError(f"{name} has a NaN")
    if corridor.points_map.shape != (n, 2) or not np.isfinite(corridor.points_map).all():
        raise MotionRequestError("corridor.points_map must be (n, 2) and finite")
    steps = np.diff(corridor.s_m)
    if not np.isfinite(corridor.s_m).all() or (n > 1 and (steps <= 0.0).any()):
        raise MotionRequestError("corridor.s_m must rise")
    if n > 1 and np.ptp(steps) > 0.02 * steps.mean():
        raise MotionRequestError("corridor.s_m must have even steps")
    pose, start = request.start.pose_map, request.start
    known = (pose.x_m, pose.y_m, pose.yaw_rad, start.speed_mps, start.accel_mps2, start.curvature_1pm)
    if not all(math.isfinite(value) for value in known):
        raise MotionRequestError("the start is not finite")
    if request.static_discs.ndim != 2 or request.static_discs.shape[1] != 3:
        raise MotionRequestError(f"static_discs has shape {request.static_discs.shape}, not (m, 3)")
    if not np.isfinite(request.static_discs).all():
        raise MotionRequestError("static_discs are not finite")
    if math.isnan(request.end_s_m):
        raise MotionRequestError("end_s_m is NaN")
    check_agents(request.agents)


def _refined(
    request: MotionRequest,
    params: MotionParams,
    road: Road,
    s0_m: float,
    start: Array,
    moving: MovingDiscs,
) -> tuple[Draft, int]:
    """(best draft, iterations): the path is bent to what the last speed profile showed, and tried again."""
    limits = params.limits
    weights = params.path.vector()
    obstacles = np.vstack([request.static_discs, _standing(moving, params.moving_m)])
    top = max(limits.speed_mps_max, request.start.speed_mps)
    horizon_m = top * params.horizon_s + top**2 / (2.0 * limits.decel_mps2_comfort) + params.vehicle.length_m
    reach = np.sqrt(
        request.start.speed_mps**2 + 2.0 * limits.accel_mps2_max * np.maximum(road.s_m - s0_m, 0.0)
    )
    wish = np.minimum(np.minimum(road.speed_mps, limits.speed_mps_max), reach)
    best: Draft | None = None
    used = 0
    warm = request.warm
    for used in range(1, params.iterations_max + 1):
        problem = path_problem(road, s0_m, start, obstacles, wish, params, horizon_m, weights)
        path = _best_path(problem, warm, params)
        draft = _draft(request, params, road, path, moving)
        if best is None or _badness(draft.wrong) < _badness(best.wrong):
            best = draft
        if not draft.wrong:
            break
        # What was breached gets a wider margin, and the lateral factor the speeds that were planned.
        warm = WarmStart(problem.support_m(), path.states)
        if draft.speed.plan is not None:
            wish = np.interp(road.s_m, draft.rows[:, 7], np.maximum(draft.rows[:, 5], 0.5))
        weights = weights.copy()
        weights[CURVATURE_MARGIN] *= 1.6
        weights[WALL_MARGIN] += 0.05
        weights[LATERAL] *= 2.0
        weights[REFERENCE] *= 0.7
    assert best is not None
    return best, used


def _best_path(problem: PathProblem, warm: WarmStart | None, params: MotionParams) -> SolvedPath:
    """From the path before; when the reference has moved away from it, also from the reference: the cheaper."""
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
) -> Draft:
    samples = sample_path(road.line, path, params.sample_m)
    speed = plan_speed(request, params, road, samples, moving, request.static_discs)
    if speed.plan is None or speed.inside:
        return _stops(request, params, road, path, samples, speed)[0]
    rows = rows_on_path(until_rest(profile_from_plan(speed.plan, params.row_s)), samples, road.line, path)
    return Draft(path, samples, speed, rows, "planned", _judge(rows, request, params, "planned"))


def _judge(rows: Array, request: MotionRequest, params: MotionParams, quality: Quality) -> tuple[str, ...]:
    return violations(rows, request, params.vehicle, params.limits, emergency=quality == "emergency")


def _badness(wrong: tuple[str, ...]) -> tuple[int, int]:
    """Contacts first, then the number of violations."""
    return len(_CONTACT.intersection(wrong)), len(wrong)


def _stops(
    request: MotionRequest,
    params: MotionParams,
    road: Road,
    path: SolvedPath,
    samples: PathSamples,
    speed: Speed,
) -> tuple[Draft, ...]:
    """Stops on this path, the best first: the mildest without a violation, else the least bad hardest."""
    drafts = []
    for quality, profile in stop_profiles(request.start, params.limits, params.row_s, params.horizon_s):
        rows = rows_on_path(until_rest(profile), samples, road.line, path)
        kind: Quality = "stop" if quality == "stop" else "emergency"
        draft = Draft(path, samples, speed, rows, kind, _judge(rows, request, params, kind))
        if not draft.wrong:
            return (draft,)
        drafts.append(draft)
    return tuple(sorted(reversed(drafts), key=lambda draft: _badness(draft.wrong)))


def _safest(
    request: MotionRequest,
    params: MotionParams,
    road: Road,
    s0_m: float,
    start: Array,
    moving: MovingDiscs,
    draft: Draft,
) -> Draft:
    """The plan is not right: a stop on its path, or on the path before, whichever is less wrong."""
    choices = [*_stops(request, params, road, draft.path, draft.samples, draft.speed)[:1], draft]
    if request.warm is not None and _badness(choices[0].wrong) > (0, 0):
        old = _old_path(request.warm, s0_m, start, params)
        if old is not None:
            samples = sample_path(road.line, old, params.sample_m)
            speed = plan_speed(request, params, road, samples, moving, request.static_discs)
            choices += _stops(request, params, road, old, samples, speed)[:1]
    return min(choices, key=lambda choice: _badness(choice.wrong))


def _old_path(warm: WarmStart, s0_m: float, start: Array, params: MotionParams) -> SolvedPath | None:
    """The path before from here on, when the vehicle is still on it."""
    steps = int((warm.s_m[-1] - s0_m) / params.step_m) if len(warm.s_m) >= 2 else 0
    if steps < 4:
        return None
    support = s0_m + params.step_m * np.arange(steps + 1)
    states = np.column_stack([np.interp(support, warm.s_m, warm.states[:, axis]) for axis in range(3)])
    if abs(states[0, 0] - start[0]) > 0.3:
        return None
    states[0] = start
    return SolvedPath(s0_m, params.step_m, states, math.inf, 0, False)


def _answer(draft: Draft, request: MotionRequest, used: int, moving: MovingDiscs) -> Motion:
    speed, path = draft.speed, draft.path
    limited = speed.limited_by
    if draft.quality != "planned":
        limited = "footprint" if speed.inside else ("emergency" if draft.quality == "emergency" else "stop")
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
    )


def _on_arc(request: MotionRequest, params: MotionParams, why: str, moving: MovingDiscs) -> Motion:
    """A comfortable stop on the steering arc of now, harder when that would touch something."""
    s_m = request.s_hint_m if request.s_hint_m is not None else float(request.corridor.s_m[0])
    best: tuple[tuple[int, int], Array, Quality] | None = None
    for quality, profile in stop_profiles(request.start, params.limits, params.row_s, params.horizon_s):
        kind: Quality = "stop" if quality == "stop" else "emergency"
        rows = rows_on_arc(until_rest(profile), request.start, params.vehicle.curvature_1pm_max, s_m)
        hits = _CONTACT.intersection(_judge(rows, request, params, kind))
        if best is None or (len(hits), 0) < best[0]:
            best = ((len(hits), 0), rows, kind)
        if not hits:
            break
    assert best is not None
    none = np.empty(0, np.int64)
    return Motion(
        best[1],
        None,
        False,
        (why,),
        why,
        best[2],
        0,
        none,
        none,
        np.inf,
        (("doubted", float(len(moving.doubted))),),
    )
