"""Exact clearances between the vehicle's box and discs: of one pose, and over the s-l-t grid.

The grid keeps the paper's early-out by clearance ("Fast collision checking"): a cell is known to be empty
when its neighbour is farther from everything than the body moves between the two. Without a tree: 50 agents
in one time slot are fewer than a tree pays for.
"""

import math

import msgspec
import numpy as np
from numba import njit

from contract.geometry import Array


class Box(msgspec.Struct, frozen=True):
    """The vehicle's outline about its rear-axle centre."""

    front_m: float
    rear_m: float
    half_width_m: float

    @property
    def reach_m(self) -> float:
        """From the rear-axle centre to the farthest corner."""
        return math.hypot(max(self.front_m, self.rear_m), self.half_width_m)


@njit(cache=True)
def box_distance(
    x: float, y: float, cos: float, sin: float, front: float, rear: float, half: float, px: float, py: float
) -> float:
    """Signed distance of the point (px, py) from a box at (x, y) turned by (cos, sin); negative inside."""
    dx, dy = px - x, py - y
    ahead = cos * dx + sin * dy
    beyond_x = max(ahead - front, -rear - ahead)
    beyond_y = abs(-sin * dx + cos * dy) - half
    if beyond_x > 0.0 and beyond_y > 0.0:
        return math.sqrt(beyond_x * beyond_x + beyond_y * beyond_y)
    inside: float = max(beyond_x, beyond_y)
    return inside


@njit(cache=True)
def pose_clearance(
    x: float,
    y: float,
    yaw: float,
    front: float,
    rear: float,
    half: float,
    discs: Array,
    cap: float,
) -> float:
    """The least clearance of the box at one pose to the discs (m, 3), at most cap."""
    cos, sin = math.cos(yaw), math.sin(yaw)
    middle = 0.5 * (front - rear)
    cx, cy = x + middle * cos, y + middle * sin
    reach = math.hypot(0.5 * (front + rear), half)
    best = cap
    for i in range(discs.shape[0]):
        dx, dy = discs[i, 0] - cx, discs[i, 1] - cy
        far = reach + discs[i, 2] + best
        if far <= 0.0 or dx * dx + dy * dy >= far * far:
            continue
        gap = box_distance(x, y, cos, sin, front, rear, half, discs[i, 0], discs[i, 1]) - discs[i, 2]
        best = min(best, gap)
    return best


@njit(cache=True)
def first_touch(
    poses: Array, front: float, rear: float, half: float, discs: Array, margin: float
) -> tuple[int, bool]:
    """(first of the poses (n, 3) that is nearer than the margin to one of the discs (m, 3), -1 for none;
    whether the first pose touches one).

    What stands behind the rear bumper at the start is left behind. What is nearer than the margin already may
    be driven away from, and past, but not towards.
    """
    allowed = np.empty(discs.shape[0])
    x, y, cos, sin = poses[0, 0], poses[0, 1], math.cos(poses[0, 2]), math.sin(poses[0, 2])
    for k in range(discs.shape[0]):
        px, py = discs[k, 0], discs[k, 1]
        now = box_distance(x, y, cos, sin, front, rear, half, px, py) - discs[k, 2]
        if cos * (px - x) + sin * (py - y) < -rear:
            allowed[k] = -np.inf
        elif now < 0.0:
            return -1, True
        else:
            allowed[k] = min(margin, max(now - 0.02, 0.0))
    reach = math.hypot(max(front, rear), half) + margin
    for j in range(poses.shape[0]):
        x, y, cos, sin = poses[j, 0], poses[j, 1], math.cos(poses[j, 2]), math.sin(poses[j, 2])
        for k in range(discs.shape[0]):
            dx, dy, far = discs[k, 0] - x, discs[k, 1] - y, reach + discs[k, 2]
            if dx * dx + dy * dy > far * far:
                continue
            gap = box_distance(x, y, cos, sin, front, rear, half, discs[k, 0], discs[k, 1]) - discs[k, 2]
            if gap < allowed[k]:
                return j, False
    return -1, False


def clearance_grid(
    poses_map: Array, discs_map: Array, box: Box, cap_m: float, *, early_out: bool = True
) -> tuple[Array, int]:
    """Clearance of the vehicle at every (t, s, l): ((T, S, L), number of cells that were computed).

    poses_map  (S, L, 3) rear-axle poses at each station and offset, map frame
    discs_map  (T, m, 3) x, y, radius of everything at each time slot; NaN places are an error of the caller
    cap_m      clearances are cut at this; the smaller, the more is skipped
    The early-out changes no value, only how many cells are computed.
    """
    grid, computed = grid_clearances(
        np.ascontiguousarray(poses_map),
        np.ascontiguousarray(discs_map),
        box.front_m,
        box.rear_m,
        box.half_width_m,
        cap_m,
        early_out,
    )
    return grid, computed


@njit(cache=True)
def grid_clearances(
    poses: Array, discs: Array, front: float, rear: float, half: float, cap: float, early_out: bool
) -> tuple[Array, int]:
    """The kernel of `clearance_grid`; without early-out every cell is measured against every disc.

    Two early-outs: discs that are farther than the cap from every offset of a station are left out there;
    and known[s, l], a lower bound of a cell's clearance, less the farthest that any corner moves from it,
    bounds its neighbours: at the cap or above, they need not be measured. Clearances are measured a little
    beyond the cap, so that a bound can carry over more than one cell.
    """
    slots, stations, offsets = discs.shape[0], poses.shape[0], poses.shape[1]
    grid = np.empty((slots, stations, offsets))
    reach = math.hypot(max(front, rear), half)
    spare = 0.3 if early_out else 0.0
    along = np.full((stations, offsets), np.inf)
    aside = np.full((stations, offsets), np.inf)
    for i in range(stations):
        for j in range(offsets):
            if i:
                along[i, j] = _moved(poses[i - 1, j], poses[i, j], reach)
            if j:
                aside[i, j] = _moved(poses[i, j - 1], poses[i, j], reach)
    known = np.empty((stations, offsets))
    near = np.empty((discs.shape[1], 3))
    computed = 0
    for t in range(slots):
        for i in range(stations):
            low_x, high_x, low_y, high_y = np.inf, -np.inf, np.inf, -np.inf
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
                    # Once a station: what no offset of it can be within the cap of.
                    count = 0
                    for m in range(offsets):
                        low_x, high_x = min(low_x, poses[i, m, 0]), max(high_x, poses[i, m, 0])
                        low_y, high_y = min(low_y, poses[i, m, 1]), max(high_y, poses[i, m, 1])
                    for d in range(discs.shape[1]):
                        ex = max(low_x - discs[t, d, 0], discs[t, d, 0] - high_x, 0.0)
                        ey = max(low_y - discs[t, d, 1], discs[t, d, 1] - high_y, 0.0)
                        far = reach + discs[t, d, 2] + cap + spare
                        if ex * ex + ey * ey < far * far:
                            near[count] = discs[t, d]
                            count += 1
                x, y, yaw = poses[i, j]
                if early_out and count == 0:
                    known[i, j] = cap + spare
                    grid[t, i, j] = cap
                    continue
                seen = near[:count] if early_out else discs[t]
                value = pose_clearance(x, y, yaw, front, rear, half, seen, cap + spare)
                computed += 1
                known[i, j] = value
                grid[t, i, j] = min(value, cap)
    return grid, computed


@njit(cache=True)
def _moved(a: Array, b: Array, reach: float) -> float:
    """How far at most any point of the body moves between two poses."""
    turn = abs((b[2] - a[2] + math.pi) % (2.0 * math.pi) - math.pi)
    moved: float = math.hypot(b[0] - a[0], b[1] - a[1]) + reach * turn
    return moved
