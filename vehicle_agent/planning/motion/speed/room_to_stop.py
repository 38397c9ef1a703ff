"""The room to stop before people, and behind riders: how fast the vehicle may come near them."""

import math

from numba import njit

from vehicle_agent.planning.motion.clearance import Box, BoxPose
from vehicle_agent.planning.motion.flanks import CORNER_M
from vehicle_agent.planning.motion.request import StoppingRoom, SuddenStep

# A person who walks this far beside the body, or farther, walks along it and not in its way.
_BESIDE_M = 0.4
_NEWTON_STEPS = 4


@njit(cache=True)
def speed_with_room(
    at: BoxPose,
    box: Box,
    person: tuple[float, float, float, float],
    radius: float,
    room: StoppingRoom,
    limit: float,
) -> float:
    """The limit, lowered by the room to stop before a person or rider ahead of the bumper or beside the way.

    person: x, y and velocity
    """
    dx, dy, vx, vy = person[0] - at.x_m, person[1] - at.y_m, person[2], person[3]
    ahead = at.cos * dx + at.sin * dy - box.front_m - radius
    across = at.cos * dy - at.sin * dx
    aside = abs(across) - box.half_width_m - radius
    # Until they cannot step in front of it any more, the vehicle creeps.
    if ahead + radius > -CORNER_M and aside < room.aside_m:
        along_mps = at.cos * vx + at.sin * vy
        away_mps = (at.cos * vy - at.sin * vx) * (1.0 if across > 0.0 else -1.0)
        limit = min(limit, _room_speed(ahead, aside, along_mps, away_mps, room))
    return limit


@njit(cache=True)
def _room_speed(
    ahead_m: float, aside_m: float, along_mps: float, away_mps: float, room: StoppingRoom
) -> float:
    """The speed from which the vehicle stops before the person, or from which it only creeps when a person
    who turns into the way has come aside_m nearer; the larger of the two.

    It stops in v r + v^2 / 2 a, in which a person who comes towards it keeps their speed, one who walks ahead
    of it turns round, and a rider ahead brakes.

    along_mps, away_mps  how the person walks now, along the path and away from it
    """
    if along_mps > 0.0 and room.turn_s > 0.0:
        stops_mps = speed_behind_walker(ahead_m - room.ahead_m, along_mps, room)
    else:
        comes_mps = max(-along_mps, 0.0)
        # Who brakes goes on so far; who turns across keeps their speed along the path for about rise_s.
        goes_m = max(along_mps, 0.0) * min(0.5 * max(along_mps, 0.0) / room.rider_mps2, room.step.rise_s)
        left_m = ahead_m + goes_m - comes_mps * room.response_s - room.ahead_m
        # A person still beside the way has to be seen stepping into it first; a rider's response includes it.
        late_s = room.late_s if aside_m > 0.0 and room.turn_s > 0.0 else room.response_s
        stops_mps = _stoppable(left_m, late_s + comes_mps / room.decel_mps2, room.decel_mps2)
    comes_s = turn_time_s(max(aside_m - room.error_m, 0.0), away_mps, room.step)
    # What is left by then of the way along the path that the person walks now.
    along_mps = max(along_mps, 0.0) * math.exp(-comes_s / room.step.rise_s)
    if room.turn_s > 0.0:
        # The vehicle does not creep up to a person in its way at their own pace: they may turn round.
        along_mps *= min(max(aside_m, 0.0) / _BESIDE_M, 1.0)
    creeps_mps: float = room.speed_mps_min + along_mps + room.decel_mps2 * max(comes_s - room.late_s, 0.0)
    return max(stops_mps, creeps_mps)


@njit(cache=True)
def _stoppable(left_m: float, late_s: float, decel_mps2: float) -> float:
    """The speed from which a vehicle that brakes after late_s stops within left_m; 0 without room."""
    speed_mps: float = decel_mps2 * (math.sqrt(late_s**2 + 2.0 * max(left_m, 0.0) / decel_mps2) - late_s)
    return speed_mps


@njit(cache=True)
def speed_behind_walker(left_m: float, walks_mps: float, room: StoppingRoom) -> float:
    """The speed from which the vehicle stops behind a person ahead who turns round; left_m: the room now.

    Who walks away from the vehicle does not see it: their velocity walks_mps > 0 approaches its opposite with
    the time constant rise_s. The slower they walk, the sooner a turn is seen. Newton's method on the room
    that is missing, a convex function of the speed, from beyond its root.
    """
    rise_s, decel_mps2 = room.step.rise_s, room.decel_mps2
    late_s = room.response_s + min(walks_mps / room.step.mps, 1.0) * (room.turn_s - room.response_s)
    v = _stoppable(left_m + walks_mps * rise_s, late_s, decel_mps2)
    for _ in range(_NEWTON_STEPS):
        stands_s = late_s + v / decel_mps2
        left = math.exp(-stands_s / rise_s)
        goes_m = walks_mps * (2.0 * rise_s * (1.0 - left) - stands_s)
        missing_m = v * (late_s + 0.5 * v / decel_mps2) - left_m - goes_m
        v -= missing_m / (stands_s - walks_mps * (2.0 * left - 1.0) / decel_mps2)
        if v <= 0.0:
            return 0.0
    return v


@njit(cache=True)
def turn_time_s(aside_m: float, away_mps: float, step: SuddenStep) -> float:
    """How long a person who turns into the way at once takes to come aside_m nearer.

    Their velocity across the path approaches step.mps from away_mps, which is theirs now, with the time
    constant step.rise_s. Newton's method on aside + (away + mps) rise (1 - exp(-t / rise)) - mps t, which is
    concave, from beyond its root.
    """
    turn_mps = max(away_mps + step.mps, 0.0)
    t = (aside_m + turn_mps * step.rise_s) / step.mps
    for _ in range(_NEWTON_STEPS):
        left = math.exp(-t / step.rise_s)
        slope = turn_mps * left - step.mps
        if slope > -1e-6:
            break
        t -= (aside_m + turn_mps * step.rise_s * (1.0 - left) - step.mps * t) / slope
    return max(t, 0.0)
