"""An independent checker of trajectories: plain numpy, and none of the planner's kernels.

It uses the request and the rows alone.
"""

import numpy as np

from contract.geometry import Array, BoolArray
from vehicle_agent.planning.motion.request import Agents, DrivingLimits, MotionRequest, Vehicle
from vehicle_agent.signals import PEDESTRIAN

_STILL_MPS = 0.3
# Who is this far behind the bumper can still step in front of it; so far in the body seems somebody beside it
# to be, by the tracker's error.
_CORNER_M, _ERROR_M = 0.3, 0.05


def violations(
    rows: Array, request: MotionRequest, vehicle: Vehicle, limits: DrivingLimits, *, emergency: bool = False
) -> tuple[str, ...]:
    """The names of the violations of rows (k, 8) as an answer to the request; empty for none.

    emergency  check against the hardest braking and its jerk instead of the ordinary ones
    Names: empty, not_finite, start, kinematics, speed, accel, jerk, curvature, lateral, wall, static, agent,
    footprint (a person or obstacle is inside the outline at the start and the answer is not a stop; a person
    whose middle is beside the body touches its flank and is not inside it), end.
    """
    if len(rows) < 2:
        return ("empty",)
    if not np.isfinite(rows).all():
        return ("not_finite",)
    offset_m, at_m = _offsets(rows, request)
    found = {
        "start": _leaves_start(rows, request),
        "kinematics": _is_inconsistent(rows),
        **_bounds(rows, request, vehicle, limits, emergency),
        "wall": _crosses_wall(offset_m, at_m, request),
        "static": _hits_static(rows, request, vehicle),
        "agent": _hits_agent(rows, request.agents, vehicle),
        "footprint": _drives_on(rows, request, vehicle),
        "end": _overruns(rows, at_m, request, limits),
    }
    return tuple(name for name, wrong in found.items() if wrong)


def _leaves_start(rows: Array, request: MotionRequest) -> bool:
    pose = request.start.pose_map
    off_m = np.hypot(rows[0, 1] - pose.x_m, rows[0, 2] - pose.y_m)
    turn = np.angle(np.exp(1j * (rows[0, 3] - pose.yaw_rad)))
    return bool(
        rows[0, 0] != 0.0
        or off_m > 0.02
        or abs(turn) > 0.01
        or abs(rows[0, 5] - max(request.start.speed_mps, 0.0)) > 0.02
    )


def _is_inconsistent(rows: Array) -> bool:
    """Times rise, and place, yaw and speed follow from speed, curvature and acceleration."""
    t, x, y, yaw, kappa, v, a = rows[:, :7].T
    dt = np.diff(t)
    if (dt <= 0.0).any():
        return True
    way = 0.5 * (v[1:] + v[:-1]) * dt - np.diff(a) * dt**2 / 12.0
    middle = 0.5 * (yaw[1:] + yaw[:-1])
    off = np.hypot(np.diff(x) - way * np.cos(middle), np.diff(y) - way * np.sin(middle))
    turned = np.abs(np.diff(yaw) - 0.5 * (kappa[1:] + kappa[:-1]) * way)
    slower = np.abs(np.diff(v) - 0.5 * (a[1:] + a[:-1]) * dt)
    # At rest the acceleration falls to zero at once.
    ends = (v[1:] < 0.02) | (v[:-1] < 0.02)
    return bool((off > 0.01).any() or (turned > 0.01).any() or (slower[~ends] > 0.02).any())


def _bounds(
    rows: Array, request: MotionRequest, vehicle: Vehicle, limits: DrivingLimits, emergency: bool
) -> dict[str, bool]:
    t, kappa, v, a = rows[:, 0], rows[:, 4], rows[:, 5], rows[:, 6]
    v0, a0 = request.start.speed_mps, request.start.accel_mps2
    decel = limits.hard_decel_mps2 if emergency else limits.decel_mps2_max
    jerk_max = limits.hard_jerk_mps3 if emergency else limits.jerk_mps3_max
    # A start outside the bounds has to come back to them, about as fast as the jerk allows.
    high = np.maximum(limits.accel_mps2_max - limits.accel_fade_1ps * v, a0 - 0.8 * jerk_max * t)
    low = np.minimum(-decel, a0 + 0.8 * jerk_max * t)
    rise = max(a0, 0.0) ** 2 / (2.0 * limits.jerk_mps3_max)
    delay = max(a0, 0.0) / limits.jerk_mps3_max + 1.5
    excess = v0 + rise - limits.decel_mps2_comfort * np.maximum(t - delay, 0.0)
    moves = np.minimum(v[1:], v[:-1]) > 0.15
    jerk = np.diff(a) / np.diff(t)
    at_start = np.abs(request.start.curvature_1pm) + 0.005
    too_tight = np.abs(kappa) > np.maximum(vehicle.curvature_1pm_max + 0.002, at_start)
    lateral = kappa * v * v
    # The lateral acceleration of the start is a fact; it may only fall from there.
    lateral_max = np.maximum(
        limits.lateral_accel_mps2_max * 1.05,
        abs(request.start.curvature_1pm) * v0**2 * 1.05 + 0.02 - 0.2 * t * (not emergency),
    )
    return {
        "speed": bool((v < -1e-9).any() or (v > np.maximum(limits.speed_mps_max, excess) + 0.05).any()),
        "accel": bool((a > high + 0.02).any() or (a < low - 0.02).any()),
        "jerk": bool((np.abs(jerk[moves]) > jerk_max * 1.02 + 0.02).any()),
        "curvature": bool(too_tight[v > 0.01].any()),
        "lateral": bool((np.abs(lateral) > lateral_max).any() and not emergency),
    }


def _crosses_wall(offset: Array, at: Array, request: MotionRequest) -> bool:
    """The rear axle beyond the room, unless it starts there and only comes back."""
    line = request.corridor.s_m
    excess = np.maximum(
        np.interp(at, line, request.lower_l_m) - offset, offset - np.interp(at, line, request.upper_l_m)
    )
    allowed = 0.06 if excess[0] <= 0.05 else excess[0] + 0.3
    inside = np.flatnonzero(excess <= 0.0)
    first = inside[0] if len(inside) else len(at)
    return bool((excess[:first] > allowed).any() or (excess[first:] > 0.06).any())


def _offsets(rows: Array, request: MotionRequest) -> tuple[Array, Array]:
    """((k,) offset to the left, (k,) s) on the task's own polyline, near where each row says it is."""
    points, s = request.corridor.points_map, request.corridor.s_m
    legs = np.diff(points, axis=0)
    length = np.maximum(np.hypot(legs[:, 0], legs[:, 1]), 1e-9)
    to_x = rows[:, 1, None] - points[None, :-1, 0]
    to_y = rows[:, 2, None] - points[None, :-1, 1]
    share = np.clip((to_x * legs[:, 0] + to_y * legs[:, 1]) / length**2, 0.0, 1.0)
    off_x, off_y = to_x - share * legs[:, 0], to_y - share * legs[:, 1]
    away = off_x**2 + off_y**2
    away[np.abs(rows[:, 7, None] - s[None, :-1]) > 4.0] = np.inf
    best = np.argmin(away, axis=1)
    k = np.arange(len(rows))
    left = (legs[best, 0] * to_y[k, best] - legs[best, 1] * to_x[k, best]) / length[best]
    return left, s[best] + share[k, best] * np.diff(s)[best]


def _gaps(rows: Array, vehicle: Vehicle, x: Array, y: Array, radius: Array, nose_m: float = np.inf) -> Array:
    """(k, m) clearance of the outline at each row to discs (m,) or (k, m)."""
    cos, sin = np.cos(rows[:, 3])[:, None], np.sin(rows[:, 3])[:, None]
    dx, dy = x - rows[:, 1, None], y - rows[:, 2, None]
    length_m = min(vehicle.length_m, nose_m)
    middle = vehicle.length_m - vehicle.rear_overhang_m - 0.5 * length_m
    along = np.abs(dx * cos + dy * sin - middle) - 0.5 * length_m
    across = np.abs(dy * cos - dx * sin) - 0.5 * vehicle.width_m
    outside = np.hypot(np.maximum(along, 0.0), np.maximum(across, 0.0))
    gaps: Array = np.where(outside > 0.0, outside, np.maximum(along, across)) - radius
    return gaps


def _hits_static(rows: Array, request: MotionRequest, vehicle: Vehicle) -> bool:
    discs = request.static_discs
    near = np.hypot(discs[:, 0] - rows[0, 1], discs[:, 1] - rows[0, 2]) < 60.0
    discs = discs[near]
    if not len(discs):
        return False
    gaps = _gaps(rows, vehicle, discs[None, :, 0], discs[None, :, 1], discs[None, :, 2])
    touched = gaps[0] < 0.0
    return bool(((gaps < 0.0) & (rows[:, 5, None] > 0.05))[:, ~touched].any())


def _known(agents: Agents) -> BoolArray:
    """Agents with a finite place and a valid size; the others cannot be checked."""
    known: BoolArray = np.isfinite(agents.poses_map).all(axis=(1, 2)) & np.isfinite(agents.sizes_m).all(
        axis=1
    )
    if agents.poses_map.shape[1] > 1:
        with np.errstate(invalid="ignore", over="ignore"):
            hop = np.abs(np.diff(agents.poses_map[:, :, :2], axis=1)).max(axis=(1, 2), initial=0.0)
        known &= hop < 100.0
    return known


def _agent_gaps(rows: Array, agents: Agents, vehicle: Vehicle, nose_m: float = np.inf) -> Array:
    """(k, a) clearance to each agent's nominal outline: people as discs, others as boxes (exact overlap).

    Nobody is predicted to walk through a flank (`_kept_out`).

    nose_m: clearances to people are of this length of the body alone, from the bumper back.
    """
    known = _known(agents)
    poses, sizes = agents.poses_map[known], agents.sizes_m[known]
    t = rows[:, 0]
    if poses.shape[1] == 1:
        x = np.repeat(poses[:, 0, 0][None], len(t), axis=0)
        y = np.repeat(poses[:, 0, 1][None], len(t), axis=0)
    else:
        i = np.clip(np.searchsorted(agents.times_s, t, side="right") - 1, 0, len(agents.times_s) - 2)
        w = (t - agents.times_s[i]) / (agents.times_s[i + 1] - agents.times_s[i])
        places = poses[:, i, :2] + w[None, :, None] * (poses[:, i + 1, :2] - poses[:, i, :2])
        x, y = places[..., 0].T, places[..., 1].T
    radius, is_person = 0.5 * sizes.max(axis=1), agents.kinds[known] == PEDESTRIAN
    if is_person.any():
        x, y = _kept_out(rows, vehicle, x, y, radius, is_person)
    gaps = _gaps(rows, vehicle, x, y, radius[None, :], nose_m)
    for a in np.flatnonzero(agents.kinds[known] != PEDESTRIAN):
        nearest = np.clip(np.searchsorted(agents.times_s, t), 0, poses.shape[1] - 1)
        yaw = poses[a, nearest, 2]
        gaps[:, a] = _box_gaps(rows, vehicle, x[:, a], y[:, a], yaw, sizes[a])
    behind = _is_behind(rows, vehicle, x[0], y[0])
    gaps[:, behind & ((gaps[0] > 0.0) | (agents.kinds[known] == PEDESTRIAN))] = np.inf
    return gaps


def _is_behind(rows: Array, vehicle: Vehicle, x: Array, y: Array) -> BoolArray:
    """(m,) Middles behind the rear bumper at the start: driving on leaves them behind."""
    dx, dy, yaw = x - rows[0, 1], y - rows[0, 2], rows[0, 3]
    behind: BoolArray = dx * np.cos(yaw) + dy * np.sin(yaw) < -vehicle.rear_overhang_m
    return behind


def _kept_out(
    rows: Array, vehicle: Vehicle, x: Array, y: Array, radius: Array, people: BoolArray
) -> tuple[Array, Array]:
    """The places x, y (k, a) of agents; people do not walk on through a flank of the body at the start.

    From where they reach it they walk along it, touching it. Who comes in by the front goes on.
    """
    cos, sin = np.cos(rows[0, 3]), np.sin(rows[0, 3])
    dx, dy = x - rows[0, 1], y - rows[0, 2]
    along, across = cos * dx + sin * dy, cos * dy - sin * dx
    touching_m = 0.5 * vehicle.width_m + radius
    corner_m = vehicle.length_m - vehicle.rear_overhang_m - _CORNER_M
    within = (-vehicle.rear_overhang_m <= along) & (along <= corner_m) & (np.abs(across) < touching_m)
    first, a = np.argmax(within, axis=0), np.arange(x.shape[1])
    before = across[np.maximum(first - 1, 0), a]
    by_flank = np.where(
        first > 0, np.abs(before) >= touching_m, np.abs(before) > 0.5 * vehicle.width_m - _ERROR_M
    )
    held = (people & within.any(axis=0) & by_flank) & (np.arange(len(x))[:, None] >= first)
    side = np.where(before > 0.0, 1.0, -1.0)
    across = np.where(held, side * np.maximum(side * across, touching_m + 1e-6), across)
    return rows[0, 1] + cos * along - sin * across, rows[0, 2] + sin * along + cos * across


def _box_gaps(rows: Array, vehicle: Vehicle, x: Array, y: Array, yaw: Array, size: Array) -> Array:
    """(k,) largest separation over the four axes of two boxes: below zero exactly when they overlap."""
    middle = 0.5 * vehicle.length_m - vehicle.rear_overhang_m
    dx = x - (rows[:, 1] + middle * np.cos(rows[:, 3]))
    dy = y - (rows[:, 2] + middle * np.sin(rows[:, 3]))
    separations = []
    for axis in (rows[:, 3], rows[:, 3] + 0.5 * np.pi, yaw, yaw + 0.5 * np.pi):
        ours = 0.5 * vehicle.length_m * np.abs(np.cos(rows[:, 3] - axis))
        ours += 0.5 * vehicle.width_m * np.abs(np.sin(rows[:, 3] - axis))
        theirs = 0.5 * size[0] * np.abs(np.cos(yaw - axis)) + 0.5 * size[1] * np.abs(np.sin(yaw - axis))
        separations.append(np.abs(dx * np.cos(axis) + dy * np.sin(axis)) - ours - theirs)
    widest: Array = np.max(separations, axis=0)
    return widest


def _hits_agent(rows: Array, agents: Agents, vehicle: Vehicle) -> bool:
    """The body touches an agent's nominal place while moving; agents inside at the start are `footprint`."""
    if not len(agents.ids):
        return False
    gaps = _agent_gaps(rows, agents, vehicle, vehicle.nose_m)
    hits = (gaps < 0.0) & (rows[:, 5, None] > _STILL_MPS)
    return bool(hits[:, gaps[0] >= 0.0].any())


def _drives_on(rows: Array, request: MotionRequest, vehicle: Vehicle) -> bool:
    """A person or obstacle is inside the outline and the rows do not stop at once."""
    discs = request.static_discs
    discs = discs[~_is_behind(rows, vehicle, discs[:, 0], discs[:, 1])]
    inside = len(discs) > 0 and bool(
        (_gaps(rows[:1], vehicle, discs[None, :, 0], discs[None, :, 1], discs[None, :, 2]) < 0.0).any()
    )
    if len(request.agents.ids):
        inside |= bool((_agent_gaps(rows[:1], request.agents, vehicle) < 0.0).any())
    if not inside:
        return False
    return not _stops_at_once(rows)


def _stops_at_once(rows: Array) -> bool:
    v = rows[:, 5]
    late = rows[:, 0] > v[0] / 1.5 + 1.0
    return not bool((np.diff(v) > 0.1).any() or (v[late] > 0.05).any() or v[-1] > 0.05)


def _overruns(rows: Array, at: Array, request: MotionRequest, limits: DrivingLimits) -> bool:
    """Passes the place where it must stand, or can no longer stop before it at the end of the rows.

    A start that is too near and too fast for that is asked to stop at once.
    """
    if not np.isfinite(request.end_s_m):
        return False
    v0 = rows[0, 5]
    if at[0] + v0**2 / (2.0 * limits.decel_mps2_max) + 0.5 * v0 > request.end_s_m:
        beyond = (at > request.end_s_m + 0.1) & (rows[:, 5] > 0.05)
        return bool(beyond.any()) and not _stops_at_once(rows)
    beyond = (at > request.end_s_m + 0.1) & (rows[:, 5] > 0.05)
    needed = rows[-1, 5] ** 2 / (2.0 * limits.decel_mps2_max)
    return bool(beyond.any() or needed > request.end_s_m - at[-1] + 0.2)
