"""A dense crowd, one 20 ms step for all: social forces, and people's reaction to shuttles.

Social force (Helbing, Molnar 1995): each person relaxes to the desired velocity and is repelled by
neighbours, exponentially with distance and less from behind. Attentive people accept a gap before a shuttle
or wait (time to its arrival against time to cross, plus a personal margin), and make room when it comes.
Inattentive people ignore it until they touch it.
"""

import math

import numpy as np
from numba import njit

from contract.geometry import Array
from simulator.traffic.corridor import place_in_corridor
from simulator.traffic.crowd import (
    RADIUS_M,
    V_FRONT,
    V_HALF,
    V_REAR,
    V_SPEED,
    V_X,
    V_Y,
    V_YAW,
    Ints,
    clearance_m,
    slide,
)
from simulator.traffic.detours import crosses, next_corner

# columns of a person
X, Y, VX, VY, HEADING, PACE, MARGIN, REACT, NOTICED, LEFT, GOAL_X, GOAL_Y = range(12)
PERSON_COLUMNS = 12
# a person's activity: walking to the goal, standing until LEFT runs out, or without a goal
WALK, LINGER, DONE = 0, 1, 2

_RELAX_S = 0.5
_PUSH_MPS2 = 2.1
_PUSH_RANGE_M = 0.3
_NEAR_M = 1.6
_FROM_BEHIND = 0.35
_PACE_MAX_MPS = 2.2
_REACH_M = 0.5
_SIGHT_M = 25.0
_BESIDE_M = 0.45
_STANDING_MPS = 0.3
_CROSSING_MPS = 0.45
_ROOM_S = 3.5
_ROOM_M = 6.0
_HURRY = 1.35
# People within this distance of its bumper let a waiting shuttle go first after 10 s at a margin of 1 s.
_COURTESY_M, _COURTESY_S = 10.0, 10.0
# If it does not go within this time, they cross.
_PATIENCE_S = 15.0
# People this much nearer than a step to a standing vehicle walk around it.
_DETOUR_M = 0.15
# This near they see that it stands on their goal.
_NEAR_GOAL_M = 2.5
# An attentive person passes before a standing shuttle no nearer to its bumper than this, and farther the
# larger their margin is: 1.0 to 1.6 m. Of recorded people, 7 % pass a standing car within a metre
# (`benchmarks.people`).
_BERTH_M, _BERTH_MPS = 0.8, 0.4
# The distance that attentive people keep, and the contact distance of inattentive ones.
_APART_M = RADIUS_M + 0.15
_TOUCH_M = RADIUS_M - 0.05


@njit(cache=True)
def step_social(
    people: Array, activity: Ints, attentive: Ints, vehicles: Array, ahead: Array, waited_s: Array, dt: float
) -> None:
    """Move all people by dt, in place.

    people (n, PERSON_COLUMNS), activity (n,), attentive (n,) 1 or 0; vehicles (m, 7) and ahead (m, k, 2) as
    in `traffic.crowd`; waited_s (m,) for how long each vehicle has stood.
    """
    n = people.shape[0]
    force = np.empty((n, 2))
    for i in range(n):
        wx, wy = _goal_velocity(people[i], activity, i, dt)
        if attentive[i] == 1:
            for j in range(vehicles.shape[0]):
                p = people[i]
                if math.hypot(p[X] - vehicles[j, V_X], p[Y] - vehicles[j, V_Y]) < _SIGHT_M:
                    wx, wy = _react_to_vehicle(p, wx, wy, vehicles[j], ahead[j], waited_s[j], dt)
        for j in range(vehicles.shape[0]):
            berth_m = _berth_m(people[i]) if attentive[i] == 1 else 0.0
            wx, wy = _detour(people[i], wx, wy, vehicles[j], berth_m)
            if activity[i] == WALK and _stands_on_goal(people[i], vehicles[j], berth_m):
                activity[i] = DONE
        px, py = _repulsion(people, i)
        if activity[i] == LINGER and math.hypot(wx, wy) < 1e-9:
            # A standing person gives way a little and does not drift.
            px, py = 0.3 * px, 0.3 * py
        force[i, 0] = (wx - people[i, VX]) / _RELAX_S + px
        force[i, 1] = (wy - people[i, VY]) / _RELAX_S + py
    for i in range(n):
        _move(people[i], force[i, 0], force[i, 1], attentive[i] == 1, vehicles, dt)


@njit(cache=True)
def _goal_velocity(p: Array, activity: Ints, i: int, dt: float) -> tuple[float, float]:
    if activity[i] == LINGER:
        p[LEFT] -= dt
        if p[LEFT] <= 0.0:
            activity[i] = DONE
        return 0.0, 0.0
    dx, dy = p[GOAL_X] - p[X], p[GOAL_Y] - p[Y]
    distance = math.hypot(dx, dy)
    if activity[i] == WALK and distance < _REACH_M:
        activity[i] = DONE
    if distance < 1e-6 or activity[i] == DONE:
        return 0.0, 0.0
    return p[PACE] * dx / distance, p[PACE] * dy / distance


@njit(cache=True)
def _react_to_vehicle(
    p: Array, wx: float, wy: float, vehicle: Array, ahead: Array, waited_s: float, dt: float
) -> tuple[float, float]:
    """An attentive person's desired velocity with the reaction to one shuttle."""
    s, d, tx, ty = place_in_corridor(ahead, p[X], p[Y])
    gap, length = s - vehicle[V_FRONT], vehicle[V_REAR] + vehicle[V_FRONT]
    if gap < -length - 0.5 or gap > _SIGHT_M:
        p[NOTICED] = 0.0
        return wx, wy
    side = 1.0 if d >= 0.0 else -1.0
    nx, ny = -ty * side, tx * side
    off, edge = abs(d), vehicle[V_HALF] + _BESIDE_M
    speed = abs(vehicle[V_SPEED])
    if gap <= 0.0 and speed <= _STANDING_MPS:
        return wx, wy
    outward = wx * nx + wy * ny
    arrives_s = gap / speed if speed > _STANDING_MPS else 1e3
    if off > edge:
        p[NOTICED] = 0.0
        soon = off - edge < 0.3 - outward
        if outward >= 0.0 or not soon or _accepts_gap(p, gap, off, edge, arrives_s, waited_s):
            return wx, wy
        if speed <= _STANDING_MPS and gap < _berth_m(p) and not _lets_go(p, gap, waited_s):
            # Passes before it, but not right at its bumper; or behind it, where the goal is.
            goal_x, _ = _in_base_frame(vehicle, p[GOAL_X], p[GOAL_Y])
            pace = p[PACE] if goal_x > vehicle[V_FRONT] - 0.5 * length else -p[PACE]
            return pace * tx, pace * ty
        # Waits at the edge and may walk along it.
        return wx - outward * nx, wy - outward * ny
    if gap <= 0.0:
        return wx + 1.2 * nx, wy + 1.2 * ny
    if abs(outward) > _CROSSING_MPS:
        to_go = edge - off if outward > 0.0 else edge + off
        hurry = _HURRY if arrives_s < to_go / max(p[PACE], 0.3) + 0.8 else 1.0
        return hurry * wx, hurry * wy
    if speed <= _STANDING_MPS and math.hypot(wx, wy) > 1e-9:
        # A person who walks around a standing shuttle soon leaves its path. Making room to the other side
        # would make the person turn back and forth.
        return wx, wy
    if arrives_s < _ROOM_S or gap < _ROOM_M:
        p[NOTICED] += dt
        if p[NOTICED] > p[REACT]:
            pace = max(p[PACE], 1.0)
            return pace * nx, pace * ny
    return wx, wy


@njit(cache=True)
def _accepts_gap(p: Array, gap: float, off: float, edge: float, arrives_s: float, waited_s: float) -> bool:
    """There is time to cross before the shuttle, with the personal margin, and not right at its bumper.

    A shuttle that has waited long enough is let go first for a while, sooner by people with large margins.
    """
    if _lets_go(p, gap, waited_s):
        return False
    return gap > _berth_m(p) and arrives_s > (off + edge) / max(p[PACE], 0.3) + p[MARGIN]


@njit(cache=True)
def _lets_go(p: Array, gap: float, waited_s: float) -> bool:
    """The person waits for a shuttle that has stood long enough to set off first."""
    lets_go_s = _COURTESY_S / max(p[MARGIN], 0.2)
    return gap < _COURTESY_M and lets_go_s < waited_s < lets_go_s + _PATIENCE_S


@njit(cache=True)
def _berth_m(p: Array) -> float:
    berth_m: float = _BERTH_M + _BERTH_MPS * p[MARGIN]
    return berth_m


@njit(cache=True)
def _detour(p: Array, wx: float, wy: float, vehicle: Array, berth_m: float) -> tuple[float, float]:
    """The desired velocity around a standing vehicle: towards the corner over which the way is shortest.

    People keep _APART_M from it and berth_m before its bumper; who is nearer already keeps what they have.
    """
    pace = math.hypot(wx, wy)
    if pace < 1e-9 or abs(vehicle[V_SPEED]) > _STANDING_MPS:
        return wx, wy
    if clearance_m(_with_berth(vehicle, berth_m), p[X], p[Y]) > _APART_M + _DETOUR_M:
        return wx, wy
    x, y = _in_base_frame(vehicle, p[X], p[Y])
    goal_x, goal_y = _in_base_frame(vehicle, p[GOAL_X], p[GOAL_Y])
    back, front = -vehicle[V_REAR] - _APART_M, vehicle[V_FRONT] + max(berth_m, _APART_M)
    half = vehicle[V_HALF] + _APART_M
    is_beside = -vehicle[V_REAR] <= x <= vehicle[V_FRONT]
    if is_beside or abs(y) > vehicle[V_HALF] + 0.5 * _APART_M:
        half = min(half, abs(y))
    elif x > vehicle[V_FRONT]:
        front = min(front, x)
    else:
        back = max(back, x)
    if not crosses(x, y, goal_x, goal_y, back, front, half):
        return wx, wy
    to_x, to_y = next_corner(x, y, p[HEADING] - vehicle[V_YAW], goal_x, goal_y, back, front, half)
    away = math.hypot(to_x - x, to_y - y)
    ahead, aside = pace * (to_x - x) / away, pace * (to_y - y) / away
    cos, sin = math.cos(vehicle[V_YAW]), math.sin(vehicle[V_YAW])
    return cos * ahead - sin * aside, sin * ahead + cos * aside


@njit(cache=True)
def _stands_on_goal(p: Array, vehicle: Array, berth_m: float) -> bool:
    """The vehicle stands on the person's goal; the person then gets a new one."""
    if abs(vehicle[V_SPEED]) > _STANDING_MPS:
        return False
    kept = _with_berth(vehicle, berth_m)
    return (
        clearance_m(kept, p[X], p[Y]) <= _NEAR_GOAL_M and clearance_m(kept, p[GOAL_X], p[GOAL_Y]) < _REACH_M
    )


@njit(cache=True)
def _with_berth(vehicle: Array, berth_m: float) -> Array:
    """The vehicle, longer by what a person keeps ahead of it beyond the distance kept on all sides."""
    kept = vehicle.copy()
    kept[V_FRONT] += max(berth_m - _APART_M, 0.0)
    return kept


@njit(cache=True)
def _in_base_frame(vehicle: Array, x: float, y: float) -> tuple[float, float]:
    """A position in the vehicle's base frame."""
    cos, sin = math.cos(vehicle[V_YAW]), math.sin(vehicle[V_YAW])
    dx, dy = x - vehicle[V_X], y - vehicle[V_Y]
    return cos * dx + sin * dy, cos * dy - sin * dx


@njit(cache=True)
def _repulsion(people: Array, i: int) -> tuple[float, float]:
    """Acceleration by all neighbours (m/s2); a little to the right, so that two who meet head-on pass."""
    fx, fy = 0.0, 0.0
    cos, sin = math.cos(people[i, HEADING]), math.sin(people[i, HEADING])
    for j in range(people.shape[0]):
        dx, dy = people[i, X] - people[j, X], people[i, Y] - people[j, Y]
        if j == i or abs(dx) > _NEAR_M or abs(dy) > _NEAR_M:
            continue
        distance = math.hypot(dx, dy)
        if distance > _NEAR_M or distance < 1e-6:
            continue
        push = min(_PUSH_MPS2 * math.exp((2.0 * RADIUS_M - distance) / _PUSH_RANGE_M), 6.0)
        seen = -(cos * dx + sin * dy) / distance
        push *= _FROM_BEHIND + (1.0 - _FROM_BEHIND) * 0.5 * (1.0 + seen)
        fx += push * (dx + 0.25 * dy) / distance
        fy += push * (dy - 0.25 * dx) / distance
    return fx, fy


@njit(cache=True)
def _move(p: Array, ax: float, ay: float, attentive: bool, vehicles: Array, dt: float) -> None:
    """Walk, never into a vehicle's body; the heading follows the direction of walking."""
    p[VX] += ax * dt
    p[VY] += ay * dt
    pace = math.hypot(p[VX], p[VY])
    if pace > _PACE_MAX_MPS:
        p[VX], p[VY] = p[VX] * _PACE_MAX_MPS / pace, p[VY] * _PACE_MAX_MPS / pace
    x, y = p[X] + p[VX] * dt, p[Y] + p[VY] * dt
    least = _APART_M if attentive else _TOUCH_M
    for j in range(vehicles.shape[0]):
        after = clearance_m(vehicles[j], x, y)
        if after < least and after < clearance_m(vehicles[j], p[X], p[Y]):
            x, y = slide(vehicles[j], p[X], p[Y], x, y)
    p[VX], p[VY] = (x - p[X]) / dt, (y - p[Y]) / dt
    p[X], p[Y] = x, y
    if math.hypot(p[VX], p[VY]) > 0.3:
        p[HEADING] = math.atan2(p[VY], p[VX])
