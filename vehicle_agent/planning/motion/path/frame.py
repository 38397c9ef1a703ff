"""The Frenet frame on the reference line: (s, l, l', l'') <-> (x, y, yaw, curvature), exact.

The task's line is a polyline, so its curvature is all in its corners. The frame is laid on a uniform quintic
B-spline r(s) fitted to it (C4; third differences of the control points are penalised), which keeps the
parameter s of the task's line. |r'| is therefore near 1 but not 1, and every formula carries it as sigma.
A path is p(s) = r(s) + l(s) n(s), and with A = sigma (1 - kappa l), b = sigma kappa:

    p' = A t + l' n,    p'' = (A' - b l') t + (A b + l'') n

from which yaw and curvature follow without approximation.
"""

import math
from typing import NamedTuple

import msgspec
import numpy as np
from numba import njit

from contract.geometry import Array, wrap_angle
from vehicle_agent.planning.motion.path.banded import factorize, solve

Row6 = tuple[float, float, float, float, float, float]

# Columns of a frame: the line at one s.
X, Y, THETA, SIGMA, SIGMA_1, KAPPA, KAPPA_1 = range(7)


class Frame(NamedTuple):
    """The line at one s: place, direction, sigma = |r'| and curvature with their slopes along s."""

    x: float
    y: float
    theta: float
    sigma: float
    sigma_1: float
    kappa: float
    kappa_1: float


class LineFolds(Exception):
    """No frame can be laid on the line here: it doubles back, is too sharp, or is too short."""


class Line(msgspec.Struct, frozen=True):
    """A smooth reference line; control (n + 4, 2) of n stations at first_m + i step_m, map frame."""

    first_m: float
    step_m: float
    control_map: np.ndarray

    @property
    def last_m(self) -> float:
        return float(self.first_m + self.step_m * (self.control_map.shape[0] - 5))

    def frames(self, s_m: Array) -> Array:
        """(m, 7) frames (columns above) at s_m (m,), clipped to the line's ends."""
        frames: Array = frames_at(self.control_map, self.first_m, self.step_m, np.ascontiguousarray(s_m))
        return frames


def fit_line(s_m: Array, points_map: Array, smoothing_m: float) -> Line:
    """The smooth line through a polyline at even steps; wiggles much shorter than 6 smoothing_m vanish.

    s_m (n,), points_map (n, 2), n >= 6. Raises LineFolds when there are fewer points.
    """
    if len(s_m) < 6:
        raise LineFolds("fewer than 6 stations")
    step_m = float((s_m[-1] - s_m[0]) / (len(s_m) - 1))
    control: Array = fit_control(np.ascontiguousarray(points_map), (smoothing_m / step_m) ** 6)
    return Line(float(s_m[0]), step_m, control)


@njit(cache=True)
def fit_control(points: Array, penalty: float) -> Array:
    """(n + 4, 2) control points c: least |B c - p|^2 + penalty |D3 c|^2, as one band system."""
    n = points.shape[0]
    band = np.zeros((5, n + 4))
    right = np.zeros((2, n + 4))
    basis = np.array([1.0, 26.0, 66.0, 26.0, 1.0]) / 120.0
    third = np.array([-1.0, 3.0, -3.0, 1.0])
    for i in range(n):
        for a in range(5):
            right[0, i + a] += basis[a] * points[i, 0]
            right[1, i + a] += basis[a] * points[i, 1]
            for b in range(a, 5):
                band[b - a, i + a] += basis[a] * basis[b]
    for i in range(n + 1):
        for a in range(4):
            for b in range(a, 4):
                band[b - a, i + a] += penalty * third[a] * third[b]
    factorize(band)
    solve(band, right[0])
    solve(band, right[1])
    return right.T.copy()


@njit(cache=True, inline="always")
def _basis(t: float) -> tuple[Row6, Row6]:
    """Value and first derivative, both times 120, of the six basis functions at t in 0..1 of a span."""
    t2 = t * t
    t3, t4 = t2 * t, t2 * t2
    u = 1.0 - t
    u4 = (u * u) * (u * u)
    value = (
        u4 * u,
        5.0 * t4 * t - 20.0 * t4 + 20.0 * t3 + 20.0 * t2 - 50.0 * t + 26.0,
        -10.0 * t4 * t + 30.0 * t4 - 60.0 * t2 + 66.0,
        10.0 * t4 * t - 20.0 * t4 - 20.0 * t3 + 20.0 * t2 + 50.0 * t + 26.0,
        -5.0 * t4 * t + 5.0 * t4 + 10.0 * t3 + 10.0 * t2 + 5.0 * t + 1.0,
        t4 * t,
    )
    slope = (
        -5.0 * u4,
        25.0 * t4 - 80.0 * t3 + 60.0 * t2 + 40.0 * t - 50.0,
        -50.0 * t4 + 120.0 * t3 - 120.0 * t,
        50.0 * t4 - 80.0 * t3 - 60.0 * t2 + 40.0 * t + 50.0,
        -25.0 * t4 + 20.0 * t3 + 30.0 * t2 + 20.0 * t + 5.0,
        5.0 * t4,
    )
    return value, slope


@njit(cache=True, inline="always")
def _higher_basis(t: float) -> tuple[Row6, Row6]:
    """Second and third derivative, both times 120, of the six basis functions at t in 0..1 of a span."""
    t2 = t * t
    t3 = t2 * t
    u = 1.0 - t
    u2 = u * u
    second = (
        20.0 * u2 * u,
        100.0 * t3 - 240.0 * t2 + 120.0 * t + 40.0,
        -200.0 * t3 + 360.0 * t2 - 120.0,
        200.0 * t3 - 240.0 * t2 - 120.0 * t + 40.0,
        -100.0 * t3 + 60.0 * t2 + 60.0 * t + 20.0,
        20.0 * t3,
    )
    third = (
        -60.0 * u2,
        300.0 * t2 - 480.0 * t + 120.0,
        -600.0 * t2 + 720.0 * t,
        600.0 * t2 - 480.0 * t - 120.0,
        -300.0 * t2 + 120.0 * t + 60.0,
        60.0 * t2,
    )
    return second, third


@njit(cache=True)
def frame_at(control: Array, first: float, step: float, s: float, out: Array) -> None:
    """Fills one frame (7,) at s: place, direction, sigma = |r'| and curvature with their slopes along s."""
    spans = control.shape[0] - 5
    x = min(max((s - first) / step, 0.0), float(spans))
    i = min(int(x), spans - 1)
    b0, b1 = _basis(x - i)
    b2, b3 = _higher_basis(x - i)
    x0 = y0 = x1 = y1 = x2 = y2 = x3 = y3 = 0.0
    for k in range(6):
        cx, cy = control[i + k, 0], control[i + k, 1]
        x0 += b0[k] * cx
        y0 += b0[k] * cy
        x1 += b1[k] * cx
        y1 += b1[k] * cy
        x2 += b2[k] * cx
        y2 += b2[k] * cy
        x3 += b3[k] * cx
        y3 += b3[k] * cy
    n1, n2, n3 = 120.0 * step, 120.0 * step * step, 120.0 * step * step * step
    x1, y1, x2, y2, x3, y3 = x1 / n1, y1 / n1, x2 / n2, y2 / n2, x3 / n3, y3 / n3
    sigma = max(math.hypot(x1, y1), 1e-9)
    out[0], out[1] = x0 / 120.0, y0 / 120.0
    out[2] = math.atan2(y1, x1)
    out[3] = sigma
    out[4] = (x1 * x2 + y1 * y2) / sigma
    out[5] = (x1 * y2 - y1 * x2) / (sigma * sigma * sigma)
    out[6] = (x1 * y3 - y1 * x3) / (sigma * sigma * sigma) - 3.0 * out[5] * out[4] / sigma


@njit(cache=True)
def frames_at(control: Array, first: float, step: float, s: Array) -> Array:
    """(m, 7) frames at s (m,)."""
    out = np.empty((s.shape[0], 7))
    for i in range(s.shape[0]):
        frame_at(control, first, step, s[i], out[i])
    return out


@njit(cache=True)
def frame_row(frames: Array, j: int) -> Frame:
    """Row j of frames (m, 7)."""
    return Frame(
        frames[j, X],
        frames[j, Y],
        frames[j, THETA],
        frames[j, SIGMA],
        frames[j, SIGMA_1],
        frames[j, KAPPA],
        frames[j, KAPPA_1],
    )


@njit(cache=True)
def project_on(
    control: Array, first: float, step: float, x_m: float, y_m: float, from_m: float, to_m: float
) -> float:
    """The s of the line's nearest point to (x, y) within [from_m, to_m]: the nearest station, then Newton."""
    frame = np.empty(7)
    last = first + step * (control.shape[0] - 5)
    low, high = max(first, from_m), min(last, to_m)
    best, best2 = low, np.inf
    count = max(1, math.ceil((high - low) / step))
    for i in range(count + 1):
        s = low + (high - low) * i / count
        frame_at(control, first, step, s, frame)
        d2 = (x_m - frame[0]) ** 2 + (y_m - frame[1]) ** 2
        if d2 < best2:
            best2, best = d2, s
    s = float(best)
    for _ in range(30):
        frame_at(control, first, step, s, frame)
        cos, sin = math.cos(frame[2]), math.sin(frame[2])
        ex, ey = x_m - frame[0], y_m - frame[1]
        along, aside = ex * cos + ey * sin, -ex * sin + ey * cos
        # d/ds of the distance along the tangent: -sigma (1 - kappa l).
        slope = frame[3] * max(1.0 - frame[5] * aside, 0.1)
        move = min(max(along / slope, -step), step)
        s = min(max(s + move, low), high)
        if abs(move) < 1e-13:
            break
    return float(s)


@njit(cache=True)
def pose_from_offset(frame: Array, l0: float, l1: float, l2: float) -> tuple[float, float, float, float]:
    """(x, y, yaw, curvature) of a path with offset l and derivatives l', l'' along s, at one frame."""
    sigma, kappa = frame[3], frame[5]
    a = sigma * (1.0 - kappa * l0)
    a1 = frame[4] * (1.0 - kappa * l0) - sigma * (frame[6] * l0 + kappa * l1)
    d = a * a + l1 * l1
    root = math.sqrt(d)
    yaw = frame[2] + math.atan2(l1, a)
    curvature = sigma * kappa / root + (a * l2 - l1 * a1) / (d * root)
    return frame[0] - l0 * math.sin(frame[2]), frame[1] + l0 * math.cos(frame[2]), yaw, curvature


@njit(cache=True)
def offset_from_pose(
    frame: Array, x_m: float, y_m: float, yaw_rad: float, curvature_1pm: float
) -> tuple[float, float, float]:
    """(l, l', l''): the inverse of `pose_from_offset`, for a pose abreast of this frame."""
    sigma, kappa = frame[3], frame[5]
    l0 = -(x_m - frame[0]) * math.sin(frame[2]) + (y_m - frame[1]) * math.cos(frame[2])
    a = sigma * (1.0 - kappa * l0)
    b = sigma * kappa
    l1 = a * math.tan(wrap_angle(yaw_rad - frame[2]))
    a1 = frame[4] * (1.0 - kappa * l0) - sigma * (frame[6] * l0 + kappa * l1)
    d = a * a + l1 * l1
    l2 = (curvature_1pm * d * math.sqrt(d) - b * d + l1 * a1) / a
    return l0, l1, l2
