"""The motion of pedestrians around shuttles, one 20 ms step for all of them.

People walk towards waypoints by social force (Helbing, Molnar 1995, in its simplest form), with four rules.
No person steps in front of a moving shuttle closer than `look_m`. A person on its path leaves it after the
shuttle has waited for a few seconds. A person who meets it head-on walks around it. A person beside it keeps
away.
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from contract.geometry import Array
from simulator.traffic.corridor import place_in_corridor

Ints = NDArray[np.int64]

# columns of a person
X, Y, VX, VY, PACE, WAITED, PATIENCE, TRIGGER = range(8)
PERSON_COLUMNS = 8
# a person's activity
WALK, STAND, KERB, ASIDE, GONE = 0, 1, 2, 3, 4
# columns of a vehicle
V_X, V_Y, V_YAW, V_REAR, V_FRONT, V_HALF, V_SPEED = range(7)
VEHICLE_COLUMNS = 7

RADIUS_M = 0.25
WAYPOINTS = 8

_REACH_M = 0.35
_RELAX_S = 0.35
_PACE_MAX_MPS = 1.9
_BODY_M = RADIUS_M + 0.2
_SLOW_MPS = 1.2
_STANDING_MPS = 0.3
_WAITING_GAP_M = 12.0
_CROSSING_MPS = 0.4
_ASIDE_M = 2.4
_EXIT_M = 6.0
_AT_REST_MPS = 0.05
_FACED_M = 10.0
_FACED_HALF_M = 2.5
_HINT_S = 4.0


@njit(cache=True)
def step_crowd(
    people: Array,
    activity: Ints,
    ways: Array,
    way: Ints,
    vehicles: Array,
    ahead: Array,
    look_m: float,
    dt: float,
) -> None:
    """Move all people by dt, in place.

    people (n, PERSON_COLUMNS), activity (n,), ways (n, WAYPOINTS, 2) padded with NaN, way (n,) next waypoint,
    vehicles (m, VEHICLE_COLUMNS), ahead (m, k, 2) corridor samples of each vehicle.
    """
    n, m = people.shape[0], vehicles.shape[0]
    desired = np.empty((n, 2))
    for i in range(n):
        ux, uy = _towards_waypoint(people[i], activity, ways[i], way, i)
        for j in range(m):
            p = people[i]
            if math.hypot(p[X] - vehicles[j, V_X], p[Y] - vehicles[j, V_Y]) < 35.0:
                ux, uy = _react_to_vehicle(
                    p, activity, ways[i], way, i, ux, uy, vehicles[j], ahead[j], look_m, dt
                )
        desired[i, 0], desired[i, 1] = ux, uy
    for i in range(n):
        fx, fy = _repulsion(people, activity, i)
        _move(people[i], desired[i, 0] + fx, desired[i, 1] + fy, vehicles, dt)


@njit(cache=True)
def _towards_waypoint(p: Array, activity: Ints, route: Array, way: Ints, i: int) -> tuple[float, float]:
    """The velocity towards the next waypoint; the walk ends at the last one."""
    if activity[i] != WALK and activity[i] != ASIDE:
        return 0.0, 0.0
    while True:
        k = way[i]
        if k >= WAYPOINTS or math.isnan(route[k, 0]):
            activity[i] = GONE
            return 0.0, 0.0
        dx, dy = route[k, 0] - p[X], route[k, 1] - p[Y]
        distance = math.hypot(dx, dy)
        if distance > _REACH_M:
            return p[PACE] * dx / distance, p[PACE] * dy / distance
        way[i] = k + 1


@njit(cache=True)
def _react_to_vehicle(
    p: Array,
    activity: Ints,
    route: Array,
    way: Ints,
    i: int,
    ux: float,
    uy: float,
    vehicle: Array,
    ahead: Array,
    look_m: float,
    dt: float,
) -> tuple[float, float]:
    """The desired velocity with the reaction to one shuttle."""
    half, length = vehicle[V_HALF], vehicle[V_REAR] + vehicle[V_FRONT]
    speed = abs(vehicle[V_SPEED])
    if speed < _AT_REST_MPS and activity[i] != ASIDE and _stands_ahead(p, vehicle):
        # The person does not know the shuttle's path, but sees that it waits for them.
        p[WAITED] += dt
        if p[WAITED] > p[PATIENCE] + _HINT_S:
            nx, ny, off = _sideways_from_heading(p, vehicle)
            _step_aside(p, activity, route, way, i, nx, ny, max(half + _ASIDE_M - off, _ASIDE_M), 0.0, off)
            return 0.0, 0.0
    s, d, tx, ty = place_in_corridor(ahead, p[X], p[Y])
    gap = s - vehicle[V_FRONT]
    side = 1.0 if d >= 0.0 else -1.0
    nx, ny = -ty * side, tx * side
    outward = ux * nx + uy * ny
    off = abs(d)
    if activity[i] == KERB:
        if look_m < gap < p[TRIGGER]:
            activity[i] = WALK
        elif gap < -length - 1.0:
            activity[i] = GONE
        return 0.0, 0.0
    if activity[i] == GONE and off > half + 1.3:
        return ux, uy
    if off < half + 1.3 and 0.0 < gap < _WAITING_GAP_M and activity[i] != ASIDE:
        along = abs(outward) < _CROSSING_MPS and ux * tx + uy * ty < -0.3
        meets = along and off < half + _BODY_M and gap < 6.0
        if speed < _SLOW_MPS and abs(p[VX] * nx + p[VY] * ny) < _CROSSING_MPS:
            p[WAITED] += dt
        if meets or p[WAITED] > p[PATIENCE]:
            _step_aside(p, activity, route, way, i, nx, ny, half + _ASIDE_M - off, outward, d)
            return 0.0, 0.0
    if (
        activity[i] == WALK
        and off > half + _BODY_M
        and outward < 0.0
        and off + outward < half + _BODY_M + 0.3
    ):
        return _at_path_edge(ux, uy, tx, ty, -nx, -ny, gap, length, speed, look_m, p[PACE])
    if activity[i] == WALK and off < half + _BODY_M and abs(outward) > _CROSSING_MPS and 0.0 < gap < 4.0:
        # across first, so that the way around a standing shuttle does not lead along its bumper
        return math.copysign(p[PACE], outward) * nx, math.copysign(p[PACE], outward) * ny
    if speed > _STANDING_MPS and half < off < half + 0.9 and 0.0 < gap < 8.0 and abs(outward) < 0.5:
        ux, uy = ux + 0.8 * nx, uy + 0.8 * ny
    if speed > 0.05 and -length - 0.5 < gap <= 0.3 and off < half + 0.9:
        ux, uy = ux + 1.2 * nx, uy + 1.2 * ny
    return ux, uy


@njit(cache=True)
def _stands_ahead(p: Array, vehicle: Array) -> bool:
    """The person stands ahead of the shuttle, near enough to be the reason why it waits."""
    if math.hypot(p[VX], p[VY]) > _STANDING_MPS:
        return False
    cos, sin = math.cos(vehicle[V_YAW]), math.sin(vehicle[V_YAW])
    dx, dy = p[X] - vehicle[V_X], p[Y] - vehicle[V_Y]
    before = cos * dx + sin * dy - vehicle[V_FRONT]
    lateral = abs(-sin * dx + cos * dy)
    return bool(-0.5 < before < _FACED_M and lateral < max(_FACED_HALF_M, before))


@njit(cache=True)
def _sideways_from_heading(p: Array, vehicle: Array) -> tuple[float, float, float]:
    """(nx, ny, distance): sideways from the line of the shuttle's heading, on the person's side."""
    cos, sin = math.cos(vehicle[V_YAW]), math.sin(vehicle[V_YAW])
    lateral = -sin * (p[X] - vehicle[V_X]) + cos * (p[Y] - vehicle[V_Y])
    side = 1.0 if lateral >= 0.0 else -1.0
    return -sin * side, cos * side, abs(lateral)


@njit(cache=True)
def _at_path_edge(
    ux: float,
    uy: float,
    tx: float,
    ty: float,
    inward_x: float,
    inward_y: float,
    gap: float,
    length: float,
    speed: float,
    look_m: float,
    pace: float,
) -> tuple[float, float]:
    """About to step onto the shuttle's path: cross, wait, or walk around a standing shuttle."""
    if speed > _STANDING_MPS:
        return (0.0, 0.0) if -length - 1.0 < gap < look_m else (ux, uy)
    if -length - 0.8 < gap < 2.5:
        way = 1.0 if gap > -0.5 * length else -1.0
        return way * pace * tx, way * pace * ty
    if 2.5 <= gap < 4.0:
        return pace * inward_x, pace * inward_y
    return ux, uy


@njit(cache=True)
def _step_aside(
    p: Array,
    activity: Ints,
    route: Array,
    way: Ints,
    i: int,
    nx: float,
    ny: float,
    distance: float,
    outward: float,
    d: float,
) -> None:
    """Leave the path on the nearer side, or on the side that the person walks to, and walk away."""
    if outward < -0.4 and abs(d) < 1.0:
        nx, ny, distance = -nx, -ny, distance + 2.0 * abs(d)
    route[0, 0], route[0, 1] = p[X] + nx * distance, p[Y] + ny * distance
    route[1, 0], route[1, 1] = p[X] + nx * (distance + _EXIT_M), p[Y] + ny * (distance + _EXIT_M)
    route[2, 0] = np.nan
    way[i] = 0
    p[WAITED] = 0.0
    activity[i] = ASIDE


@njit(cache=True)
def _repulsion(people: Array, activity: Ints, i: int) -> tuple[float, float]:
    """Social force: neighbours closer than 1.2 m push, exponentially."""
    if activity[i] == STAND or activity[i] == KERB or activity[i] == GONE:
        return 0.0, 0.0
    fx, fy = 0.0, 0.0
    for j in range(people.shape[0]):
        dx, dy = people[i, X] - people[j, X], people[i, Y] - people[j, Y]
        distance = math.hypot(dx, dy)
        if j == i or distance > 1.2 or distance < 1e-6:
            continue
        push = 1.0 * math.exp((2.0 * RADIUS_M - distance) / 0.25)
        push = min(push, 1.2)
        # a little to the left, so that two who meet head-on pass
        fx += push * (dx - 0.3 * dy) / distance
        fy += push * (dy + 0.3 * dx) / distance
    return fx, fy


@njit(cache=True)
def _move(p: Array, ux: float, uy: float, vehicles: Array, dt: float) -> None:
    """Relax towards the desired velocity and walk, never into a vehicle."""
    blend = dt / _RELAX_S
    p[VX] += (ux - p[VX]) * blend
    p[VY] += (uy - p[VY]) * blend
    pace = math.hypot(p[VX], p[VY])
    if pace > _PACE_MAX_MPS:
        p[VX], p[VY] = p[VX] * _PACE_MAX_MPS / pace, p[VY] * _PACE_MAX_MPS / pace
    x, y = p[X] + p[VX] * dt, p[Y] + p[VY] * dt
    for j in range(vehicles.shape[0]):
        before = clearance_m(vehicles[j], p[X], p[Y])
        after = clearance_m(vehicles[j], x, y)
        if after < _BODY_M and after < before:
            x, y = slide(vehicles[j], p[X], p[Y], x, y)
    p[X], p[Y] = x, y


@njit(cache=True)
def slide(vehicle: Array, x0: float, y0: float, x: float, y: float) -> tuple[float, float]:
    """The step without the part that leads into the vehicle's outline."""
    ax, ay = _outline_point(vehicle, x0, y0)
    nx, ny = x0 - ax, y0 - ay
    length = math.hypot(nx, ny)
    if length < 1e-9:
        return x0, y0
    nx, ny = nx / length, ny / length
    inward = min(0.0, (x - x0) * nx + (y - y0) * ny)
    return x - inward * nx, y - inward * ny


@njit(cache=True)
def _outline_point(vehicle: Array, x: float, y: float) -> tuple[float, float]:
    """The point of the vehicle's rectangle nearest to (x, y)."""
    cos, sin = math.cos(vehicle[V_YAW]), math.sin(vehicle[V_YAW])
    dx, dy = x - vehicle[V_X], y - vehicle[V_Y]
    bx = min(max(cos * dx + sin * dy, -vehicle[V_REAR]), vehicle[V_FRONT])
    by = min(max(-sin * dx + cos * dy, -vehicle[V_HALF]), vehicle[V_HALF])
    return vehicle[V_X] + cos * bx - sin * by, vehicle[V_Y] + sin * bx + cos * by


@njit(cache=True)
def clearance_m(vehicle: Array, x: float, y: float) -> float:
    """Distance from a point to the vehicle's outline, 0 inside it."""
    ax, ay = _outline_point(vehicle, x, y)
    return math.hypot(x - ax, y - ay)
