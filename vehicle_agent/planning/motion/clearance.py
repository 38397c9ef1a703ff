"""Exact clearances between the vehicle's box and discs."""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from contract.geometry import Array

# Columns of a disc.
_X, _Y, _RADIUS = range(3)


class Box(NamedTuple):
    """The vehicle's outline about its rear-axle centre.

    A tuple, so that kernels take it as it is.
    """

    front_m: float
    rear_m: float
    half_width_m: float


class BoxPose(NamedTuple):
    """Where a box is: its rear-axle centre, and cosine and sine of its heading."""

    x_m: float
    y_m: float
    cos: float
    sin: float


@njit(cache=True)
def box_pose(pose: Array) -> BoxPose:
    """The box at a pose (3,) x, y, yaw."""
    return BoxPose(pose[0], pose[1], math.cos(pose[2]), math.sin(pose[2]))


@njit(cache=True)
def box_distance(at: BoxPose, box: Box, px: float, py: float) -> float:
    """Signed distance of the point (px, py) from the box; negative inside."""
    dx, dy = px - at.x_m, py - at.y_m
    ahead = at.cos * dx + at.sin * dy
    beyond_x = max(ahead - box.front_m, -box.rear_m - ahead)
    beyond_y = abs(-at.sin * dx + at.cos * dy) - box.half_width_m
    if beyond_x > 0.0 and beyond_y > 0.0:
        return math.sqrt(beyond_x * beyond_x + beyond_y * beyond_y)
    inside: float = max(beyond_x, beyond_y)
    return inside


@njit(cache=True)
def pose_clearance(pose: Array, box: Box, discs: Array, cap: float) -> float:
    """The least clearance of the box at one pose (3,) to the discs (m, 3), at most cap."""
    at = box_pose(pose)
    middle = 0.5 * (box.front_m - box.rear_m)
    cx, cy = at.x_m + middle * at.cos, at.y_m + middle * at.sin
    reach = math.hypot(0.5 * (box.front_m + box.rear_m), box.half_width_m)
    best = cap
    for i in range(discs.shape[0]):
        dx, dy = discs[i, _X] - cx, discs[i, _Y] - cy
        far = reach + discs[i, _RADIUS] + best
        if far <= 0.0 or dx * dx + dy * dy >= far * far:
            continue
        gap = box_distance(at, box, discs[i, _X], discs[i, _Y]) - discs[i, _RADIUS]
        best = min(best, gap)
    return best


@njit(cache=True)
def first_touch(poses: Array, box: Box, discs: Array, margin: float) -> tuple[int, bool]:
    """(index of the first pose (n, 3) that is nearer than the margin to a disc (m, 3), -1 for none;
    whether the first pose touches a disc).

    A disc behind the rear bumper at the start does not count. A disc that is nearer than the margin already
    may be driven away from, and past, but not towards.
    """
    allowed = np.empty(discs.shape[0])
    at = box_pose(poses[0])
    for k in range(discs.shape[0]):
        px, py = discs[k, _X], discs[k, _Y]
        now = box_distance(at, box, px, py) - discs[k, _RADIUS]
        if at.cos * (px - at.x_m) + at.sin * (py - at.y_m) < -box.rear_m:
            allowed[k] = -np.inf
        elif now < 0.0:
            return -1, True
        else:
            allowed[k] = min(margin, max(now - 0.02, 0.0))
    reach = math.hypot(max(box.front_m, box.rear_m), box.half_width_m) + margin
    for j in range(poses.shape[0]):
        at = box_pose(poses[j])
        for k in range(discs.shape[0]):
            dx, dy, far = discs[k, _X] - at.x_m, discs[k, _Y] - at.y_m, reach + discs[k, _RADIUS]
            if dx * dx + dy * dy > far * far:
                continue
            gap = box_distance(at, box, discs[k, _X], discs[k, _Y]) - discs[k, _RADIUS]
            if gap < allowed[k]:
                return j, False
    return -1, False
