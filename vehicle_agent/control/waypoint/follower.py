"""The waypoint follower: turns towards the waypoint two metres ahead (GEM, section IV)."""

import math

import msgspec
import numpy as np
from numba import njit

from contract.geometry import Array, Pose2, wrap_angle


class FollowerState(msgspec.Struct, frozen=True):
    """What the follower remembers: the integral of its heading error, in rad s."""

    integral_rads: float = 0.0


class WaypointFollower(msgspec.Struct, frozen=True):
    """omega = Kp theta, theta the heading error to the target waypoint.

    switch_m          the next waypoint is the target once the vehicle is this near to the current one
    aside_share       a vehicle beside its way aims at least this many times as far ahead, so that it comes
                      back at a slant: a waypoint 2 m off would lie across its way, or behind it
    heading_gain_1ps  Kp at `gain_speed_mps`. On a circle a waypoint L ahead is L / 2R off the heading, and
                      the vehicle must turn at v / R. Only Kp = 2 v / L holds the circle: about 2.4 at 3 m/s
                      and 2.5 m. The paper gives no Kp
    gain_speed_mps    Kp is proportional to speed; 0: the same at every speed, as in the paper
    heading_integral_1ps2  the integral term that the paper proposes against a constant heading error
    """

    switch_m: float = 2.0
    aside_share: float = 3.0
    heading_gain_1ps: float = 2.4
    gain_speed_mps: float = 3.0
    heading_integral_1ps2: float = 0.0
    integral_rads_max: float = 0.2
    dt_s: float = 0.02

    def step(
        self, state: FollowerState, pose_map: Pose2, speed_mps: float, points_map: Array
    ) -> tuple[float, float, FollowerState]:
        """(turn rate in rad/s, heading error in rad, state). points_map (n, 2): waypoints still ahead."""
        if len(points_map) == 0:
            return 0.0, 0.0, FollowerState()
        aside_m = distance_beside(points_map, pose_map.x_m, pose_map.y_m)
        reach_m = max(self.switch_m, self.aside_share * aside_m)
        target = target_waypoint(points_map, pose_map.x_m, pose_map.y_m, reach_m)
        x_m, y_m = points_map[target]
        bearing_rad = math.atan2(y_m - pose_map.y_m, x_m - pose_map.x_m)
        error_rad = float(wrap_angle(bearing_rad - pose_map.yaw_rad))
        gain_1ps = self.heading_gain_1ps
        if self.gain_speed_mps > 0.0:
            gain_1ps *= speed_mps / self.gain_speed_mps
        integral = state.integral_rads + error_rad * self.dt_s * (1.0 if speed_mps > 0.3 else 0.0)
        integral = min(max(integral, -self.integral_rads_max), self.integral_rads_max)
        return (
            gain_1ps * error_rad + self.heading_integral_1ps2 * integral,
            error_rad,
            FollowerState(integral),
        )


@njit(cache=True)
def distance_beside(points: Array, x_m: float, y_m: float) -> float:
    """How far (x, y) is from the straight line through the first two waypoints (n, 2); 0 with only one."""
    if points.shape[0] < 2:
        return 0.0
    dx_m, dy_m = points[1, 0] - points[0, 0], points[1, 1] - points[0, 1]
    length_m = math.hypot(dx_m, dy_m)
    if length_m < 1e-6:
        return 0.0
    across_m: float = (dx_m * (y_m - points[0, 1]) - dy_m * (x_m - points[0, 0])) / length_m
    return math.fabs(across_m)


@njit(cache=True)
def target_waypoint(points: Array, x_m: float, y_m: float, switch_m: float) -> int:
    """Index of the first waypoint (n, 2) that is not within switch_m; of the last one when all are."""
    n: int = points.shape[0]
    for i in range(n):
        if math.hypot(points[i, 0] - x_m, points[i, 1] - y_m) > switch_m:
            return i
    return n - 1


def predicted_pose(
    pose_map: Pose2, speed_mps: float, steers_rad: np.ndarray, wheelbase_m: float, dt_s: float
) -> Pose2:
    """The pose when a command of now takes effect.

    steers_rad  (k,) front-wheel angles over the actuators' delay, one every dt_s: commanded, not yet executed
    """
    return Pose2(
        *propagate_bicycle(
            pose_map.x_m, pose_map.y_m, pose_map.yaw_rad, speed_mps, steers_rad, wheelbase_m, dt_s
        )
    )


@njit(cache=True)
def propagate_bicycle(
    x_m: float, y_m: float, yaw_rad: float, speed_mps: float, steers: Array, wheelbase_m: float, dt_s: float
) -> tuple[float, float, float]:
    """(x, y, yaw) after driving the steering angles (k,), dt_s each; kinematic bicycle, midpoint rule."""
    for k in range(steers.shape[0]):
        turn = speed_mps * math.tan(steers[k]) / wheelbase_m * dt_s
        x_m += speed_mps * dt_s * math.cos(yaw_rad + 0.5 * turn)
        y_m += speed_mps * dt_s * math.sin(yaw_rad + 0.5 * turn)
        yaw_rad = wrap_angle(yaw_rad + turn)
    return x_m, y_m, yaw_rad
