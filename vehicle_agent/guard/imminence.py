"""Imminent contact: does the vehicle touch a road user if it drives on for its response time, then brakes?

After RSS (Shalev-Shwartz, Shammah, Shashua 2017, definitions 1-6 and the response to them): the vehicle's own
response time and braking against the worst reasonable behaviour of the other road users. RSS has closed
formulas for straight lanes. Here both motions are simulated along the steered arc in small steps, with the
whole swept body, so that one rule covers every curve and direction.
"""

import math

from numba import njit

from contract.geometry import Array

STEP_S = 0.05
# A road user who approaches by their own motion counts only up to this far behind the front bumper. Braking
# does not help a person who walks into the flank, and stops the vehicle among those who follow them.
FRONT_ZONE_M = 1.5
# Road users who may leave their way by this much or more are people on foot or on cycles.
PERSON_SWERVE_MPS2 = 0.4
# A person who nears the vehicle's path faster than this, and mostly across it, has set off: their velocity
# goes over into WALK_MPS with the time constant RISE_S, as it does in the planner's room to stop.
SETS_OFF_MPS, ACROSS_SHARE = 0.5, 0.5
WALK_MPS, RISE_S = 1.4, 0.5
_STRAIGHT_1PM = 1e-5


@njit(cache=True)
def clearance_m(x_m: float, y_m: float, back_m: float, front_m: float, half_m: float) -> float:
    """Distance of a point (base frame) from the body's rectangle; negative inside."""
    beyond = max(-back_m - x_m, x_m - front_m)
    aside = abs(y_m) - half_m
    if beyond > 0.0 and aside > 0.0:
        return math.hypot(beyond, aside)
    return max(beyond, aside)


@njit(cache=True)
def travel_m(t_s: float, speed_mps: float, accel_mps2: float, response_s: float, decel_mps2: float) -> float:
    """Distance driven after t_s: response_s at accel_mps2, then braking to rest."""
    early = min(t_s, response_s)
    way = early * (speed_mps + 0.5 * accel_mps2 * early)
    peak = speed_mps + accel_mps2 * response_s
    late = min(t_s - early, peak / decel_mps2)
    way += late * (peak - 0.5 * decel_mps2 * late)
    return way


@njit(cache=True)
def will_touch(
    rows: Array,
    curvature_1pm: float,
    speed_mps: float,
    accel_mps2: float,
    response_s: float,
    decel_mps2: float,
    body: tuple[float, float, float],
    front_margin_m: float,
    margin_m: float,
) -> bool:
    """True if a road user comes too close before the vehicle is at rest.

    rows            (n, 7) as in `road_users`
    curvature_1pm   of the arc that the rear axle drives; body: back, front, half width from the rear axle
    front_margin_m  extra room ahead of the bumper; margin_m: room on every side
    Each road user is simulated twice: braking as hard as they can, and keeping their velocity. Ahead of the
    bumper both may deviate to any side by half their lateral acceleration times the time squared. A road user
    who is already within the margin may come half as near, and no nearer: walking alongside is no danger. For
    one before the bumper, within the extra room, this holds for the distance from the body itself; one who
    touches the bumper is touched.
    A person who has just set off across walks faster soon: keeping their velocity is no worst case.
    Alongside the body, behind its first 1.5 m, a person counts only where the vehicle turns towards them: as
    in RSS, the response to a lateral approach is not to move to that side.
    """
    back, front, half = body[0], body[1] + front_margin_m, body[2]
    end_s = response_s + (speed_mps + accel_mps2 * response_s) / decel_mps2
    reach = travel_m(end_s, speed_mps, accel_mps2, response_s, decel_mps2)
    steps = math.ceil(end_s / STEP_S)
    for i in range(rows.shape[0]):
        x, y, vx, vy, radius, brake, swerve = rows[i]
        v = math.hypot(vx, vy)
        now_m = clearance_m(x, y, back, front, half) - radius
        bare_m = clearance_m(x, y, back, body[1], half) - radius
        gain = _gain(y, vx, vy, half) if radius > 0.0 else 0.0
        deviation_m_max = 0.5 * swerve * end_s * end_s
        if now_m > reach + (1.0 + gain) * v * end_s + margin_m + deviation_m_max:
            continue
        if bare_m <= 0.0 and x >= body[1]:
            return True
        # Within the extra room ahead: aside of it, a turn away would look like more room.
        at_corner, corner_m = now_m <= 0.0 < bare_m, min(margin_m, 0.5 * bare_m)
        for k in range(1, steps + 1):
            t = min(k * STEP_S, end_s)
            s = travel_m(t, speed_mps, accel_mps2, response_s, decel_mps2)
            # One who overlaps already may come nearer by two centimetres.
            nearest = 0.5 * now_m if now_m > 0.0 else now_m - 0.02
            alongside_m = min(margin_m, nearest)
            ahead_m = min(margin_m + 0.5 * swerve * t * t, nearest)
            stop_s = min(t, v / brake) if brake > 0.0 else 0.0
            stopped = stop_s * (1.0 - 0.5 * brake * stop_s / v) if v > 1e-6 else 0.0
            ahead, aside = _in_moved_frame(x + vx * stopped, y + vy * stopped, s, curvature_1pm)
            gap_m, allowed = clearance_m(ahead, aside, back, front, half), ahead_m
            if ahead < front - FRONT_ZONE_M:
                allowed = alongside_m
                if radius > 0.0:
                    # Alongside the body only the vehicle's own motion brings a person nearer.
                    ahead, aside = _in_moved_frame(x, y, s, curvature_1pm)
                    gap_m = max(gap_m, clearance_m(ahead, aside, back, front, half))
            if gap_m - radius < allowed:
                return True
            if at_corner and _is_nearer_to_body(ahead, aside, body, radius, corner_m):
                return True
            walks_s = t + gain * (t - RISE_S * (1.0 - math.exp(-t / RISE_S)))
            ahead, aside = _in_moved_frame(x + vx * walks_s, y + vy * walks_s, s, curvature_1pm)
            if ahead < front - FRONT_ZONE_M:
                continue
            if clearance_m(ahead, aside, back, front, half) - radius < ahead_m:
                return True
            if at_corner and _is_nearer_to_body(ahead, aside, body, radius, corner_m):
                return True
    return False


@njit(cache=True)
def _gain(y: float, vx: float, vy: float, half: float) -> float:
    """By which share of their velocity a person beside the path still gains speed."""
    v = math.hypot(vx, vy)
    nears_mps = -vy if y > 0.0 else vy
    if abs(y) <= half or v >= WALK_MPS or nears_mps <= max(SETS_OFF_MPS, ACROSS_SHARE * v):
        return 0.0
    return WALK_MPS / v - 1.0


@njit(cache=True)
def _is_nearer_to_body(
    ahead: float, aside: float, body: tuple[float, float, float], radius: float, allowed_m: float
) -> bool:
    """Whether a road user at the front is nearer to the body itself than allowed_m."""
    if ahead < body[1] - FRONT_ZONE_M:
        return False
    return clearance_m(ahead, aside, body[0], body[1], body[2]) - radius < allowed_m


@njit(cache=True)
def _in_moved_frame(x: float, y: float, s: float, curvature: float) -> tuple[float, float]:
    """A point of the present base frame, in the base frame after s metres along the arc."""
    yaw = curvature * s
    if abs(curvature) < _STRAIGHT_1PM:
        ex, ey = s, 0.5 * curvature * s * s
    else:
        ex, ey = math.sin(yaw) / curvature, (1.0 - math.cos(yaw)) / curvature
    dx, dy = x - ex, y - ey
    cos, sin = math.cos(yaw), math.sin(yaw)
    return cos * dx + sin * dy, cos * dy - sin * dx


@njit(cache=True)
def is_any_within(
    rows: Array, body: tuple[float, float, float], front_margin_m: float, margin_m: float, from_m: float
) -> bool:
    """A road user at from_m or farther ahead is within the footprint's margins now."""
    back, front, half = body[0], body[1] + front_margin_m, body[2]
    for i in range(rows.shape[0]):
        if rows[i, 0] < from_m:
            continue
        if clearance_m(rows[i, 0], rows[i, 1], back, front, half) - rows[i, 4] < margin_m:
            return True
    return False


@njit(cache=True)
def nearest_beside_m(rows: Array, body: tuple[float, float, float]) -> float:
    """The least distance of a person or cyclist from the body's flanks, inf without one beside it.

    Vehicles keep their lanes; they swerve less than people.
    """
    back, front, half = body
    nearest = math.inf
    for i in range(rows.shape[0]):
        if -back <= rows[i, 0] <= front and rows[i, 6] >= PERSON_SWERVE_MPS2:
            nearest = min(nearest, abs(rows[i, 1]) - half - rows[i, 4])
    return nearest
