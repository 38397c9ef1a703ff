"""The closest obstacle on the swept path, and the speed it leaves (GEM, section V)."""

import math

import msgspec
import numpy as np
from numba import njit

from contract.geometry import Array, Pose2, pose_at, wrap_angle
from vehicle_agent.planning.waypoint.selector import SpeedCommand

_STEP_M = 0.5


class ObstacleRule(msgspec.Struct, frozen=True):
    """v = d / 5 - 1; below 5 m, a stop at the hardest deceleration.

    clearance_m        by which the swept body is widened on each side
    side_clearance_m   the same for points alongside the vehicle already, which it would only graze
    check_m_fixed      how far the path is checked; 0 means 5 (v + 1), where the rule reaches the speed v
    along              "line": sweep the route ahead, and the present steering arc for `arc_m`;
                       "arc": the present steering arc alone, as in the paper
    low_clearance_m    clearance to kerbs: the body may pass beside them, and its wheels must not meet them
    passing_*          speed past obstacles beside the path
    """

    body_front_m: float
    body_back_m: float
    body_half_width_m: float
    wheelbase_m: float
    distance_per_speed_s: float = 5.0
    offset_mps: float = 1.0
    stop_m: float = 5.0
    clearance_m: float = 0.4
    side_clearance_m: float = 0.15
    low_clearance_m: float = 0.05
    check_m_fixed: float = 0.0
    along: str = "line"
    arc_m: float = 2.0
    arc_time_s: float = 0.8
    passing_clearance_m: float = 1.0
    passing_mps: float = 1.8
    passing_time_s: float = 2.5

    def check_m(self, speed_mps: float) -> float:
        """How far ahead of the bumper the path is checked."""
        if self.check_m_fixed > 0.0:
            return self.check_m_fixed
        return self.distance_per_speed_s * (speed_mps + self.offset_mps)

    def allowed_mps(self, obstacle_m: float) -> float:
        """v = d / 5 - 1, but 0 within 5 m (GEM, section V; the lost fraction bar restored)."""
        if obstacle_m < self.stop_m:
            return 0.0
        return max(0.0, obstacle_m / self.distance_per_speed_s - self.offset_mps)

    def command(self, obstacle_m: float) -> SpeedCommand | None:
        """The speed for an obstacle this far from the bumper (inf: none)."""
        if math.isinf(obstacle_m):
            return None
        allowed_mps = self.allowed_mps(obstacle_m)
        slope_mps2 = -allowed_mps / self.distance_per_speed_s
        return SpeedCommand("obstacle", allowed_mps, slope_mps2, emergency=obstacle_m < self.stop_m)

    def free_m(self, points_map: Array, sweep: "Sweep", clearance_m: float) -> float:
        """How far the bumper can move before the body, widened by the clearance, covers a point.

        inf: it never does.
        """
        return float(
            first_contact(
                points_map,
                sweep.poses,
                sweep.travelled_m,
                self.body_front_m,
                self.body_back_m,
                self.body_half_width_m,
                clearance_m,
                self.side_clearance_m,
            )
        )


class Sweep(msgspec.Struct, frozen=True):
    """poses (k, 3) of the base along a path and travelled_m (k,) to each; the first is here and now."""

    poses: np.ndarray
    travelled_m: np.ndarray


def sweep_line(points: Array, s: Array, s_m: float, d_m: float, length_m: float) -> Sweep:
    """Along a line (points (n, 2), s (n,)) from s_m, the present offset d_m to its left dying out."""
    return Sweep(*poses_on_line(points, s, s_m, d_m, length_m, _STEP_M))


def sweep_arc(pose_map: Pose2, steer_rad: float, wheelbase_m: float, length_m: float) -> Sweep:
    """Along the circle that the present steering angle makes (bicycle model)."""
    curvature_1pm = math.tan(steer_rad) / wheelbase_m
    return Sweep(
        *poses_on_arc(pose_map.x_m, pose_map.y_m, pose_map.yaw_rad, curvature_1pm, length_m, _STEP_M)
    )


@njit(cache=True)
def poses_on_line(
    points: Array, s: Array, s_m: float, d_m: float, length_m: float, step_m: float
) -> tuple[Array, Array]:
    """((k, 3), (k,)) base poses along the line and the distance to each; straight on beyond its end."""
    count = math.ceil(length_m / step_m) + 1
    poses = np.empty((count, 3))
    travelled = np.empty(count)
    end = s[-1]
    for k in range(count):
        q = k * step_m
        x, y, yaw = pose_at(points, s, s_m + q)
        beyond = max(0.0, s_m + q - end)
        aside = d_m * max(0.0, 1.0 - q / 8.0)
        poses[k, 0] = x + beyond * math.cos(yaw) - aside * math.sin(yaw)
        poses[k, 1] = y + beyond * math.sin(yaw) + aside * math.cos(yaw)
        poses[k, 2] = yaw
        travelled[k] = q
    return poses, travelled


@njit(cache=True)
def poses_on_arc(
    x_m: float, y_m: float, yaw_rad: float, curvature_1pm: float, length_m: float, step_m: float
) -> tuple[Array, Array]:
    """((k, 3), (k,)) base poses along a circle from the given pose and the distance to each."""
    count = math.ceil(length_m / step_m) + 1
    poses = np.empty((count, 3))
    travelled = np.empty(count)
    for k in range(count):
        q = k * step_m
        half = 0.5 * q * curvature_1pm
        chord = q if abs(half) < 1e-9 else q * math.sin(half) / half
        poses[k, 0] = x_m + chord * math.cos(yaw_rad + half)
        poses[k, 1] = y_m + chord * math.sin(yaw_rad + half)
        poses[k, 2] = wrap_angle(yaw_rad + 2.0 * half)
        travelled[k] = q
    return poses, travelled


@njit(cache=True)
def first_contact(
    points: Array,
    poses: Array,
    travelled: Array,
    front: float,
    back: float,
    half_width: float,
    clearance: float,
    side_clearance: float,
) -> float:
    """The travel at which the widened body first covers one of the (n, 2) points; inf when it never does."""
    nearest = np.inf
    cos, sin = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    for p in range(points.shape[0]):
        px, py = points[p, 0], points[p, 1]
        dx, dy = px - poses[0, 0], py - poses[0, 1]
        x = cos[0] * dx + sin[0] * dy
        y = -sin[0] * dx + cos[0] * dy
        beside = -back <= x <= front and abs(y) > half_width
        reach = half_width + (min(side_clearance, clearance) if beside else clearance)
        for k in range(poses.shape[0]):
            if travelled[k] - _STEP_M >= nearest:
                break
            dx, dy = px - poses[k, 0], py - poses[k, 1]
            x = cos[k] * dx + sin[k] * dy
            if x < -back or x > front:
                continue
            y = -sin[k] * dx + cos[k] * dy
            if abs(y) > reach:
                continue
            # Sweep steps are coarse: the bumper met the point a little before this pose.
            before = travelled[k - 1] if k > 0 else 0.0
            nearest = min(nearest, max(before, travelled[k] - (front - x)))
            break
    return nearest
