"""The lateral offset of the reference route (Snow Lion, behavioral planning, Fig. 6).

d_t = argmin over the candidates of J_s + J_d + J_o + J_dyn. The paper uses d_t and d_0 for two things each;
here `chosen` is the choice and `now` the vehicle's offset.
"""

import math
from typing import NamedTuple

import msgspec
import numpy as np
from numba import njit

from contract.geometry import Array
from vehicle_agent.planning.motion.clearance import Box, BoxPose, box_distance

# columns of a disc, and of the rating of one candidate
DISC_X, DISC_Y, DISC_R = range(3)
COST, FREE_M, CLEARANCE_MIN, CLEARANCE_MEAN, RISK = range(5)
RATINGS = 5
# An obstacle at the flank may come this much nearer: the tail swings a little, and tracks wander.
_NEARER_M = 0.05


class OffsetRules(NamedTuple):
    """The weights of the paper's cost, and hysteresis against weaving.

    A tuple, so that kernels take it as it is.

    free_weight w_s; from_now_weight w_d1, from_centre_weight w_d2; mean_clearance_weight w_o1,
    least_clearance_weight w_o2; dynamic_weight of J_dyn
    clearance_floor_m  smaller clearances count as this, so that a touch has a finite cost
    touch_m            a smaller clearance ends the free way; an obstacle nearer already must not come nearer
    threshold_m        a larger step is a lane change: it must be better for `patience` plans in a row
    better_by          and lower the cost by this much
    """

    free_weight: float = 10.0
    from_now_weight: float = 0.8
    from_centre_weight: float = 0.5
    mean_clearance_weight: float = 0.3
    least_clearance_weight: float = 0.25
    dynamic_weight: float = 12.0
    clearance_floor_m: float = 0.1
    touch_m: float = 0.1
    threshold_m: float = 0.35
    patience: int = 3
    better_by: float = 0.3
    look_m: float = 30.0
    step_m: float = 1.0
    blend_m: float = 5.0
    blend_s: float = 2.0
    moving_s: float = 5.0
    moving_step_s: float = 0.5


class Stations(NamedTuple):
    """The road by station, every step_m: points (n, 2), yaws, curvatures, lower, upper (n,).

    first, last  the vehicle's station, and the last one to rate; stride: every stride-th station is rated
    """

    points: Array
    yaws: Array
    curvatures: Array
    lower: Array
    upper: Array
    step_m: float
    first: int
    last: int
    stride: int


class Movers(NamedTuple):
    """Moving road users where they are predicted to be; a tuple, so that kernels take it as it is.

    poses    (a, k, 3) x, y, yaw of the outline's middle, moving_step_s, twice that, ... after the start
    sizes_m  (a, 2) length, width
    wider_m  (a, k) the outline is widened by this: w_o, and how uncertain the place is
    """

    poses: Array
    sizes_m: Array
    wider_m: Array


class Blend(NamedTuple):
    """How the offset leaves the present one: from now_m with this slope to the goal, blend_m later."""

    now_m: float
    slope: float
    blend_m: float


class _SweptOffset(NamedTuple):
    """One candidate swept along the road: whether there is room, the free way, least and mean clearance."""

    has_room: bool
    free_m: float
    least_m: float
    mean_m: float


class OffsetChoice(msgspec.Struct, frozen=True):
    """better_* see `PlanMemory`; free_m: way until something that stands is met, or inf."""

    offset_m: float
    better_offset_m: float
    better_count: int
    free_m: float


def choose(
    rules: OffsetRules, candidates_m: Array, ratings: Array, before_m: float, better_m: float, count: int
) -> OffsetChoice:
    """The candidate to follow; ratings (c, 5) from `rate`, inf cost where the road has no room.

    before_m: the last choice; better_m, count: the better candidate so far, and for how many plans in a row.
    When no candidate has room, the vehicle keeps the last choice, with no free way.
    """
    costs = ratings[:, COST]
    if not np.isfinite(costs).any():
        return OffsetChoice(before_m, before_m, 0, 0.0)
    best = int(np.argmin(costs))
    kept = int(np.argmin(np.abs(candidates_m - before_m)))
    best_m = float(candidates_m[best])
    if not np.isfinite(costs[kept]):
        return OffsetChoice(best_m, best_m, 0, _free(ratings, best))
    step_m = abs(best_m - float(candidates_m[kept]))
    if best == kept or costs[best] > costs[kept] - rules.better_by:
        return OffsetChoice(float(candidates_m[kept]), before_m, 0, _free(ratings, kept))
    if step_m <= rules.threshold_m:
        return OffsetChoice(best_m, best_m, 0, _free(ratings, best))
    count = count + 1 if best_m == better_m else 1
    if count > rules.patience:
        return OffsetChoice(best_m, best_m, 0, _free(ratings, best))
    return OffsetChoice(float(candidates_m[kept]), best_m, count, _free(ratings, kept))


def _free(ratings: Array, i: int) -> float:
    return float(ratings[i, FREE_M])


@njit(cache=True)
def blended(now_m: float, slope: float, goal_m: float, along_m: float, blend_m: float) -> tuple[float, float]:
    """(l, dl/ds) of a cubic from offset and slope now to the goal without slope, blend_m later."""
    if along_m >= blend_m:
        return goal_m, 0.0
    u = max(0.0, along_m / blend_m)
    h00, h10 = 2.0 * u**3 - 3.0 * u**2 + 1.0, u**3 - 2.0 * u**2 + u
    h01 = -2.0 * u**3 + 3.0 * u**2
    d00, d10 = 6.0 * u**2 - 6.0 * u, 3.0 * u**2 - 4.0 * u + 1.0
    offset = h00 * now_m + h10 * blend_m * slope + h01 * goal_m
    return offset, (d00 * (now_m - goal_m) + d10 * blend_m * slope) / blend_m


@njit(cache=True)
def rate(
    stations: Stations,
    candidates: Array,
    blend: Blend,
    speed_mps: float,
    discs: Array,
    moving: Movers,
    box: Box,
    rules: OffsetRules,
) -> Array:
    """(c, 5) cost, free way, least and mean clearance, and risk of each candidate offset (c,).

    discs (m, 3) of stationary obstacles; moving: predicted road users.
    """
    out = np.zeros((candidates.shape[0], RATINGS))
    touch = _touch_distances(stations, blend, box, discs, rules.touch_m)
    for c in range(candidates.shape[0]):
        goal = candidates[c]
        swept = _sweep(stations, blend, goal, box, discs, touch)
        if not swept.has_room:
            out[c, COST] = np.inf
            continue
        risk = _risk(stations, blend, goal, speed_mps, moving, box, rules)
        shown = min(swept.free_m, rules.look_m)
        out[c, COST] = (
            rules.free_weight * (1.0 - shown / rules.look_m)
            + rules.from_now_weight * abs(goal - blend.now_m)
            + rules.from_centre_weight * abs(goal)
            + rules.mean_clearance_weight / max(swept.mean_m, rules.clearance_floor_m)
            + rules.least_clearance_weight / max(swept.least_m, rules.clearance_floor_m)
            + rules.dynamic_weight * risk
        )
        out[c, FREE_M] = swept.free_m
        out[c, CLEARANCE_MIN], out[c, CLEARANCE_MEAN], out[c, RISK] = swept.least_m, swept.mean_m, risk
    return out


@njit(cache=True)
def _body_at(
    x_m: float, y_m: float, yaw_rad: float, curvature_1pm: float, offset: float, turn: float
) -> BoxPose:
    """The body abreast of a station, at an offset that changes by `turn` per metre."""
    yaw = yaw_rad + math.atan2(turn, max(0.2, 1.0 - curvature_1pm * offset))
    x = x_m - offset * math.sin(yaw_rad)
    y = y_m + offset * math.cos(yaw_rad)
    return BoxPose(x, y, math.cos(yaw), math.sin(yaw))


@njit(cache=True)
def _touch_distances(stations: Stations, blend: Blend, box: Box, discs: Array, touch_m: float) -> Array:
    """(m,) the clearance below which each disc is touched; for a disc alongside, its present clearance."""
    points, i = stations.points, stations.first
    yaw, curvature = stations.yaws[i], stations.curvatures[i]
    at = _body_at(points[i, 0], points[i, 1], yaw, curvature, blend.now_m, blend.slope)
    out = np.full(discs.shape[0], touch_m)
    for k in range(discs.shape[0]):
        px, py = discs[k, DISC_X], discs[k, DISC_Y]
        if abs(px - at.x_m) < 10.0 and abs(py - at.y_m) < 10.0:
            now = box_distance(at, box, px, py) - discs[k, DISC_R]
            out[k] = min(touch_m, now - _NEARER_M)
    return out


@njit(cache=True)
def _sweep(
    stations: Stations, blend: Blend, goal: float, box: Box, discs: Array, touch: Array
) -> _SweptOffset:
    """The body moved along the road with the offset going over to `goal`, until it touches a disc."""
    points, yaws, curvatures = stations.points, stations.yaws, stations.curvatures
    lower, upper = stations.lower, stations.upper
    free, least, total, count = np.inf, np.inf, 0.0, 0
    for i in range(stations.first, stations.last + 1, stations.stride):
        along = (i - stations.first) * stations.step_m
        offset, turn = blended(blend.now_m, blend.slope, goal, along, blend.blend_m)
        if along >= blend.blend_m and (offset < lower[i] or offset > upper[i]):
            return _SweptOffset(False, np.inf, 0.0, 0.0)
        at = _body_at(points[i, 0], points[i, 1], yaws[i], curvatures[i], offset, turn)
        clearance, touches = _clearance(at, box, discs, touch)
        if touches:
            free = along
            break
        least = min(least, clearance)
        total += clearance
        count += 1
    mean = total / count if count else 0.0
    return _SweptOffset(True, free, least if count else 0.0, mean)


@njit(cache=True)
def _clearance(at: BoxPose, box: Box, discs: Array, touch: Array) -> tuple[float, bool]:
    """(to the nearest disc, at most 5 m; whether one is nearer than its `touch`)."""
    nearest, touches = 5.0, False
    for k in range(discs.shape[0]):
        px, py = discs[k, DISC_X], discs[k, DISC_Y]
        if abs(px - at.x_m) > 10.0 or abs(py - at.y_m) > 10.0:
            continue
        distance = box_distance(at, box, px, py) - discs[k, DISC_R]
        nearest = min(nearest, distance)
        touches |= distance < touch[k]
    return nearest, touches


@njit(cache=True)
def _risk(
    stations: Stations,
    blend: Blend,
    goal: float,
    speed: float,
    moving: Movers,
    box: Box,
    rules: OffsetRules,
) -> float:
    """The risk from road users who move; meeting them nearer and sooner costs more. The vehicle drives at a
    constant speed, also past what stands in its way, and road users are where they are predicted.

    A way that ends early meets nobody. If that counted in its favour, the vehicle would choose it in a crowd,
    and stand."""
    poses, sizes, wider = moving.poses, moving.sizes_m, moving.wider_m
    points, yaws, curvatures = stations.points, stations.yaws, stations.curvatures
    risk = 0.0
    for j in range(poses.shape[1] if poses.shape[0] else 0):
        t = (j + 1) * rules.moving_step_s
        along = speed * t
        i = stations.first + math.floor(along / stations.step_m)
        if i > stations.last:
            break
        offset, turn = blended(blend.now_m, blend.slope, goal, along, blend.blend_m)
        at = _body_at(points[i, 0], points[i, 1], yaws[i], curvatures[i], offset, turn)
        for k in range(poses.shape[0]):
            if abs(poses[k, j, 0] - at.x_m) > 8.0 or abs(poses[k, j, 1] - at.y_m) > 8.0:
                continue
            distance = _distance_to_road_user(at, box, poses[k, j], sizes[k], wider[k, j])
            if distance < 0.4:
                risk += (0.4 - max(distance, -0.4)) / 0.8 * math.exp(-t / 3.0) * rules.moving_step_s
    return risk


@njit(cache=True)
def _distance_to_road_user(at: BoxPose, box: Box, pose: Array, size: Array, wider: float) -> float:
    """Distance to the edge of one moving road user with its middle at a pose (3,); size (2,).

    A long one is three discs.
    """
    length, width = size[0], size[1]
    reach = 0.5 * width + wider
    distance: float = box_distance(at, box, pose[0], pose[1]) - reach
    if length > 1.5 * width:
        along_x = math.cos(pose[2]) * 0.5 * (length - width)
        along_y = math.sin(pose[2]) * 0.5 * (length - width)
        for side in (-1.0, 1.0):
            end = box_distance(at, box, pose[0] + side * along_x, pose[1] + side * along_y)
            distance = min(distance, end - reach)
    return distance
