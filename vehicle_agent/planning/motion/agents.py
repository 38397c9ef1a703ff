"""Predicted agents as moving discs on the planner's own clock; implausible predictions are marked."""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from contract.geometry import Array, BoolArray, IntArray
from vehicle_agent.planning.motion.request import Agents, MotionParams, MotionRequestError
from vehicle_agent.signals import CYCLIST, PEDESTRIAN

# The error of a tracked velocity is seldom more.
_ERROR_MPS = 0.4


class MovingDiscs(NamedTuple):
    """Agents as discs (T, m, 3) x, y, radius at times_s (T,); a tuple, so that kernels take it as it is.

    inflation_m  (T, m) softly kept extra; owner (m,) row of Agents
    pedestrian   (m,) whether the speed law holds for it
    rider        (m,) whether it may turn in like a cyclist
    doubted      ids of implausible predictions: not finite, or faster than speed_mps_max
    """

    times_s: Array
    discs: Array
    inflation_m: Array
    owner: IntArray
    pedestrian: BoolArray
    rider: BoolArray
    doubted: IntArray


def check_agents(agents: Agents) -> None:
    """Raises MotionRequestError for arrays that do not fit each other. Values are judged, not refused."""
    count, times = len(agents.ids), len(agents.times_s)
    shapes = {
        "poses_map": (agents.poses_map.shape, (count, times, 3)),
        "sizes_m": (agents.sizes_m.shape, (count, 2)),
        "inflation_m": (agents.inflation_m.shape, (count, times)),
        "kinds": (agents.kinds.shape, (count,)),
        "pass_rule": (agents.pass_rule.shape, (count,)),
    }
    for name, (got, wanted) in shapes.items():
        if got != wanted:
            raise MotionRequestError(f"agents.{name} has shape {got}, not {wanted}")
    if times < 1 or not np.isfinite(agents.times_s).all() or (np.diff(agents.times_s) <= 0.0).any():
        raise MotionRequestError("agents.times_s must rise strictly")


def moving_discs(agents: Agents, times_s: Array, speed_mps_max: float) -> MovingDiscs:
    """Agents as discs at times_s (T,); a long outline becomes a row of discs that covers it.

    Beyond the last prediction an agent keeps its last velocity. An agent faster than speed_mps_max stays at
    its first place; an agent without a finite place is left out. Both are listed in `doubted`.
    """
    first = agents.poses_map[:, 0]
    sizes_ok = np.isfinite(agents.sizes_m).all(axis=1) & (agents.sizes_m > 0.0).all(axis=1)
    sizes_ok &= (agents.sizes_m < 50.0).all(axis=1)
    placed = np.isfinite(first).all(axis=1) & (np.abs(first[:, :2]) < 1e7).all(axis=1) & sizes_ok
    smooth = placed & _is_believable(agents, speed_mps_max)
    kept = np.flatnonzero(placed)
    poses = np.where(smooth[:, None, None], agents.poses_map, first[:, None, :])[kept]
    inflation = np.where(np.isfinite(agents.inflation_m), np.maximum(agents.inflation_m, 0.0), 0.0)[kept]
    sizes = agents.sizes_m[kept]
    walks, rides = agents.kinds[kept] == PEDESTRIAN, agents.kinds[kept] == CYCLIST
    discs, spread, owner = discs_over_time(
        np.ascontiguousarray(poses), agents.times_s, sizes, walks, inflation, times_s
    )
    return MovingDiscs(times_s, discs, spread, kept[owner], walks[owner], rides[owner], agents.ids[~smooth])


def early_slots(agents: Agents, params: MotionParams) -> IntArray:
    """(a,) how many slots of row_s earlier than predicted each agent may come.

    A person who moves slower than people walk may just have begun to. The slower they still are, the more
    time they can make up: start_s walk_mps / speed.
    """
    slots = np.full(len(agents.ids), round(params.early_s / params.row_s))
    second = int(np.searchsorted(agents.times_s, 1.0))
    if second >= len(agents.times_s):
        return slots
    moved = agents.poses_map[:, second, :2] - agents.poses_map[:, 0, :2]
    speed_mps = np.hypot(moved[:, 0], moved[:, 1]) / agents.times_s[second]
    starts = (
        (agents.kinds == PEDESTRIAN) & (params.moving_mps_min < speed_mps) & (speed_mps < params.walk_mps)
    )
    granted_s = params.start_s * params.walk_mps / speed_mps[starts]
    slots[starts] = np.rint(granted_s / params.row_s).astype(np.int64)
    return slots


def _is_believable(agents: Agents, speed_mps_max: float) -> BoolArray:
    finite: BoolArray = np.isfinite(agents.poses_map).all(axis=(1, 2))
    if len(agents.times_s) < 2:
        return finite
    steps = np.diff(np.where(finite[:, None, None], agents.poses_map, 0.0)[:, :, :2], axis=1)
    speeds = np.hypot(steps[..., 0], steps[..., 1]) / np.diff(agents.times_s)
    believable: BoolArray = finite & (speeds <= speed_mps_max).all(axis=1)
    return believable


@njit(cache=True)
def believed_share(speed_mps: float) -> float:
    """How much of a tracked speed is more than its error: nothing at 0.4 m/s, three quarters at 0.8."""
    return max(1.0 - (_ERROR_MPS / max(speed_mps, 1e-6)) ** 2, 0.0)


@njit(cache=True)
def discs_over_time(
    poses: Array, times: Array, sizes: Array, is_disc: BoolArray, inflation: Array, at: Array
) -> tuple[Array, Array, IntArray]:
    """((T, m, 3) discs, (T, m) inflation, (m,) owner) at the times `at`; see `moving_discs`."""
    agents, slots = poses.shape[0], at.shape[0]
    counts = np.ones(agents, np.int64)
    for a in range(agents):
        if not is_disc[a]:
            counts[a] = min(max(math.ceil(sizes[a, 0] / sizes[a, 1] - 1e-9), 1), 8)
    total = counts.sum()
    discs, spread = np.empty((slots, total, 3)), np.empty((slots, total))
    owner = np.empty(total, np.int64)
    places = np.empty((slots, 4))
    m = 0
    for a in range(agents):
        length, width = sizes[a]
        part = length / counts[a]
        radius = 0.5 * max(length, width) if is_disc[a] else 0.5 * math.hypot(part, width)
        for c in range(counts[a]):
            owner[m + c] = a
        _place_over_time(poses[a], inflation[a], times, at, places)
        for t in range(slots):
            x, y, yaw, extra = places[t]
            for c in range(counts[a]):
                along = (c + 0.5) * part - 0.5 * length if not is_disc[a] else 0.0
                discs[t, m + c, 0] = x + along * math.cos(yaw)
                discs[t, m + c, 1] = y + along * math.sin(yaw)
                discs[t, m + c, 2] = radius
                spread[t, m + c] = extra
        m += counts[a]
    return discs, spread, owner


@njit(cache=True)
def _place_over_time(poses: Array, inflation: Array, times: Array, at: Array, out: Array) -> None:
    """Fills out (T, 4) x, y, yaw, inflation of one agent at the times `at`, from its poses (k, 3).

    Places go on beyond the last time as between the last two; inflation does not.
    """
    i = 0
    for t in range(at.shape[0]):
        while i < times.shape[0] - 2 and times[i + 1] <= at[t]:
            i += 1
        if times.shape[0] == 1:
            out[t, :3], out[t, 3] = poses[0], inflation[0]
            continue
        w = (at[t] - times[i]) / (times[i + 1] - times[i])
        out[t, 0] = poses[i, 0] + w * (poses[i + 1, 0] - poses[i, 0])
        out[t, 1] = poses[i, 1] + w * (poses[i + 1, 1] - poses[i, 1])
        out[t, 2] = poses[i, 2] if w < 0.5 else poses[i + 1, 2]
        w = min(max(w, 0.0), 1.0)
        out[t, 3] = inflation[i] + w * (inflation[i + 1] - inflation[i])
