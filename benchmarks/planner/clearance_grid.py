"""Clearances over the s-l-t grid, with the early-out by clearance (Snow Lion, "Fast collision checking").

A cell is known to be empty when its neighbour is farther from every disc than the body moves between the two.
There is no tree: a tree does not pay for the 50 agents of one time slot. The planner measures poses of its
own path instead of a grid; the benchmark reproduces the paper's figure.
"""

import math

import numpy as np
from numba import njit

from contract.geometry import Array
from vehicle_agent.planning.motion.clearance import Box, pose_clearance

# Columns of a disc.
_X, _Y, _RADIUS = range(3)


def clearance_grid(
    poses_map: Array, discs_map: Array, box: Box, cap_m: float, *, early_out: bool = True
) -> tuple[Array, int]:
    """Clearance of the vehicle at every (t, s, l): ((T, S, L), number of cells that were computed).

    poses_map  (S, L, 3) rear-axle poses at each station and offset, map frame
    discs_map  (T, m, 3) x, y, radius of every disc at each time slot; NaN places are an error of the caller
    cap_m      clearances are cut at this; a smaller cap skips more cells
    The early-out changes no value, only how many cells are computed.
    """
    grid, computed = grid_clearances(
        np.ascontiguousarray(poses_map), np.ascontiguousarray(discs_map), box, cap_m, early_out
    )
    return grid, computed


@njit(cache=True)
def grid_clearances(poses: Array, discs: Array, box: Box, cap: float, early_out: bool) -> tuple[Array, int]:
    """The kernel of `clearance_grid`; without early-out every cell is measured against every disc.

    There are two early-outs. Discs farther than the cap from every offset of a station are left out there.
    And known[s, l], a lower bound of a cell's clearance, less the farthest that any corner moves from that
    cell, bounds its neighbours: neighbours bounded by the cap or more are not measured. Clearances are
    measured a little beyond the cap, so that a bound can carry over more than one cell.
    """
    slots, stations, offsets = discs.shape[0], poses.shape[0], poses.shape[1]
    grid = np.empty((slots, stations, offsets))
    reach = math.hypot(max(box.front_m, box.rear_m), box.half_width_m)
    spare = 0.3 if early_out else 0.0
    along, aside = _moves(poses, reach)
    known = np.empty((stations, offsets))
    near = np.empty((discs.shape[1], 3))
    computed = 0
    for t in range(slots):
        for i in range(stations):
            count = -1
            for j in range(offsets):
                bound = -np.inf
                if early_out:
                    if i:
                        bound = known[i - 1, j] - along[i, j]
                    if j:
                        bound = max(bound, known[i, j - 1] - aside[i, j])
                if bound >= cap:
                    known[i, j] = bound
                    grid[t, i, j] = cap
                    continue
                if early_out and count < 0:
                    count = _discs_near(poses[i], discs[t], reach, cap, spare, near)
                if early_out and count == 0:
                    known[i, j] = cap + spare
                    grid[t, i, j] = cap
                    continue
                others = near[:count] if early_out else discs[t]
                value = pose_clearance(poses[i, j], box, others, cap + spare)
                computed += 1
                known[i, j] = value
                grid[t, i, j] = min(value, cap)
    return grid, computed


@njit(cache=True)
def _moves(poses: Array, reach: float) -> tuple[Array, Array]:
    """((S, L), (S, L)) how far the body moves at most from the station, and the offset, before each pose."""
    stations, offsets = poses.shape[0], poses.shape[1]
    along = np.full((stations, offsets), np.inf)
    aside = np.full((stations, offsets), np.inf)
    for i in range(stations):
        for j in range(offsets):
            if i:
                along[i, j] = _moved(poses[i - 1, j], poses[i, j], reach)
            if j:
                aside[i, j] = _moved(poses[i, j - 1], poses[i, j], reach)
    return along, aside


@njit(cache=True)
def _discs_near(poses: Array, discs: Array, reach: float, cap: float, spare: float, near: Array) -> int:
    """Copies to `near` the discs (m, 3) that may be within cap + spare of a pose (L, 3); returns how many."""
    low_x, high_x, low_y, high_y = np.inf, -np.inf, np.inf, -np.inf
    for j in range(poses.shape[0]):
        low_x, high_x = min(low_x, poses[j, 0]), max(high_x, poses[j, 0])
        low_y, high_y = min(low_y, poses[j, 1]), max(high_y, poses[j, 1])
    count = 0
    for d in range(discs.shape[0]):
        ex = max(low_x - discs[d, _X], discs[d, _X] - high_x, 0.0)
        ey = max(low_y - discs[d, _Y], discs[d, _Y] - high_y, 0.0)
        far = reach + discs[d, _RADIUS] + cap + spare
        if ex * ex + ey * ey < far * far:
            near[count] = discs[d]
            count += 1
    return count


@njit(cache=True)
def _moved(a: Array, b: Array, reach: float) -> float:
    """How far at most any point of the body moves between two poses."""
    turn = abs((b[2] - a[2] + math.pi) % (2.0 * math.pi) - math.pi)
    moved: float = math.hypot(b[0] - a[0], b[1] - a[1]) + reach * turn
    return moved
