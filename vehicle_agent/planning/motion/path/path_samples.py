"""A path, sampled: poses and curvature by s and by the way u along it; exact at every sample."""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from contract.geometry import Array
from vehicle_agent.planning.motion.path.frame import Line, frame_at, pose_from_offset
from vehicle_agent.planning.motion.path.gp_path import SolvedPath
from vehicle_agent.planning.motion.path.gp_prior import states_between


class PathSamples(NamedTuple):
    """The path at even steps of s; a tuple, so that kernels take it as it is.

    s_m, u_m       (n,) station on the line, and way along the path; stretch (n,) du/ds
    poses_map      (n, 3) with continuous yaw
    curvature_1pm  (n,) and its change per metre of way
    """

    s_m: Array
    u_m: Array
    stretch: Array
    poses_map: Array
    curvature_1pm: Array
    curvature_slope_1pm2: Array

    def s_at(self, u_m: Array) -> Array:
        """(m,) s at the way u_m (m,), to a tenth of a millimetre (cubic Hermite of the inverse)."""
        s: Array = inverse_way(self.s_m, self.u_m, self.stretch, u_m)
        return s


def sample_path(line: Line, path: SolvedPath, spacing_m: float) -> PathSamples:
    """The path from its first support to its last."""
    length_m = path.step_m * (len(path.states) - 1)
    count = max(8, math.ceil(length_m / spacing_m) + 1)
    s = path.first_m + length_m * np.arange(count) / (count - 1)
    u, stretch, poses, curvature = sampled(
        line.control_map, line.first_m, line.step_m, path.states, path.first_m, path.step_m, s
    )
    return PathSamples(s, u, stretch, poses, curvature, np.gradient(curvature, u))


def poses_at(line: Line, path: SolvedPath, s_m: Array) -> tuple[Array, Array]:
    """((m, 3) poses with continuous yaw, (m,) curvature) at s_m (m,), evaluated on the path itself."""
    _, _, poses, curvature = sampled(
        line.control_map, line.first_m, line.step_m, path.states, path.first_m, path.step_m, s_m
    )
    return poses, curvature


@njit(cache=True)
def _pace(
    control: Array, first: float, step: float, x: Array, x_first: float, x_step: float, s: float
) -> float:
    """du/ds at s."""
    frame = np.empty(7)
    frame_at(control, first, step, s, frame)
    at = np.empty(1)
    at[0] = s
    state = states_between(x, x_step, x_first, at)[0]
    return math.hypot(frame[3] * (1.0 - frame[5] * state[0]), state[1])


@njit(cache=True)
def sampled(
    control: Array, first: float, step: float, x: Array, x_first: float, x_step: float, s: Array
) -> tuple[Array, Array, Array, Array]:
    """(u, du/ds, poses, curvature) at s (n,); u by Gauss-Legendre with three points a piece."""
    n = s.shape[0]
    u, stretch, poses, curvature = np.zeros(n), np.empty(n), np.empty((n, 3)), np.empty(n)
    states = states_between(x, x_step, x_first, s)
    frame = np.empty(7)
    node = math.sqrt(0.6)
    for i in range(n):
        frame_at(control, first, step, s[i], frame)
        l0, l1, l2 = states[i]
        px, py, yaw, kappa = pose_from_offset(frame, l0, l1, l2)
        stretch[i] = math.hypot(frame[3] * (1.0 - frame[5] * l0), l1)
        poses[i, 0], poses[i, 1], poses[i, 2], curvature[i] = px, py, yaw, kappa
        if i:
            turn = (yaw - poses[i - 1, 2] + math.pi) % (2.0 * math.pi) - math.pi
            poses[i, 2] = poses[i - 1, 2] + turn
            half = 0.5 * (s[i] - s[i - 1])
            middle = s[i - 1] + half
            total = 8.0 * _pace(control, first, step, x, x_first, x_step, middle)
            total += 5.0 * _pace(control, first, step, x, x_first, x_step, middle - half * node)
            total += 5.0 * _pace(control, first, step, x, x_first, x_step, middle + half * node)
            u[i] = u[i - 1] + half * total / 9.0
    return u, stretch, poses, curvature


@njit(cache=True)
def inverse_way(s: Array, u: Array, stretch: Array, at: Array) -> Array:
    """(m,) s at the way `at` (m,), clipped to the samples."""
    out = np.empty(at.shape[0])
    last = s.shape[0] - 2
    for k in range(at.shape[0]):
        q = min(max(at[k], u[0]), u[-1])
        i = min(max(np.searchsorted(u, q, side="right") - 1, 0), last)
        d = u[i + 1] - u[i]
        t = (q - u[i]) / d
        m0, m1 = d / stretch[i], d / stretch[i + 1]
        t2, t3 = t * t, t * t * t
        out[k] = (
            (2.0 * t3 - 3.0 * t2 + 1.0) * s[i]
            + (t3 - 2.0 * t2 + t) * m0
            + (-2.0 * t3 + 3.0 * t2) * s[i + 1]
            + (t3 - t2) * m1
        )
    return out
