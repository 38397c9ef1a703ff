"""Predicted agents projected on the path: who takes which stretch of it when (the s-t graph's obstacles)."""

import math

import msgspec
import numpy as np
from numba import njit

from contract.geometry import Array, BoolArray, IntArray
from vehicle_agent.planning.motion.agents import MovingDiscs
from vehicle_agent.planning.motion.clearance import Box, box_distance
from vehicle_agent.planning.motion.path.path_samples import PathSamples
from vehicle_agent.planning.motion.request import ClearanceLaw, StoppingRoom
from vehicle_agent.planning.motion.speed.speed_limits import law_speed, law_vector

# Nobody farther ahead than this is looked at for the room to stop in.
_ROOM_M = 2.5
# Who stands so far behind the bumper can still step before it: the vehicle creeps until they are behind that.
_CORNER_M = 0.3


class Occupancy(msgspec.Struct, frozen=True):
    """By agent a and time slot t: rear-axle ways u at which the vehicle meets it; low > high when nowhere.

    hard_low_m, hard_high_m  (T, a) nominal place and hard margin
    soft_low_m, soft_high_m  (T, a) the inflated place
    limit_mps                (T, n) speed by clearance to pedestrians (eq. 2) at each path sample; 1000 where
                             nobody is near enough to matter
    inside                   (a,) touches the vehicle now
    """

    hard_low_m: np.ndarray
    hard_high_m: np.ndarray
    soft_low_m: np.ndarray
    soft_high_m: np.ndarray
    limit_mps: np.ndarray
    inside: np.ndarray


def project_agents(
    samples: PathSamples,
    moving: MovingDiscs,
    agents: int,
    box: Box,
    hard_margin_m: float,
    soft_margin_m: float,
    law: ClearanceLaw,
    nose_m: float,
    room: StoppingRoom,
) -> Occupancy:
    """Every agent on the path; those who are behind the rear bumper now are left to look out for themselves.

    An agent nearer than the margin now keeps the margin that it has: the vehicle may drive away from it.
    """
    return Occupancy(
        *projected(
            samples.poses_map,
            samples.u_m,
            samples.curvature_1pm,
            moving.discs,
            moving.inflation_m,
            moving.owner,
            moving.pedestrian,
            agents,
            box.front_m,
            box.rear_m,
            box.half_width_m,
            hard_margin_m,
            soft_margin_m,
            law_vector(law),
            nose_m,
            room,
        )
    )


@njit(cache=True)
def projected(
    poses: Array,
    u: Array,
    curvature: Array,
    discs: Array,
    inflation: Array,
    owner: IntArray,
    pedestrian: BoolArray,
    agents: int,
    front: float,
    rear: float,
    half: float,
    hard_margin: float,
    soft_margin: float,
    law: Array,
    nose: float,
    room: StoppingRoom,
) -> tuple[Array, Array, Array, Array, Array, BoolArray]:
    """The kernel of `project_agents`; steps over samples that the clearance shows to be out of reach."""
    slots, total, n = discs.shape[0], discs.shape[1], poses.shape[0]
    hard_low, hard_high = np.full((slots, agents), np.inf), np.full((slots, agents), -np.inf)
    soft_low, soft_high = np.full((slots, agents), np.inf), np.full((slots, agents), -np.inf)
    limit = np.full((slots, n), 1e3)
    inside = np.zeros(agents, np.bool_)
    behind = np.zeros(agents, np.bool_)
    now = np.full(agents, np.inf)
    cos, sin = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    reach = math.hypot(max(front, rear), half)
    # How far a corner moves for a metre of way: at most 1 and the turn's part.
    pace = 1.0 + reach * np.max(np.abs(curvature))
    x, y = poses[0, 0], poses[0, 1]
    for m in range(total):
        gap = box_distance(x, y, cos[0], sin[0], front, rear, half, discs[0, m, 0], discs[0, m, 1])
        now[owner[m]] = min(now[owner[m]], gap - discs[0, m, 2])
        is_behind = cos[0] * (discs[0, m, 0] - x) + sin[0] * (discs[0, m, 1] - y) < -rear
        behind[owner[m]] |= is_behind
        # Somebody at the rear bumper is left behind by driving on; anybody else inside is not.
        inside[owner[m]] |= gap < discs[0, m, 2] and not is_behind
    spacing = np.max(u[1:] - u[:-1])
    for m in range(total):
        a = owner[m]
        if behind[a] and not inside[a]:
            continue
        # A person can be run into by the vehicle's nose alone; whoever is farther back walks beside it.
        tail = min(rear, nose - front) if pedestrian[m] else rear
        hard = min(hard_margin, max(now[a] - 0.02, 0.0))
        for t in range(slots):
            soft = hard + (soft_margin + inflation[t, m] if hard == hard_margin else 0.0)
            seen = max(soft, law[2], _ROOM_M) if pedestrian[m] else soft
            px, py, radius = discs[t, m]
            j = 0
            while j < n:
                gap = (
                    box_distance(poses[j, 0], poses[j, 1], cos[j], sin[j], front, tail, half, px, py) - radius
                )
                if gap < hard:
                    hard_low[t, a], hard_high[t, a] = min(hard_low[t, a], u[j]), max(hard_high[t, a], u[j])
                if gap < soft:
                    soft_low[t, a], soft_high[t, a] = min(soft_low[t, a], u[j]), max(soft_high[t, a], u[j])
                if gap >= seen:
                    j += max(1, int((gap - seen) / (pace * 1.05 * spacing)))
                    continue
                if pedestrian[m]:
                    if gap < law[2]:
                        limit[t, j] = min(limit[t, j], law_speed(gap, law))
                    ahead = cos[j] * (px - poses[j, 0]) + sin[j] * (py - poses[j, 1]) - front - radius
                    aside = abs(cos[j] * (py - poses[j, 1]) - sin[j] * (px - poses[j, 0])) - half - radius
                    if ahead + radius > -_CORNER_M and aside < room.aside_m:
                        limit[t, j] = min(limit[t, j], _room_speed(ahead, aside, room))
                j += 1
    # The samples are `spacing` apart: the true ends are up to so much farther.
    for t in range(slots):
        for a in range(agents):
            if hard_low[t, a] <= hard_high[t, a]:
                hard_low[t, a] -= spacing
                hard_high[t, a] += spacing
            if soft_low[t, a] <= soft_high[t, a]:
                soft_low[t, a] -= spacing
                soft_high[t, a] += spacing
    return hard_low, hard_high, soft_low, soft_high, limit, inside


@njit(cache=True)
def _room_speed(ahead_m: float, aside_m: float, room: StoppingRoom) -> float:
    """From which the vehicle stops within ahead_m less its margin (v r + v^2 / 2 a), or creeps before they
    have come aside_m."""
    left_m = max(ahead_m - room.ahead_m, 0.0)
    stops_mps: float = room.decel_mps2 * (
        math.sqrt(room.response_s * room.response_s + 2.0 * left_m / room.decel_mps2) - room.response_s
    )
    comes_s = math.sqrt(2.0 * max(aside_m, 0.0) / room.step_mps2)
    creeps_mps: float = room.speed_mps_min + room.decel_mps2 * max(comes_s - room.late_s, 0.0)
    return max(stops_mps, creeps_mps)
