"""Predicted agents projected on the path: the stretch each occupies when (the s-t graph's obstacles)."""

import math
from typing import NamedTuple

import msgspec
import numpy as np
from numba import njit

from contract.geometry import Array, BoolArray
from vehicle_agent.planning.motion.agents import MovingDiscs, believed_share
from vehicle_agent.planning.motion.clearance import Box, BoxPose, box_distance
from vehicle_agent.planning.motion.flanks import is_at_flank
from vehicle_agent.planning.motion.path.path_samples import PathSamples
from vehicle_agent.planning.motion.request import ProjectionParams
from vehicle_agent.planning.motion.speed.room_to_stop import speed_with_room
from vehicle_agent.planning.motion.speed.speed_limits import law_speed

# The stopping room of a person farther away than this is not checked.
_ROOM_M, _RIDER_ROOM_M = 2.5, 5.0
# The velocity of a slower person is in good part the tracker's error: who stands seems to walk away.
_SLOW_MPS = 0.8
# Nearer to the body than this, it decides whether the vehicle creeps.
_AT_HAND_M = 0.5
# A rider who goes the vehicle's way at this speed or more may turn in.
_RIDES_MPS = 1.0


class Occupancy(msgspec.Struct, frozen=True):
    """By agent a and time slot t: rear-axle ways u at which the vehicle meets it; low > high when nowhere.

    hard_low_m, hard_high_m  (T, a) nominal place and hard margin
    soft_low_m, soft_high_m  (T, a) the inflated place
    limit_mps                (T, n) speed by clearance to pedestrians (eq. 2) and by the room to stop, at each
                             path sample; 1000 where nobody is near enough to matter
    room_mps                 (T, n) by the room to stop alone. It ends at once where somebody is passed: up to
                             the next sample it is that of the last
    inside                   (a,) touches the vehicle now, and is no person at its flank
    """

    hard_low_m: np.ndarray
    hard_high_m: np.ndarray
    soft_low_m: np.ndarray
    soft_high_m: np.ndarray
    limit_mps: np.ndarray
    room_mps: np.ndarray
    inside: np.ndarray


class _Sweep(NamedTuple):
    """The body along the path: poses (n, 3), their ways u and headings' cos and sin (n,).

    spacing  the largest step of u; stretch: how far a corner moves at most for a metre of way
    """

    poses: Array
    u: Array
    cos: Array
    sin: Array
    spacing: float
    stretch: float


class _Start(NamedTuple):
    """Agents (a,) at the first sample: gap_m to the body, whether behind its rear bumper, whether inside."""

    gap_m: Array
    behind: BoolArray
    inside: BoolArray


class _Stretches(NamedTuple):
    """The arrays of `Occupancy` (T, a), while they are filled."""

    hard_low: Array
    hard_high: Array
    soft_low: Array
    soft_high: Array


def project_agents(
    samples: PathSamples, moving: MovingDiscs, agents: int, params: ProjectionParams
) -> Occupancy:
    """Where on the path each agent is met; an agent behind the rear bumper now is left out.

    An agent nearer than the margin now keeps the margin that it has: the vehicle may drive away from it.
    """
    return Occupancy(*projected(samples, moving, agents, params))


@njit(cache=True)
def projected(
    samples: PathSamples, moving: MovingDiscs, agents: int, params: ProjectionParams
) -> tuple[Array, Array, Array, Array, Array, Array, BoolArray]:
    """The kernel of `project_agents`; skips samples that the clearance shows to be out of reach."""
    slots, total, n = moving.discs.shape[0], moving.discs.shape[1], samples.poses_map.shape[0]
    stretches = _Stretches(
        np.full((slots, agents), np.inf),
        np.full((slots, agents), -np.inf),
        np.full((slots, agents), np.inf),
        np.full((slots, agents), -np.inf),
    )
    limit, room = np.full((slots, n), 1e3), np.full((slots, n), 1e3)
    sweep = _sweep_of(samples, params.box)
    start = _at_start(sweep, moving, agents, params.box)
    for m in range(total):
        a = moving.owner[m]
        if start.behind[a] and not start.inside[a]:
            continue
        hard = min(params.hard_margin_m, max(start.gap_m[a] - 0.02, 0.0))
        is_at_hand = start.gap_m[a] < _AT_HAND_M
        _occupy(sweep, moving, m, hard, is_at_hand, params, stretches, (limit, room))
    # The samples are `spacing` apart: the true ends are up to so much farther.
    _widen(stretches.hard_low, stretches.hard_high, sweep.spacing)
    _widen(stretches.soft_low, stretches.soft_high, sweep.spacing)
    return (
        stretches.hard_low,
        stretches.hard_high,
        stretches.soft_low,
        stretches.soft_high,
        np.minimum(limit, room),
        room,
        start.inside,
    )


@njit(cache=True)
def _sweep_of(samples: PathSamples, box: Box) -> _Sweep:
    poses, u = samples.poses_map, samples.u_m
    cos, sin = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    reach = math.hypot(max(box.front_m, box.rear_m), box.half_width_m)
    # A corner moves a metre for a metre of way, and its part of the turn.
    stretch = 1.0 + reach * np.max(np.abs(samples.curvature_1pm))
    return _Sweep(poses, u, cos, sin, np.max(u[1:] - u[:-1]), stretch)


@njit(cache=True)
def _at_start(sweep: _Sweep, moving: MovingDiscs, agents: int, box: Box) -> _Start:
    """Each agent at the first slot, seen from the first sample."""
    gap_m = np.full(agents, np.inf)
    behind, inside = np.zeros(agents, np.bool_), np.zeros(agents, np.bool_)
    at = BoxPose(sweep.poses[0, 0], sweep.poses[0, 1], sweep.cos[0], sweep.sin[0])
    discs, owner, pedestrian = moving.discs, moving.owner, moving.pedestrian
    for m in range(discs.shape[1]):
        px, py, radius = discs[0, m, 0], discs[0, m, 1], discs[0, m, 2]
        a = owner[m]
        gap = box_distance(at, box, px, py)
        gap_m[a] = min(gap_m[a], gap - radius)
        dx, dy = px - at.x_m, py - at.y_m
        along, across = at.cos * dx + at.sin * dy, at.cos * dy - at.sin * dx
        is_behind = along < -box.rear_m
        behind[a] |= is_behind
        # The vehicle drives away from a person at its rear bumper or flank, but not from one inside it.
        is_beside = pedestrian[m] and is_at_flank(along, across, box)
        inside[a] |= gap < radius and not is_behind and not is_beside
    return _Start(gap_m, behind, inside)


@njit(cache=True)
def _occupy(
    sweep: _Sweep,
    moving: MovingDiscs,
    m: int,
    hard: float,
    is_at_hand: bool,
    params: ProjectionParams,
    stretches: _Stretches,
    limits: tuple[Array, Array],
) -> None:
    """Adds disc m at every slot: the stretches that it occupies, and the speeds that it allows.

    limits  (T, n) by clearance, and by the room to stop
    Arrays are taken out of the tuples once: each use of a tuple counts references to all of its arrays.
    """
    a, is_person, is_rider, box = moving.owner[m], moving.pedestrian[m], moving.rider[m], params.box
    # Only the vehicle's nose runs into a person; a person farther back walks alongside.
    tail = min(box.rear_m, params.nose_m - box.front_m) if is_person else box.rear_m
    body = Box(box.front_m, tail, box.half_width_m)
    discs, inflation = moving.discs, moving.inflation_m
    poses, ways, cos, sin = sweep.poses, sweep.u, sweep.cos, sweep.sin
    low, high, soft_low, soft_high = stretches
    limit, room = limits
    last = discs.shape[0] - 1
    believed = _believed_share(moving, m) if is_person else 1.0
    for t in range(discs.shape[0]):
        px, py, radius = discs[t, m, 0], discs[t, m, 1], discs[t, m, 2]
        i = min(t, last - 1)
        step_s = max(moving.times_s[i + 1] - moving.times_s[i], 1e-6)
        vx, vy = (
            (discs[i + 1, m, 0] - discs[i, m, 0]) / step_s,
            (discs[i + 1, m, 1] - discs[i, m, 1]) / step_s,
        )
        soft = hard + (params.soft_margin_m + inflation[t, m] if hard == params.hard_margin_m else 0.0)
        matters = max(soft, params.law.delta_m_max, _ROOM_M) if is_person else soft
        if is_rider:
            matters = max(soft, _RIDER_ROOM_M)
        j = 0
        while j < ways.shape[0]:
            at, u = BoxPose(poses[j, 0], poses[j, 1], cos[j], sin[j]), ways[j]
            gap = box_distance(at, body, px, py) - radius
            if gap < hard:
                low[t, a], high[t, a] = min(low[t, a], u), max(high[t, a], u)
            if gap < soft:
                soft_low[t, a], soft_high[t, a] = min(soft_low[t, a], u), max(soft_high[t, a], u)
            beside, sx, sy = gap, px, py
            if believed < 1.0:
                sx = discs[0, m, 0] + believed * (px - discs[0, m, 0])
                sy = discs[0, m, 1] + believed * (py - discs[0, m, 1])
                beside = min(gap, box_distance(at, body, sx, sy) - radius)
            if beside >= matters:
                j += max(1, int((beside - matters) / (sweep.stretch * 1.05 * sweep.spacing)))
                continue
            if is_person:
                if beside < params.law.delta_m_max:
                    limit[t, j] = min(limit[t, j], law_speed(beside, params.law))
                room[t, j] = speed_with_room(at, box, (px, py, vx, vy), radius, params.room, room[t, j])
                if is_at_hand and believed < 1.0:
                    slow = (sx, sy, believed * vx, believed * vy)
                    room[t, j] = speed_with_room(at, box, slow, radius, params.room, room[t, j])
            elif is_rider and vx * at.cos + vy * at.sin > max(abs(vy * at.cos - vx * at.sin), _RIDES_MPS):
                room[t, j] = speed_with_room(at, box, (px, py, vx, vy), radius, params.rider_room, room[t, j])
            j += 1


@njit(cache=True)
def _believed_share(moving: MovingDiscs, m: int) -> float:
    """How much of the way that a slow person is predicted to walk counts as room that they make."""
    first, last = moving.discs[0, m], moving.discs[-1, m]
    speed_mps = math.hypot(last[0] - first[0], last[1] - first[1]) / max(
        moving.times_s[-1] - moving.times_s[0], 1e-6
    )
    if speed_mps <= 0.0 or speed_mps >= _SLOW_MPS:
        return 1.0
    return believed_share(speed_mps)


@njit(cache=True)
def _widen(low: Array, high: Array, by: float) -> None:
    """Widens every stretch (T, a) that is not empty, in place."""
    for t in range(low.shape[0]):
        for a in range(low.shape[1]):
            if low[t, a] <= high[t, a]:
                low[t, a] -= by
                high[t, a] += by
