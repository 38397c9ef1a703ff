"""Pure pursuit: steers the arc through the path's point a fixed distance ahead (NUS, section IV-B)."""

import math

import msgspec
from numba import njit

from contract.geometry import Array, Pose2, wrap_angle
from vehicle_agent.control.waypoint.follower import FollowerState


class PurePursuit(msgspec.Struct, frozen=True):
    """kappa = 2 sin(alpha) / look-ahead, alpha the bearing of the point (Coulter 1992, eq. 10).

    look_ahead_m  3 m, fixed; sufficient up to 2 m/s
    Replaces the follower in `WaypointControl`. It has no state.
    """

    look_ahead_m: float = 3.0

    def step(
        self, state: FollowerState, pose_map: Pose2, speed_mps: float, points_map: Array
    ) -> tuple[float, float, FollowerState]:
        """(turn rate in rad/s, bearing of the point in rad, state). points_map (n, 2): path still ahead."""
        if len(points_map) == 0:
            return 0.0, 0.0, state
        x_m, y_m = look_ahead_point(points_map, pose_map.x_m, pose_map.y_m, self.look_ahead_m)
        dx_m, dy_m = x_m - pose_map.x_m, y_m - pose_map.y_m
        bearing_rad = float(wrap_angle(math.atan2(dy_m, dx_m) - pose_map.yaw_rad))
        distance_m = max(math.hypot(dx_m, dy_m), 0.5 * self.look_ahead_m)
        return speed_mps * 2.0 * math.sin(bearing_rad) / distance_m, bearing_rad, state


@njit(cache=True)
def look_ahead_point(points: Array, x_m: float, y_m: float, look_ahead_m: float) -> tuple[float, float]:
    """The point where the path (n, 2) leaves the circle about (x, y); its last point if it stays inside."""
    n = points.shape[0]
    previous_m = math.hypot(points[0, 0] - x_m, points[0, 1] - y_m)
    if previous_m >= look_ahead_m:
        return points[0, 0], points[0, 1]
    for i in range(1, n):
        distance_here_m = math.hypot(points[i, 0] - x_m, points[i, 1] - y_m)
        if distance_here_m >= look_ahead_m:
            bx, by = points[i, 0] - points[i - 1, 0], points[i, 1] - points[i - 1, 1]
            ax, ay = points[i - 1, 0] - x_m, points[i - 1, 1] - y_m
            # |a + t b| = look-ahead, the root on this segment
            qa, qb, qc = bx * bx + by * by, ax * bx + ay * by, ax * ax + ay * ay - look_ahead_m**2
            t = (-qb + math.sqrt(max(0.0, qb * qb - qa * qc))) / qa
            return points[i - 1, 0] + t * bx, points[i - 1, 1] + t * by
    return points[n - 1, 0], points[n - 1, 1]
