"""Which lateral offset the reference route shall have (Snow Lion, behavioral planning, Fig. 6).

d_t = argmin over the candidates of J_s + J_d + J_o + J_dyn. The paper uses d_t and d_0 for two things each;
here `chosen` is the choice, `now` the vehicle's offset.
"""

import math

import msgspec
import numpy as np
from numba import njit

from contract.geometry import Array
from vehicle_agent.planning.motion.clearance import box_distance

# columns of a disc, of a moving thing, and of the rating of one candidate
DISC_X, DISC_Y, DISC_R = range(3)
M_X, M_Y, M_YAW, M_VX, M_VY, M_LENGTH, M_WIDTH, M_WIDER = range(8)
COST, FREE_M, CLEARANCE_MIN, CLEARANCE_MEAN, RISK = range(5)
RATINGS = 5
# Who stands at the flank may come so much nearer: the tail swings a little, and tracks wander.
_NEARER_M = 0.05


class OffsetRules(msgspec.Struct, frozen=True):
    """The weights of the paper's cost, and what keeps the vehicle from weaving.

    free_weight w_s; from_now_weight w_d1, from_centre_weight w_d2; mean_clearance_weight w_o1,
    least_clearance_weight w_o2; dynamic_weight of J_dyn
    clearance_floor_m  clearances below this count as this, so that a touch does not cost infinitely much
    touch_m            a clearance below this ends the free way; who is nearer already must not come nearer
    threshold_m        a step larger than this is a change of lane: it waits for `patience` plans in a row
    better_by          and it must lower the cost by this much
    """

    free_weight: float = 10.0
    from_now_weight: float = 0.8
    from_centre_weight: float = 0.5
    mean_clearance_weight: float = 0.3
    least_clearance_weight: float = 0.25
    dynamic_weight: float = 4.0
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

    def weights(self) -> Array:
        """(6,) as the kernel takes them."""
        return np.array(
            (
                self.free_weight,
                self.from_now_weight,
                self.from_centre_weight,
                self.mean_clearance_weight,
                self.least_clearance_weight,
                self.dynamic_weight,
            )
        )


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

    before_m: what was chosen last; better_m, count: what has been better for how many plans in a row.
    When no candidate has room the vehicle keeps to what it had, with no free way.
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
    points: Array,
    yaws: Array,
    curvatures: Array,
    lower: Array,
    upper: Array,
    first: int,
    step_m: float,
    candidates: Array,
    now_m: float,
    slope: float,
    blend_m: float,
    speed_mps: float,
    discs: Array,
    moving: Array,
    body: Array,
    weights: Array,
    floor_m: float,
    touch_m: float,
    look_m: float,
    stride: int,
    moving_s: float,
    moving_step_s: float,
) -> Array:
    """(c, 5) cost, free way, least and mean clearance, and risk of each candidate offset (c,).

    points (n, 2), yaws, curvatures, lower, upper (n,) of the corridor's stations, step_m apart; first: the
    station of the vehicle. discs (m, 3), moving (a, 8), body (3,) front, back, half width.
    """
    front, back, half = body[0], body[1], body[2]
    n = points.shape[0]
    last = min(n - 1, first + math.floor(look_m / step_m))
    out = np.zeros((candidates.shape[0], RATINGS))
    touch = _touches_from(points, yaws, curvatures, first, now_m, slope, front, back, half, discs, touch_m)
    for c in range(candidates.shape[0]):
        goal = candidates[c]
        free, least, total, count = np.inf, np.inf, 0.0, 0
        has_room = True
        for i in range(first, last + 1, stride):
            along = (i - first) * step_m
            offset, turn = blended(now_m, slope, goal, along, blend_m)
            if along >= blend_m and (offset < lower[i] or offset > upper[i]):
                has_room = False
                break
            yaw = yaws[i] + math.atan2(turn, max(0.2, 1.0 - curvatures[i] * offset))
            x = points[i, 0] - offset * math.sin(yaws[i])
            y = points[i, 1] + offset * math.cos(yaws[i])
            clearance, touches = _clearance(x, y, yaw, front, back, half, discs, touch)
            if touches:
                free = along
                break
            least = min(least, clearance)
            total += clearance
            count += 1
        if not has_room:
            out[c, COST] = np.inf
            continue
        mean = total / count if count else 0.0
        least = least if count else 0.0
        risk = _risk(
            points, yaws, curvatures, first, last, step_m, goal, now_m, slope, blend_m, speed_mps, free,
            moving, front, back, half, moving_s, moving_step_s,
        )  # fmt: skip
        shown = min(free, look_m)
        out[c, COST] = (
            weights[0] * (1.0 - shown / look_m)
            + weights[1] * abs(goal - now_m)
            + weights[2] * abs(goal)
            + weights[3] / max(mean, floor_m)
            + weights[4] / max(least, floor_m)
            + weights[5] * risk
        )
        out[c, FREE_M] = free
        out[c, CLEARANCE_MIN], out[c, CLEARANCE_MEAN], out[c, RISK] = least, mean, risk
    return out


@njit(cache=True)
def _touches_from(
    points: Array,
    yaws: Array,
    curvatures: Array,
    first: int,
    now_m: float,
    slope: float,
    front: float,
    back: float,
    half: float,
    discs: Array,
    touch_m: float,
) -> Array:
    """(m,) the clearance below which each disc is touched: of one beside the vehicle, what there is now."""
    yaw = yaws[first] + math.atan2(slope, max(0.2, 1.0 - curvatures[first] * now_m))
    x = points[first, 0] - now_m * math.sin(yaws[first])
    y = points[first, 1] + now_m * math.cos(yaws[first])
    cos, sin = math.cos(yaw), math.sin(yaw)
    out = np.full(discs.shape[0], touch_m)
    for k in range(discs.shape[0]):
        px, py = discs[k, DISC_X], discs[k, DISC_Y]
        if abs(px - x) < 10.0 and abs(py - y) < 10.0:
            now = box_distance(x, y, cos, sin, front, back, half, px, py) - discs[k, DISC_R]
            out[k] = min(touch_m, now - _NEARER_M)
    return out


@njit(cache=True)
def _clearance(
    x: float, y: float, yaw: float, front: float, back: float, half: float, discs: Array, touch: Array
) -> tuple[float, bool]:
    """(to the nearest disc, at most 5 m; whether one is nearer than its `touch`)."""
    cos, sin = math.cos(yaw), math.sin(yaw)
    nearest, touches = 5.0, False
    for k in range(discs.shape[0]):
        px, py = discs[k, DISC_X], discs[k, DISC_Y]
        if abs(px - x) > 10.0 or abs(py - y) > 10.0:
            continue
        distance = box_distance(x, y, cos, sin, front, back, half, px, py) - discs[k, DISC_R]
        nearest = min(nearest, distance)
        touches |= distance < touch[k]
    return nearest, touches


@njit(cache=True)
def _risk(
    points: Array,
    yaws: Array,
    curvatures: Array,
    first: int,
    last: int,
    step_m: float,
    goal: float,
    now_m: float,
    slope: float,
    blend_m: float,
    speed: float,
    free: float,
    moving: Array,
    front: float,
    back: float,
    half: float,
    moving_s: float,
    moving_step_s: float,
) -> float:
    """How much moving things would be met at an even speed: the nearer and the sooner, the more."""
    if moving.shape[0] == 0:
        return 0.0
    risk = 0.0
    steps = math.floor(moving_s / moving_step_s)
    for j in range(1, steps + 1):
        t = j * moving_step_s
        along = speed * t
        i = first + math.floor(along / step_m)
        if i > last or along > free:
            break
        offset, turn = blended(now_m, slope, goal, along, blend_m)
        yaw = yaws[i] + math.atan2(turn, max(0.2, 1.0 - curvatures[i] * offset))
        x = points[i, 0] - offset * math.sin(yaws[i])
        y = points[i, 1] + offset * math.cos(yaws[i])
        cos, sin = math.cos(yaw), math.sin(yaw)
        for k in range(moving.shape[0]):
            px, py = moving[k, M_X] + t * moving[k, M_VX], moving[k, M_Y] + t * moving[k, M_VY]
            if abs(px - x) > 8.0 or abs(py - y) > 8.0:
                continue
            reach = 0.5 * moving[k, M_WIDTH] + moving[k, M_WIDER]
            distance = box_distance(x, y, cos, sin, front, back, half, px, py) - reach
            if moving[k, M_LENGTH] > 1.5 * moving[k, M_WIDTH]:
                along_x = math.cos(moving[k, M_YAW]) * 0.5 * (moving[k, M_LENGTH] - moving[k, M_WIDTH])
                along_y = math.sin(moving[k, M_YAW]) * 0.5 * (moving[k, M_LENGTH] - moving[k, M_WIDTH])
                for side in (-1.0, 1.0):
                    end = box_distance(
                        x, y, cos, sin, front, back, half, px + side * along_x, py + side * along_y
                    )
                    distance = min(distance, end - reach)
            if distance < 0.4:
                risk += (0.4 - max(distance, -0.4)) / 0.8 * math.exp(-t / 3.0) * moving_step_s
    return risk
