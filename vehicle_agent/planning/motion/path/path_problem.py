"""From a request to the path's problem: the line's frame, the walls, the obstacles and the first guess."""

import math

import msgspec
import numpy as np
from numba import njit

from contract.geometry import Array, IntArray, wrap_angle
from vehicle_agent.planning.motion.path.factors import FactorWeights, PathProblem
from vehicle_agent.planning.motion.path.frame import (
    KAPPA,
    SIGMA,
    Line,
    LineFolds,
    fit_line,
    offset_from_pose,
    project_on,
)
from vehicle_agent.planning.motion.path.gp_path import between_supports
from vehicle_agent.planning.motion.path.gp_prior import states_between
from vehicle_agent.planning.motion.request import MotionParams, MotionRequest, WarmStart

_OVERRUN_M = 6.0
_SHARP_1PM = 0.7
_DISCS = 5


class OffLine(Exception):
    """The vehicle is not on the line in a way that a path could start from."""


class Road(msgspec.Struct, frozen=True):
    """The corridor with its frame, continued straight on beyond its end; arrays (n,) by station.

    s_m, reference_m, lower_m, upper_m, speed_mps; end_m the last s that may be driven to; folds_m where the
    line folds, inf when it does not
    """

    line: Line
    s_m: np.ndarray
    reference_m: np.ndarray
    lower_m: np.ndarray
    upper_m: np.ndarray
    speed_mps: np.ndarray
    end_m: float
    folds_m: float


def road_from(request: MotionRequest, params: MotionParams) -> Road:
    """Raises LineFolds when the corridor is too short for a frame."""
    corridor = request.corridor
    n = len(corridor.s_m)
    if n < 4:
        raise LineFolds("fewer than 4 stations")
    step_m = float((corridor.s_m[-1] - corridor.s_m[0]) / (n - 1))
    extra = math.ceil(_OVERRUN_M / step_m)
    tail = corridor.points_map[-1] - corridor.points_map[max(n - 4, 0)]
    tail = tail / max(float(np.hypot(*tail)), 1e-9) * step_m
    points = np.vstack(
        [corridor.points_map, corridor.points_map[-1] + tail * np.arange(1, extra + 1)[:, None]]
    )
    s_m = corridor.s_m[0] + step_m * np.arange(n + extra)
    line = fit_line(s_m, points, params.smoothing_m)
    frames = line.frames(s_m)
    kappa = frames[:, KAPPA]
    folded = (np.abs(kappa) > _SHARP_1PM) | (frames[:, SIGMA] < 0.6) | (frames[:, SIGMA] > 1.5)
    # Inside a curve the frame ends at its centre.
    inner = 0.75 / np.maximum(np.abs(kappa), 1e-6)
    upper = np.minimum(_continued(request.upper_l_m, extra), np.where(kappa > 0.0, inner, np.inf))
    lower = np.maximum(_continued(request.lower_l_m, extra), np.where(kappa < 0.0, -inner, -np.inf))
    behind = corridor.s_m[0] - 1.0 if request.s_hint_m is None else request.s_hint_m - 1.0
    ahead = np.flatnonzero(folded & (s_m > behind))
    return Road(
        line,
        s_m,
        np.clip(_continued(request.reference_l_m, extra), lower, np.maximum(lower, upper)),
        lower,
        upper,
        _continued(request.speed_mps_max, extra),
        min(float(corridor.s_m[-1]), request.end_s_m),
        float(s_m[ahead[0]]) if len(ahead) else math.inf,
    )


def _continued(values: Array, extra: int) -> Array:
    return np.concatenate([values, np.full(extra, values[-1])])


def start_on(road: Road, request: MotionRequest) -> tuple[float, Array]:
    """(s, (3,) l, l', l'') of the start. Raises OffLine when it is abreast of nothing or heads across."""
    start, line = request.start, road.line
    pose = start.pose_map
    low, high = line.first_m, line.last_m
    if request.s_hint_m is not None:
        low, high = max(low, request.s_hint_m - 6.0), min(high, request.s_hint_m + 6.0)
    frames = line.frames(road.s_m)
    turned = 1.0 - np.cos(frames[:, 2] - pose.yaw_rad)
    away = (frames[:, 0] - pose.x_m) ** 2 + (frames[:, 1] - pose.y_m) ** 2 + 9.0 * turned
    away[(road.s_m < low) | (road.s_m > high)] = np.inf
    near_m = float(road.s_m[int(np.argmin(away))])
    s_m = float(
        project_on(
            line.control_map, line.first_m, line.step_m, pose.x_m, pose.y_m, near_m - 2.0, near_m + 2.0
        )
    )
    frame = line.frames(np.array([s_m]))[0]
    if abs(wrap_angle(pose.yaw_rad - frame[2])) > math.radians(75.0):
        raise OffLine("heading across the line")
    along_m = (pose.x_m - frame[0]) * math.cos(frame[2]) + (pose.y_m - frame[1]) * math.sin(frame[2])
    offset_m = -(pose.x_m - frame[0]) * math.sin(frame[2]) + (pose.y_m - frame[1]) * math.cos(frame[2])
    if abs(along_m) > 0.05 or abs(offset_m) > 8.0 or frame[KAPPA] * offset_m > 0.8:
        raise OffLine("too far from the line")
    return s_m, np.array(offset_from_pose(frame, pose.x_m, pose.y_m, pose.yaw_rad, start.curvature_1pm))


def path_problem(
    road: Road,
    s0_m: float,
    start: Array,
    obstacles: Array,
    desired_mps: Array,
    params: MotionParams,
    horizon_m: float,
    weights: FactorWeights,
) -> PathProblem:
    """The problem from s0 on. obstacles (m, 3) stand; desired_mps (n,) by station, for the lateral factor."""
    vehicle, limits = params.vehicle, params.limits
    step_m, sub = params.step_m, params.checks
    steps = int(min(road.line.last_m - s0_m, horizon_m) / step_m)
    if steps < 2:
        raise OffLine("the line ends here")
    support: Array = s0_m + step_m * np.arange(steps + 1, dtype=np.float64)
    check: Array = s0_m + step_m / sub * np.arange(steps * sub + 1, dtype=np.float64)
    frames = road.line.frames(check)
    desired = np.maximum(np.interp(check, road.s_m, desired_mps), 0.5)
    tight = np.full(len(check), vehicle.curvature_1pm_max)
    disc_x = vehicle.length_m * (np.arange(_DISCS) + 0.5) / _DISCS - vehicle.rear_overhang_m
    radius = math.hypot(0.5 * vehicle.length_m / _DISCS, 0.5 * vehicle.width_m)
    lower, upper = np.interp(check, road.s_m, road.lower_m), np.interp(check, road.s_m, road.upper_m)
    lower, upper = _way_back(check - s0_m, start, lower, upper, vehicle.curvature_1pm_max)
    near_from, near = nearby(
        frames,
        lower - 0.5 * vehicle.width_m - 1.0,
        upper + 0.5 * vehicle.width_m + 1.0,
        step_m / sub,
        vehicle.rear_overhang_m + 1.0,
        vehicle.box.front_m + 1.0,
        obstacles,
    )
    return PathProblem(
        s0_m,
        step_m,
        start,
        np.interp(support, road.s_m, road.reference_m),
        between_supports(step_m, sub),
        frames,
        lower,
        upper,
        tight,
        np.minimum(limits.lateral_accel_mps2_max / desired**2, vehicle.curvature_1pm_max),
        disc_x,
        radius,
        np.round(disc_x / (step_m / sub)).astype(np.int64),
        obstacles,
        near_from,
        near,
        weights,
    )


def _way_back(
    way_m: Array, start: Array, lower: Array, upper: Array, curvature_1pm_max: float
) -> tuple[Array, Array]:
    """Walls, opened for a start that is beyond one: as far out as its heading must take it, then back in."""
    turned = 1.0 - 1.0 / math.hypot(1.0, start[1])
    out_m = (turned / curvature_1pm_max) * 1.2 + 0.1
    ramp = 0.25 * np.maximum(way_m - 5.0, 0.0)
    if start[0] > upper[0]:
        upper = np.maximum(upper, start[0] + (out_m if start[1] > 0.0 else 0.1) - ramp)
    if start[0] < lower[0]:
        lower = np.minimum(lower, start[0] - (out_m if start[1] < 0.0 else 0.1) + ramp)
    return lower, upper


def first_guess(problem: PathProblem, warm: WarmStart | None) -> Array:
    """(k, 3): the path before where it reaches and still begins here, else a swing over to the reference."""
    support = problem.support_m()
    guess = np.zeros((len(support), 3))
    guess[:, 0] = problem.reference
    off_m = abs(problem.start[0] - problem.reference[0])
    reach_m = 6.0 + 4.0 * math.sqrt(off_m) + 4.0 * abs(float(problem.start[1]))
    over = support < problem.first_m + reach_m
    target = float(np.interp(problem.first_m + reach_m, support, problem.reference))
    ends = np.array([problem.start * (1.0, 1.0, 0.0), [target, 0.0, 0.0]])
    guess[over] = states_between(ends, reach_m, problem.first_m, support[over])
    if warm is not None and len(warm.s_m) >= 2:
        before = np.column_stack([np.interp(support, warm.s_m, warm.states[:, axis]) for axis in range(3)])
        known = (support >= warm.s_m[0]) & (support <= warm.s_m[-1])
        if known[0] and abs(before[0, 0] - problem.start[0]) < 0.3:
            guess[known] = before[known]
    guess[0] = problem.start
    return guess


@njit(cache=True)
def nearby(
    frames: Array, lower: Array, upper: Array, spacing: float, behind: float, ahead: float, obstacles: Array
) -> tuple[IntArray, IntArray]:
    """Which obstacles (m, 3) matter at each check point: (first (c + 1,), indices); walls hide the rest."""
    checks, count = frames.shape[0], obstacles.shape[0]
    low, high = np.zeros(count, np.int64), np.full(count, -1, np.int64)
    for o in range(count):
        best, at = np.inf, -1
        for j in range(checks):
            d2 = (obstacles[o, 0] - frames[j, 0]) ** 2 + (obstacles[o, 1] - frames[j, 1]) ** 2
            if d2 < best:
                best, at = d2, j
        if at < 0:
            continue
        dx, dy = obstacles[o, 0] - frames[at, 0], obstacles[o, 1] - frames[at, 1]
        cos, sin = math.cos(frames[at, 2]), math.sin(frames[at, 2])
        along, aside, radius = cos * dx + sin * dy, -sin * dx + cos * dy, obstacles[o, 2]
        if abs(along) > ahead + radius or aside + radius < lower[at] or aside - radius > upper[at]:
            continue
        low[o] = max(0, at - int((ahead + radius) / spacing) - 1)
        high[o] = min(checks - 1, at + int((behind + radius) / spacing) + 1)
    first = np.zeros(checks + 1, np.int64)
    for o in range(count):
        for j in range(low[o], high[o] + 1):
            first[j + 1] += 1
    for j in range(checks):
        first[j + 1] += first[j]
    at_ = first.copy()
    indices = np.empty(first[checks], np.int64)
    for o in range(count):
        for j in range(low[o], high[o] + 1):
            indices[at_[j]] = o
            at_[j] += 1
    return first, indices
