"""People at the vehicle's flanks: its front has passed where they are, and nobody walks through it."""

import math

import numpy as np
from numba import njit

from contract.geometry import Array, BoolArray, Pose2
from vehicle_agent.planning.motion.agents import MovingDiscs, believed_share
from vehicle_agent.planning.motion.clearance import Box

# What people who walk up to a flank keep from it, or what they have now if that is less.
_KEPT_M = 0.3
# Who is this far behind the bumper can still step in front of it.
CORNER_M = 0.3
# By the tracker's error, somebody beside the body seems to be so far in it.
_ERROR_M = 0.05


def held_at_flanks(moving: MovingDiscs, start_map: Pose2, box: Box) -> MovingDiscs:
    """The same agents, but people who are predicted to come through a flank walk along it instead.

    Their velocity is kept, as everywhere, and leads them into the body where it stands now. A vehicle that
    waits until they have come out of it on the other side waits for nothing. Who is right at a flank makes
    no more room for the corner that follows than their velocity away from it proves, beyond its error.

    start_map  the rear-axle centre's pose now; box: the body about it
    """
    if not moving.pedestrian.any():
        return moving
    pose = np.array([start_map.x_m, start_map.y_m, math.cos(start_map.yaw_rad), math.sin(start_map.yaw_rad)])
    return moving._replace(discs=held(moving.times_s, moving.discs, moving.pedestrian, pose, box))


@njit(cache=True)
def is_at_flank(along_m: float, across_m: float, box: Box) -> bool:
    """Whether a person whose middle is there (base frame) is beside the body, even if they touch it."""
    return -box.rear_m <= along_m <= box.front_m - CORNER_M and abs(across_m) > box.half_width_m - _ERROR_M


@njit(cache=True)
def held(times_s: Array, discs: Array, pedestrian: BoolArray, pose: Array, box: Box) -> Array:
    """discs (T, m, 3) at times_s with people kept out of the body at the pose (x, y, cos, sin).

    See `held_at_flanks`.

    Who comes in by the front, or is in the body already, is left as predicted.
    """
    x0, y0, cos, sin = pose
    out = discs.copy()
    for m in range(discs.shape[1]):
        if not pedestrian[m]:
            continue
        radius = discs[0, m, 2]
        # On which side the person is held, and on which they were beside the body's length just before.
        side, before, kept_m = 0.0, 0.0, 0.0
        # At which flank they are now, how far from the middle line, and how much of a way out is believed.
        flank, begin, believed = 0.0, 0.0, 1.0
        for t in range(discs.shape[0]):
            dx, dy = discs[t, m, 0] - x0, discs[t, m, 1] - y0
            along, across = cos * dx + sin * dy, cos * dy - sin * dx
            aside = abs(across) - box.half_width_m - radius
            here = 1.0 if across > 0.0 else -1.0
            if t == 0:
                beyond = max(-box.rear_m - along, along - box.front_m, 0.0)
                gap = max(math.hypot(beyond, max(aside, 0.0)) if beyond > 0.0 else aside, 0.0)
                kept_m = box.half_width_m + radius + min(gap, _KEPT_M)
                if is_at_flank(along, across, box):
                    before = here
                    if gap < _KEPT_M:
                        flank, begin = here, abs(across)
                        believed = believed_share(_speed_mps(times_s, discs[:, m], here * -sin, here * cos))
                elif gap <= 0.0:
                    break
            is_beside = -box.rear_m <= along <= box.front_m - CORNER_M
            if side == 0.0 and is_beside and abs(across) < kept_m:
                side = before
            if aside >= 0.0:
                before = here
            elif t > 0 and side == 0.0:
                before = 0.0
            held_across = across
            if side != 0.0 and side * across < kept_m:
                held_across = side * kept_m
            if flank != 0.0 and flank * across > begin:
                held_across = flank * (begin + believed * (flank * across - begin))
            if held_across != across:
                across = held_across
                out[t, m, 0] = x0 + cos * along - sin * across
                out[t, m, 1] = y0 + sin * along + cos * across
    return out


@njit(cache=True)
def _speed_mps(times_s: Array, places: Array, out_x: float, out_y: float) -> float:
    """The speed in the direction `out` in the first second of a way; places (T, 3), x and y first."""
    t = len(times_s) - 1
    while t > 0 and times_s[t - 1] >= 1.0:
        t -= 1
    if t == 0:
        return 0.0
    moved_m = (places[t, 0] - places[0, 0]) * out_x + (places[t, 1] - places[0, 1]) * out_y
    speed_mps: float = moved_m / (times_s[t] - times_s[0])
    return speed_mps
