"""Trajectory rows: a speed along a path, and the stops that are always possible."""

import math

import numpy as np

from contract.geometry import Array
from vehicle_agent.planning.motion.path.frame import Line
from vehicle_agent.planning.motion.path.gp_path import SolvedPath
from vehicle_agent.planning.motion.path.path_samples import PathSamples, poses_at
from vehicle_agent.planning.motion.request import DrivingLimits, StartState
from vehicle_agent.planning.motion.speed.speed_qp import SpeedPlan, brake_envelope

_AFTER_REST_S = 0.5


def profile_from_plan(plan: SpeedPlan, row_s: float) -> Array:
    """(k, 4) t, u, v, a of a plan every row_s; a vehicle that would roll back stands instead."""
    count = round(plan.dt_s * len(plan.jerk_mps3) / row_s)
    t = row_s * np.arange(count + 1)
    piece = np.minimum((t / plan.dt_s + 1e-9).astype(np.int64), len(plan.jerk_mps3) - 1)
    h = t - piece * plan.dt_s
    a0, v0, j = plan.a_mps2[piece], plan.v_mps[piece], plan.jerk_mps3[piece]
    a = a0 + j * h
    v = v0 + a0 * h + 0.5 * j * h**2
    # A vehicle that sets off has no speed yet, but an acceleration that the next plan continues.
    still = (v <= 0.01) & (a <= 0.0)
    v, a = np.where(still, 0.0, np.maximum(v, 0.0)), np.where(still, 0.0, a)
    # The way is integrated from the remaining speed, so that the rows are consistent.
    bend = np.where(still[1:] | still[:-1], 0.0, np.diff(a)) * row_s**2 / 12.0
    u = np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * row_s - bend)])
    return np.stack([t, u, v, a], axis=1)


def stopping(start: StartState, decel_mps2: float, jerk_mps3: float, row_s: float, horizon_s: float) -> Array:
    """(k, 4) t, u, v, a of braking at once with this deceleration, to rest."""
    count = round(horizon_s / row_s)
    speed = max(start.speed_mps, 0.0)
    accel = start.accel_mps2 if speed > 0.05 else 0.0
    braked = brake_envelope(speed, accel, decel_mps2, jerk_mps3, row_s, count)
    return np.column_stack([row_s * np.arange(count + 1), braked])


def until_rest(profile: Array) -> Array:
    """The profile without the standing at its end, but for the first half second of it; at least two rows."""
    moving = np.flatnonzero(profile[:, 2] > 0.0)
    last = moving[-1] + 1 if len(moving) else 0
    row_s = profile[1, 0] - profile[0, 0]
    return profile[: max(last + 1 + round(_AFTER_REST_S / row_s), 2)]


def rows_on_path(profile: Array, samples: PathSamples, line: Line, path: SolvedPath) -> Array:
    """(k, 8) trajectory rows, exact on the path."""
    u = np.minimum(profile[:, 1], samples.u_m[-1])
    s = samples.s_at(u)
    poses, curvature = poses_at(line, path, s)
    return np.column_stack([profile[:, 0], poses, curvature, profile[:, 2], profile[:, 3], s])


def rows_on_arc(profile: Array, start: StartState, curvature_1pm_max: float, s_m: float) -> Array:
    """(k, 8) rows along the circle that the vehicle is steering now: for a start that no path leads from."""
    kappa = min(max(start.curvature_1pm, -curvature_1pm_max), curvature_1pm_max)
    u, pose = profile[:, 1], start.pose_map
    half = 0.5 * u * kappa
    chord = u * np.sinc(half / math.pi)
    x = pose.x_m + chord * np.cos(pose.yaw_rad + half)
    y = pose.y_m + chord * np.sin(pose.yaw_rad + half)
    yaw = pose.yaw_rad + 2.0 * half
    return np.column_stack(
        [profile[:, 0], x, y, yaw, np.full(len(u), kappa), profile[:, 2], profile[:, 3], s_m + u]
    )


def stop_profiles(
    start: StartState, limits: DrivingLimits, row_s: float, horizon_s: float
) -> tuple[tuple[str, Array], ...]:
    """("stop" | "emergency", profile) from the mildest to the hardest."""
    ordinary = limits.jerk_mps3_max
    return (
        ("stop", stopping(start, limits.decel_mps2_comfort, ordinary, row_s, horizon_s)),
        ("stop", stopping(start, limits.decel_mps2_max, ordinary, row_s, horizon_s)),
        ("emergency", stopping(start, 0.5 * limits.hard_decel_mps2, limits.hard_jerk_mps3, row_s, horizon_s)),
        ("emergency", stopping(start, limits.hard_decel_mps2, limits.hard_jerk_mps3, row_s, horizon_s)),
    )
