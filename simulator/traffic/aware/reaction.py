"""How each person goes on: on the own way, more slowly, waiting, or beside it."""

import math

import numpy as np
from numba import njit

from contract.geometry import Array, BoolArray
from simulator.traffic.actors import Ints
from simulator.traffic.aware.conflict import (
    PREDICTION_STEP_S,
    PREDICTIONS,
    clearance_m,
    first_conflict,
    in_frame,
    predicted_poses,
)
from simulator.traffic.aware.ways import place_at
from simulator.traffic.crowd import RADIUS_M, V_FRONT, V_HALF, V_REAR, V_SPEED, V_X

# columns of a person
OWN_S, PACE, OFFSET_X, OFFSET_Y, SIDE_MPS, TARGET_PACE, TARGET_X, TARGET_Y = range(8)
STATE_COLUMNS = 8
# columns of the parameters
P_DECEL, P_SIDESTEP, P_COST = range(3)
# columns of a person's own limits
L_MARGIN, L_NOTICE = range(2)
LIMIT_COLUMNS = 2

STANDING_MPS = 0.3
# People heed a standing vehicle this long before they would walk into it, even if they heed no moving one.
_STANDING_NOTICE_S = 0.6
# A reaction ends when nothing would happen for this much longer.
_RELEASE_S = 0.4
_OWN_SPEED_S = 0.5
# However much the own way slows down, people may slow down by this share of their deceleration more.
_DECEL_RATIO_MIN = 0.2
_OWN_MPS_MIN = 0.5
_MOVING_OFFSET_M_MAX = 2.0
_STANDING_OFFSET_M_MAX = 5.0
_CLEAR_M = 0.03
_ARRIVED_M = 1e-4
_DIRECTION_STEPS = 6
# A sidestep that leads more than this share along the own way is none.
_ALONG = 0.8
_NOWHERE = 1e9


@njit(cache=True)
def step_people(
    state: Array,
    present: BoolArray,
    places: Array,
    first: Ints,
    count: Ints,
    begins_s: Array,
    ends_mps: Array,
    limits: Array,
    params: Array,
    vehicles: Array,
    motions: Array,
    decide: bool,
    dt: float,
) -> None:
    """Move everyone who is present by dt, in place.

    state (n, STATE_COLUMNS), present (n,); places, first, count, begins_s, ends_mps: `OwnWays`
    limits (n, LIMIT_COLUMNS): each person's own; params: `ReactionParams.row`
    vehicles (m, 7) as in `traffic.crowd`, motions (m, 2) as in `conflict`
    decide: whether people look again; between that they go on as decided
    """
    poses = predicted_poses(vehicles, motions)
    for i in range(state.shape[0]):
        if not present[i]:
            continue
        way = (first[i], count[i], begins_s[i])
        if decide:
            _decide(state[i], places, way, ends_mps[i], limits[i], params, vehicles, poses)
        _move(state[i], places, way, ends_mps[i], params, vehicles, poses, dt)


@njit(cache=True)
def _ramp_ps(
    state: Array, places: Array, way: tuple[int, int, float], ends_mps: Array, params: Array
) -> float:
    """How fast the pace may change: what the own way slows down by itself counts against it."""
    own_s = state[OWN_S]
    x0, y0 = place_at(places, way[0], way[1], way[2], ends_mps, own_s)
    x1, y1 = place_at(places, way[0], way[1], way[2], ends_mps, own_s + _OWN_SPEED_S)
    x2, y2 = place_at(places, way[0], way[1], way[2], ends_mps, own_s + 2.0 * _OWN_SPEED_S)
    speed = math.hypot(x1 - x0, y1 - y0) / _OWN_SPEED_S
    slowing = (speed - math.hypot(x2 - x1, y2 - y1) / _OWN_SPEED_S) / _OWN_SPEED_S
    decel: float = max(_DECEL_RATIO_MIN * params[P_DECEL], params[P_DECEL] - max(0.0, slowing))
    return decel / max(_OWN_MPS_MIN, speed)


@njit(cache=True)
def predict(
    out: Array,
    state: Array,
    places: Array,
    way: tuple[int, int, float],
    ends_mps: Array,
    pace: float,
    offset: tuple[float, float],
    ramp_ps: float,
    params: Array,
) -> None:
    """Fill out (PREDICTIONS, 2): the way with a pace and an offset that are approached at their rates."""
    own_s, p, side = state[OWN_S], state[PACE], (state[OFFSET_X], state[OFFSET_Y], state[SIDE_MPS])
    for k in range(PREDICTIONS):
        x, y = place_at(places, way[0], way[1], way[2], ends_mps, own_s)
        out[k, 0], out[k, 1] = x + side[0], y + side[1]
        p = _approach(p, pace, ramp_ps * PREDICTION_STEP_S)
        own_s += p * PREDICTION_STEP_S
        side = _sidestep(side, offset, params, PREDICTION_STEP_S)


@njit(cache=True)
def _approach(value: float, target: float, step: float) -> float:
    return min(target, value + step) if value < target else max(target, value - step)


@njit(cache=True)
def _sidestep(
    side: tuple[float, float, float], target: tuple[float, float], params: Array, dt: float
) -> tuple[float, float, float]:
    """Offset and speed of a sidestep after dt: it speeds up and slows down as people do on their way."""
    gap = math.hypot(target[0] - side[0], target[1] - side[1])
    speed = min(side[2] + params[P_DECEL] * dt, params[P_SIDESTEP], math.sqrt(2.0 * params[P_DECEL] * gap))
    if gap <= max(speed * dt, _ARRIVED_M):
        return target[0], target[1], 0.0
    share = speed * dt / gap
    return side[0] + (target[0] - side[0]) * share, side[1] + (target[1] - side[1]) * share, speed


@njit(cache=True)
def _decide(
    state: Array,
    places: Array,
    way: tuple[int, int, float],
    ends_mps: Array,
    limits: Array,
    params: Array,
    vehicles: Array,
    poses: Array,
) -> None:
    """Set the targets: the cheapest option without any conflict, else the one that comes least near."""
    ramp_ps = _ramp_ps(state, places, way, ends_mps, params)
    here = (state[OFFSET_X], state[OFFSET_Y])
    reacting = state[TARGET_PACE] < 1.0 or math.hypot(state[TARGET_X], state[TARGET_Y]) > 0.0
    track = np.empty((PREDICTIONS, 2))
    predict(track, state, places, way, ends_mps, 1.0, (0.0, 0.0), ramp_ps, params)
    spare_s, j, k = _spare_s(track, limits, vehicles, poses)
    if spare_s >= (_RELEASE_S if reacting else 0.0):
        state[TARGET_PACE], state[TARGET_X], state[TARGET_Y] = 1.0, 0.0, 0.0
        return
    if here[0] != 0.0 or here[1] != 0.0:
        predict(track, state, places, way, ends_mps, 1.0, here, ramp_ps, params)
        spare_s, j, k = _spare_s(track, limits, vehicles, poses)
        if spare_s >= 0.0:
            state[TARGET_PACE], state[TARGET_X], state[TARGET_Y] = 1.0, here[0], here[1]
            return
    options = _options(here, track, j, k, limits[L_MARGIN], vehicles, poses)
    best, best_cost, best_least_m = 0, math.inf, -math.inf
    for o in range(options.shape[0]):
        pace, offset = options[o, 0], (options[o, 1], options[o, 2])
        if offset[0] > 0.5 * _NOWHERE:
            continue
        predict(track, state, places, way, ends_mps, pace, offset, ramp_ps, params)
        spare_s, _, _ = _spare_s(track, limits, vehicles, poses)
        least_m = math.inf if spare_s == math.inf else _least_clearance_m(track, vehicles, poses)
        cost = 1.0 - pace + params[P_COST] * math.hypot(offset[0] - here[0], offset[1] - here[1])
        if least_m > best_least_m or (least_m == best_least_m and cost < best_cost):
            best, best_cost, best_least_m = o, cost, least_m
    state[TARGET_PACE] = options[best, 0]
    state[TARGET_X], state[TARGET_Y] = options[best, 1], options[best, 2]


@njit(cache=True)
def _least_clearance_m(track: Array, vehicles: Array, poses: Array) -> float:
    """The least predicted clearance to any vehicle."""
    least_m = math.inf
    for j in range(vehicles.shape[0]):
        for k in range(PREDICTIONS):
            least_m = min(least_m, clearance_m(track[k, 0], track[k, 1], poses[j, k], vehicles[j]))
    return least_m


@njit(cache=True)
def _spare_s(track: Array, limits: Array, vehicles: Array, poses: Array) -> tuple[float, int, int]:
    """(time from when the person would react until the first conflict, its vehicle, its step).

    Negative: the conflict is within notice. Without a conflict the whole prediction is spare.
    """
    spare_s, vehicle, step = math.inf, -1, PREDICTIONS
    for j in range(vehicles.shape[0]):
        k, _ = first_conflict(track, vehicles[j], poses[j], limits[L_MARGIN])
        notice_s = limits[L_NOTICE]
        if abs(vehicles[j, V_SPEED]) < STANDING_MPS:
            notice_s = max(notice_s, _STANDING_NOTICE_S)
        left_s = k * PREDICTION_STEP_S - notice_s if k < PREDICTIONS else math.inf
        if left_s < spare_s:
            spare_s, vehicle, step = left_s, j, k
    return spare_s, vehicle, step


@njit(cache=True)
def _options(
    here: tuple[float, float],
    track: Array,
    j: int,
    k: int,
    margin_m: float,
    vehicles: Array,
    poses: Array,
) -> Array:
    """(8, 3) pace and offset of each option; an offset of _NOWHERE where an option is no option.

    Going on as now, more slowly, or not at all; and sidesteps to both sides, walking on or waiting meanwhile.
    People do not wait for a vehicle that stands. track: with pace 1 and the offset of now, in conflict at k.
    """
    out = np.full((8, 3), _NOWHERE)
    vehicle = vehicles[j]
    standing = abs(vehicle[V_SPEED]) < STANDING_MPS
    for o in range(1 if standing else 4):
        out[o, 0], out[o, 1], out[o, 2] = 1.0 - o / 3.0, here[0], here[1]
    longest_m = _STANDING_OFFSET_M_MAX if standing else _MOVING_OFFSET_M_MAX
    for side in range(2):
        sign = 1.0 if side == 0 else -1.0
        if standing:
            dx, dy, way_m = _around(track, sign, poses[j, 0], vehicle)
        else:
            dx, dy, way_m = _aside(track, k, sign, poses[j, k], vehicle)
        way_m += RADIUS_M + margin_m + _CLEAR_M
        ex, ey = here[0] + way_m * dx, here[1] + way_m * dy
        if way_m <= 0.0 or math.hypot(ex, ey) > longest_m:
            continue
        for waiting in range(2):
            o = 4 + 2 * side + waiting
            out[o, 0], out[o, 1], out[o, 2] = 1.0 - waiting, ex, ey
    return out


@njit(cache=True)
def _aside(track: Array, k: int, sign: float, pose: Array, vehicle: Array) -> tuple[float, float, float]:
    """(dx, dy, way_m) out of a moving vehicle's course to its left or right; none along the own way."""
    _, v = in_frame(track[k, 0], track[k, 1], pose)
    dx, dy = -sign * math.sin(pose[2]), sign * math.cos(pose[2])
    walking = _direction(track)
    if abs(dx * walking[0] + dy * walking[1]) > _ALONG:
        return dx, dy, -_NOWHERE
    return dx, dy, vehicle[V_HALF] - sign * v


@njit(cache=True)
def _around(track: Array, sign: float, pose: Array, vehicle: Array) -> tuple[float, float, float]:
    """(dx, dy, way_m) to the left or right of the own way, until it passes a standing vehicle's corners."""
    walking = _direction(track)
    dx, dy = -sign * walking[1], sign * walking[0]
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    way_m = -_NOWHERE
    for u in (vehicle[V_FRONT], -vehicle[V_REAR]):
        for v in (vehicle[V_HALF], -vehicle[V_HALF]):
            x, y = pose[0] + cos * u - sin * v, pose[1] + sin * u + cos * v
            way_m = max(way_m, dx * (x - track[0, 0]) + dy * (y - track[0, 1]))
    return dx, dy, way_m


@njit(cache=True)
def _direction(track: Array) -> tuple[float, float]:
    """The direction in which a person walks, 0 for one who stands."""
    dx, dy = track[_DIRECTION_STEPS, 0] - track[0, 0], track[_DIRECTION_STEPS, 1] - track[0, 1]
    length = math.hypot(dx, dy)
    if length < _OWN_MPS_MIN * _DIRECTION_STEPS * PREDICTION_STEP_S * 0.5:
        return 0.0, 0.0
    return dx / length, dy / length


@njit(cache=True)
def _move(
    state: Array,
    places: Array,
    way: tuple[int, int, float],
    ends_mps: Array,
    params: Array,
    vehicles: Array,
    poses: Array,
    dt: float,
) -> None:
    """One step towards the targets. No one walks into a body, but a body may come to a person."""
    ramp_ps = _ramp_ps(state, places, way, ends_mps, params)
    own_s, ex, ey = state[OWN_S], state[OFFSET_X], state[OFFSET_Y]
    side = (ex, ey, state[SIDE_MPS])
    x0, y0 = place_at(places, way[0], way[1], way[2], ends_mps, own_s)
    state[PACE] = _approach(state[PACE], state[TARGET_PACE], ramp_ps * dt)
    fx, fy, side_mps = _sidestep(side, (state[TARGET_X], state[TARGET_Y]), params, dt)
    for attempt in range(3):
        pace = 0.0 if attempt > 0 else state[PACE]
        gx, gy = (ex, ey) if attempt == 2 else (fx, fy)
        x1, y1 = place_at(places, way[0], way[1], way[2], ends_mps, own_s + pace * dt)
        if attempt == 2 or not _walks_into(x0 + ex, y0 + ey, x1 + gx, y1 + gy, vehicles, poses):
            state[OWN_S] = own_s + pace * dt
            state[OFFSET_X], state[OFFSET_Y] = gx, gy
            state[SIDE_MPS] = side_mps if attempt < 2 else 0.0
            if attempt > 0:
                state[PACE] = 0.0
            return


@njit(cache=True)
def _walks_into(x0: float, y0: float, x1: float, y1: float, vehicles: Array, poses: Array) -> bool:
    """The step ends in a body and leads deeper into it."""
    for j in range(vehicles.shape[0]):
        if math.hypot(x1 - vehicles[j, V_X], y1 - vehicles[j, V_X + 1]) > 10.0:
            continue
        after_m = clearance_m(x1, y1, poses[j, 0], vehicles[j])
        if after_m < 0.0 and after_m < clearance_m(x0, y0, poses[j, 0], vehicles[j]) - 1e-9:
            return True
    return False
