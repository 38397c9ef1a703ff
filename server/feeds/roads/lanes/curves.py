"""Curves that a shuttle can drive from one pose to another: quintic turns, loops, side steps."""

import math

import numpy as np
from numba import njit

from contract.geometry import Array, arc_lengths, curvatures, resample, wrap_angle

SPACING_M = 0.75
_SAMPLES = 33
_HANDLES = 14


@njit(cache=True)
def _bezier_peak(control: Array, out: Array) -> float:
    """Fill out (n, 2) with points of the degree-5 Bezier curve and return its largest |curvature|."""
    n = out.shape[0]
    for k in range(n):
        t = k / (n - 1)
        u = 1.0 - t
        b0, b1, b2 = u**5, 5 * u**4 * t, 10 * u**3 * t * t
        b3, b4, b5 = 10 * u * u * t**3, 5 * u * t**4, t**5
        for c in range(2):
            out[k, c] = (
                b0 * control[0, c]
                + b1 * control[1, c]
                + b2 * control[2, c]
                + b3 * control[3, c]
                + b4 * control[4, c]
                + b5 * control[5, c]
            )
    peak = 0.0
    for k in range(1, n - 1):
        ax, ay = out[k, 0] - out[k - 1, 0], out[k, 1] - out[k - 1, 1]
        bx, by = out[k + 1, 0] - out[k, 0], out[k + 1, 1] - out[k, 1]
        # A step back is a cusp or a loop of the control polygon, whatever its curvature.
        if ax * bx + ay * by <= 0.0:
            return math.inf
        cx, cy = ax + bx, ay + by
        product = math.hypot(ax, ay) * math.hypot(bx, by) * math.hypot(cx, cy)
        peak = max(peak, abs(2.0 * (ax * by - ay * bx) / product))
    return peak


@njit(cache=True)
def _gentlest(
    start: Array, end: Array, curvature_start_1pm: float, curvature_end_1pm: float, best: Array
) -> float:
    """Search both handle lengths; fill best (n, 2) with the curve of the least peak, which is returned."""
    chord = math.hypot(end[0] - start[0], end[1] - start[1])
    t0x, t0y = math.cos(start[2]), math.sin(start[2])
    t1x, t1y = math.cos(end[2]), math.sin(end[2])
    control = np.empty((6, 2))
    trial = np.empty(best.shape)
    least = math.inf
    for i in range(_HANDLES):
        a = chord * (0.08 + 0.32 * i / (_HANDLES - 1))
        lift_a = 1.25 * curvature_start_1pm * a * a
        for j in range(_HANDLES):
            b = chord * (0.08 + 0.32 * j / (_HANDLES - 1))
            lift_b = 1.25 * curvature_end_1pm * b * b
            control[0, 0], control[0, 1] = start[0], start[1]
            control[1, 0], control[1, 1] = start[0] + a * t0x, start[1] + a * t0y
            control[2, 0] = start[0] + 2 * a * t0x - lift_a * t0y
            control[2, 1] = start[1] + 2 * a * t0y + lift_a * t0x
            control[3, 0] = end[0] - 2 * b * t1x - lift_b * t1y
            control[3, 1] = end[1] - 2 * b * t1y + lift_b * t1x
            control[4, 0], control[4, 1] = end[0] - b * t1x, end[1] - b * t1y
            control[5, 0], control[5, 1] = end[0], end[1]
            peak = _bezier_peak(control, trial)
            if peak < least:
                least = peak
                best[:] = trial
    return least


def connect(start: Array, end: Array, curvature_max_1pm: float) -> Array | None:
    """(n, 2) points from pose to pose, or None where none stays under the curvature.

    start, end  (x, y, yaw). The curve with no curvature at its ends is preferred; where that bends too
    sharply inside, some of the bend is allowed to begin at the ends.
    """
    ahead = end[:2] - start[:2]
    side = math.cos(start[2]) * ahead[1] - math.sin(start[2]) * ahead[0]
    turn = float(wrap_angle(float(end[2] - start[2])))
    sign = math.copysign(1.0, turn if abs(turn) > 0.3 else side)
    points = np.empty((_SAMPLES, 2))
    for share in (0.0, 0.35, 0.6, 0.8):
        bend = sign * share * curvature_max_1pm
        if _gentlest(start, end, bend, bend, points) <= curvature_max_1pm:
            fine: Array = resample(points, SPACING_M)
            return fine
    return None


def peak_curvature(points: Array) -> float:
    """The largest |curvature| (1/m) along (n, 2) points."""
    return float(np.max(np.abs(curvatures(points)))) if len(points) > 2 else 0.0


def end_poses(points: Array) -> tuple[Array, Array]:
    """The poses (x, y, yaw) at both ends of (n, 2) points, their headings corrected for the curve."""
    return _first_pose(points), _turned(_first_pose(points[::-1]))


def _first_pose(points: Array) -> Array:
    step = points[1] - points[0]
    yaw = math.atan2(step[1], step[0])
    if len(points) > 2:
        after = points[2] - points[1]
        bend = wrap_angle(math.atan2(after[1], after[0]) - yaw)
        yaw -= bend * math.hypot(*step) / (math.hypot(*step) + math.hypot(*after))
    return np.array([points[0, 0], points[0, 1], yaw])


def _turned(pose: Array) -> Array:
    return np.array([pose[0], pose[1], wrap_angle(pose[2] + math.pi)])


def offset(points: Array, left_m: Array | float) -> Array:
    """The line moved sideways by left_m, a number or (n,) values; (n, 2), same number of points."""
    tangent = np.gradient(points, axis=0)
    tangent /= np.hypot(tangent[:, 0], tangent[:, 1])[:, None]
    normal = np.column_stack((-tangent[:, 1], tangent[:, 0]))
    moved: Array = points + normal * np.broadcast_to(np.asarray(left_m, dtype=float), len(points))[:, None]
    return moved


def step_aside(length_m: Array, ramp_m: float, left_m: float) -> Array:
    """Offsets along s (n,): out over ramp_m, straight, back over ramp_m, without a jump in curvature."""
    total = length_m[-1]
    out = np.clip(np.minimum(length_m, total - length_m) / ramp_m, 0.0, 1.0)
    smooth: Array = left_m * out**3 * (10.0 - 15.0 * out + 6.0 * out**2)
    return smooth


def loop(start: Array, end: Array, radius_m: float, left_first: bool) -> Array | None:
    """(n, 2) points of the turning loop of three arcs (Dubins 1957, CCC) from pose to pose.

    left_first  swing left, go round to the right, swing left; else mirrored. None where the poses are too
    far apart for it. The middle arc is the long one.
    """
    side = 1.0 if left_first else -1.0
    c0 = start[:2] + side * radius_m * np.array([-math.sin(start[2]), math.cos(start[2])])
    c1 = end[:2] + side * radius_m * np.array([-math.sin(end[2]), math.cos(end[2])])
    apart = c1 - c0
    distance = math.hypot(*apart)
    if distance > 4.0 * radius_m or distance < 1e-9:
        return None
    height = math.sqrt(4.0 * radius_m**2 - distance**2 / 4.0)
    normal = np.array([-apart[1], apart[0]]) / distance
    best: Array | None = None
    for way in (1.0, -1.0):
        middle = (c0 + c1) / 2.0 + way * height * normal
        arcs = _three_arcs(start, end, c0, middle, c1, side)
        if best is None or arc_lengths(arcs)[-1] < arc_lengths(best)[-1]:
            best = arcs
    return best


def _three_arcs(start: Array, end: Array, c0: Array, middle: Array, c1: Array, side: float) -> Array:
    first_touch, second_touch = (c0 + middle) / 2.0, (middle + c1) / 2.0
    pieces = (
        _arc(c0, start[:2], first_touch, side),
        _arc(middle, first_touch, second_touch, -side),
        _arc(c1, second_touch, end[:2], side),
    )
    joined: Array = np.vstack((pieces[0], pieces[1][1:], pieces[2][1:]))
    return joined


def _arc(centre: Array, begin: Array, end: Array, side: float) -> Array:
    """Points from begin to end around centre, counter-clockwise for side > 0."""
    a0 = math.atan2(*(begin - centre)[::-1])
    a1 = math.atan2(*(end - centre)[::-1])
    sweep = math.fmod(side * (a1 - a0), 2.0 * math.pi)
    if sweep < -1e-9:
        sweep += 2.0 * math.pi
    radius = math.hypot(*(begin - centre))
    count = max(2, math.ceil(radius * sweep / 0.25) + 1)
    angles = a0 + side * np.linspace(0.0, sweep, count)
    points: Array = np.round(centre + radius * np.column_stack((np.cos(angles), np.sin(angles))), 6)
    points[0], points[-1] = begin, end
    return points
