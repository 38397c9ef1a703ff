"""Planar poses and polylines.

Axes follow REP-103: x forward (east in the map frame), y left (north), yaw counter-clockwise from x.
"""

import math
from typing import Annotated

import msgspec
import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

TWO_PI = 2.0 * math.pi
# Farther from its origin no map reaches.
POSITION_M_MAX = 1e6


class Pose2(msgspec.Struct, frozen=True, array_like=True):
    """A planar pose; the name of the variable that holds it says in which frame (`pose_map`).

    Decoding refuses values that no campus has. In the process they are not checked.
    """

    x_m: Annotated[float, msgspec.Meta(ge=-POSITION_M_MAX, le=POSITION_M_MAX)]
    y_m: Annotated[float, msgspec.Meta(ge=-POSITION_M_MAX, le=POSITION_M_MAX)]
    yaw_rad: Annotated[float, msgspec.Meta(ge=-10.0, le=10.0)]


@njit(cache=True)
def wrap_angle(angle_rad: float) -> float:
    """The same direction in (-pi, pi]."""
    wrapped = angle_rad % TWO_PI
    if wrapped > math.pi:
        wrapped -= TWO_PI
    return wrapped


def compose(T_a_b: Pose2, T_b_c: Pose2) -> Pose2:
    """T_a_c: where c is in a, given b in a and c in b."""
    cos, sin = math.cos(T_a_b.yaw_rad), math.sin(T_a_b.yaw_rad)
    return Pose2(
        T_a_b.x_m + cos * T_b_c.x_m - sin * T_b_c.y_m,
        T_a_b.y_m + sin * T_b_c.x_m + cos * T_b_c.y_m,
        wrap_angle(T_a_b.yaw_rad + T_b_c.yaw_rad),
    )


def inverse(T_a_b: Pose2) -> Pose2:
    """T_b_a."""
    cos, sin = math.cos(T_a_b.yaw_rad), math.sin(T_a_b.yaw_rad)
    return Pose2(
        -cos * T_a_b.x_m - sin * T_a_b.y_m,
        sin * T_a_b.x_m - cos * T_a_b.y_m,
        wrap_angle(-T_a_b.yaw_rad),
    )


def transform_points(T_a_b: Pose2, points_b: Array) -> Array:
    """(n, 2) points given in b, as points in a."""
    cos, sin = math.cos(T_a_b.yaw_rad), math.sin(T_a_b.yaw_rad)
    rotation = np.array([[cos, sin], [-sin, cos]])
    moved: Array = points_b @ rotation + np.array([T_a_b.x_m, T_a_b.y_m])
    return moved


@njit(cache=True)
def arc_lengths(points: Array) -> Array:
    """(n,) distance along the (n, 2) polyline up to each of its points, starting at 0."""
    n = points.shape[0]
    s = np.zeros(n)
    for i in range(1, n):
        s[i] = s[i - 1] + math.hypot(points[i, 0] - points[i - 1, 0], points[i, 1] - points[i - 1, 1])
    return s


@njit(cache=True)
def project(
    points: Array, s: Array, x_m: float, y_m: float, first: int, last: int
) -> tuple[float, float, int]:
    """The polyline's nearest point to (x, y), among segments first..last-1 only.

    points (n, 2), s (n,) from `arc_lengths`; first, last clipped to [0, n - 1].
    Returns (s_m, d_m, segment): d is positive to the left of the direction of travel.
    """
    n = points.shape[0]
    first = max(0, min(first, n - 2))
    last = max(first + 1, min(last, n - 1))
    best2 = np.inf
    best_s, best_d, best_i = s[first], 0.0, first
    for i in range(first, last):
        ax, ay = points[i, 0], points[i, 1]
        bx, by = points[i + 1, 0] - ax, points[i + 1, 1] - ay
        px, py = x_m - ax, y_m - ay
        length2 = bx * bx + by * by
        if length2 == 0.0:
            continue
        t = min(1.0, max(0.0, (px * bx + py * by) / length2))
        ex, ey = px - t * bx, py - t * by
        distance2 = ex * ex + ey * ey
        if distance2 < best2:
            best2 = distance2
            length = math.sqrt(length2)
            best_s = s[i] + t * length
            side = bx * py - by * px
            best_d = math.copysign(math.sqrt(distance2), side)
            best_i = i
    return best_s, best_d, best_i


@njit(cache=True)
def pose_at(points: Array, s: Array, query_m: float) -> tuple[float, float, float]:
    """(x, y, yaw) on the polyline at arc length query_m, clamped to its ends."""
    n = points.shape[0]
    query_m = min(max(query_m, s[0]), s[n - 1])
    i = min(max(np.searchsorted(s, query_m, side="right") - 1, 0), n - 2)
    # The last point may stand there more than once.
    while i > 0 and s[i + 1] == s[i]:
        i -= 1
    dx, dy = points[i + 1, 0] - points[i, 0], points[i + 1, 1] - points[i, 1]
    length = math.hypot(dx, dy)
    t = 0.0 if length == 0.0 else (query_m - s[i]) / length
    return points[i, 0] + t * dx, points[i, 1] + t * dy, math.atan2(dy, dx)


@njit(cache=True)
def curvatures(points: Array) -> Array:
    """(n,) signed Menger curvature (1/m, left positive) at each point; the ends repeat their neighbour."""
    n = points.shape[0]
    kappa = np.zeros(n)
    for i in range(1, n - 1):
        ax, ay = points[i, 0] - points[i - 1, 0], points[i, 1] - points[i - 1, 1]
        bx, by = points[i + 1, 0] - points[i, 0], points[i + 1, 1] - points[i, 1]
        cx, cy = ax + bx, ay + by
        product = math.hypot(ax, ay) * math.hypot(bx, by) * math.hypot(cx, cy)
        if product > 0.0:
            kappa[i] = 2.0 * (ax * by - ay * bx) / product
    if n > 2:
        kappa[0], kappa[n - 1] = kappa[1], kappa[n - 2]
    return kappa


@njit(cache=True)
def resample(points: Array, spacing_m: float) -> Array:
    """The polyline with evenly spaced points, at most spacing_m apart, ends kept."""
    s = arc_lengths(points)
    total = s[-1]
    count = max(2, math.ceil(total / spacing_m) + 1)
    out = np.empty((count, 2))
    for k in range(count):
        x, y, _ = pose_at(points, s, total * k / (count - 1))
        out[k, 0], out[k, 1] = x, y
    return out
