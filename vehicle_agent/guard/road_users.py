"""Road users and obstacle cells around the vehicle, as the rows that `imminence` works on."""

import math

import numpy as np
from numba import njit

from contract.geometry import Array, Pose2, inverse, transform_points
from vehicle_agent.signals import PEDESTRIAN, VEHICLE, FleetVehicle, Tracks

# Columns of a row, base frame: position, velocity over ground, radius, hardest braking, lateral acceleration.
X, Y, VX, VY, RADIUS, BRAKE, SWERVE = range(7)
COLUMNS = 7
# Reasonable worst case (after RSS and IEEE 2846): how hard a road user may brake, and how fast they may
# leave their straight path, m/s2. By kind: pedestrian, cyclist, vehicle, other.
BRAKES_MPS2 = np.array([3.0, 4.0, 7.0, 3.0])
SWERVES_MPS2 = np.array([0.5, 0.5, 0.2, 0.5])
_EDGE_M = 0.4
_AGE_S_MAX = 1.0


def rows_of_points(points_map: Array, pose_map: Pose2, within_m: float) -> Array:
    """(n, 7) rows of the obstacle cells (m, 2) within within_m; they are stationary."""
    if len(points_map) == 0:
        return np.empty((0, COLUMNS))
    near = np.abs(points_map - np.array([pose_map.x_m, pose_map.y_m])).max(axis=1) <= within_m
    rows = np.zeros((int(near.sum()), COLUMNS))
    rows[:, :2] = transform_points(inverse(pose_map), points_map[near])
    return rows


def rows_of_tracks(tracks: Tracks, pose_map: Pose2, now_ns: int, within_m: float) -> Array:
    """(n, 7) rows of the tracks within within_m, extrapolated from their stamp to now.

    A person is a disc. Any other road user is the points of its outline, all with its velocity.
    """
    if len(tracks.ids) == 0:
        return np.empty((0, COLUMNS))
    age_s = min(max((now_ns - tracks.stamp_ns) * 1e-9, 0.0), _AGE_S_MAX)
    poses = tracks.poses_map.copy()
    poses[:, :2] += age_s * tracks.velocities_map_mps
    centre = np.array([pose_map.x_m, pose_map.y_m])
    reach_m = within_m + tracks.sizes_m.max(axis=1)
    near = np.abs(poses[:, :2] - centre).max(axis=1) <= reach_m
    return _rows(
        poses[near],
        tracks.velocities_map_mps[near],
        tracks.sizes_m[near],
        tracks.kinds[near],
        (pose_map.x_m, pose_map.y_m, pose_map.yaw_rad),
    )


def rows_of_fleet_vehicles(
    fleet_vehicles: tuple[FleetVehicle, ...], pose_map: Pose2, now_ns: int, body: tuple[float, float, float]
) -> Array:
    """(n, 7) rows of fleet vehicles, which have our own body (back, front, half width).

    Their reported speed is taken along their heading.
    """
    rows = [np.empty((0, COLUMNS))]
    back_m, front_m, half_m = body
    for vehicle in fleet_vehicles:
        age_s = min(max((now_ns - vehicle.stamp_ns) * 1e-9, 0.0), _AGE_S_MAX)
        yaw = vehicle.pose_map.yaw_rad
        along = np.array([[math.cos(yaw), math.sin(yaw)]])
        middle = np.array([[vehicle.pose_map.x_m, vehicle.pose_map.y_m]])
        middle = middle + (0.5 * (front_m - back_m) + age_s * vehicle.speed_mps) * along
        rows.append(
            _rows(
                np.column_stack((middle, [[yaw]])),
                vehicle.speed_mps * along,
                np.array([[front_m + back_m, 2.0 * half_m]]),
                np.array([VEHICLE]),
                (pose_map.x_m, pose_map.y_m, pose_map.yaw_rad),
            )
        )
    return np.vstack(rows)


@njit(cache=True)
def _rows(
    poses_map: Array,
    velocities_mps: Array,
    sizes_m: Array,
    kinds: np.ndarray,
    ego: tuple[float, float, float],
) -> Array:
    count = 0
    for i in range(poses_map.shape[0]):
        count += 1 if kinds[i] == PEDESTRIAN else _outline_points(sizes_m[i])
    rows = np.empty((count, COLUMNS))
    cos, sin = math.cos(ego[2]), math.sin(ego[2])
    k = 0
    for i in range(poses_map.shape[0]):
        dx, dy = poses_map[i, 0] - ego[0], poses_map[i, 1] - ego[1]
        x, y = cos * dx + sin * dy, cos * dy - sin * dx
        vx = cos * velocities_mps[i, 0] + sin * velocities_mps[i, 1]
        vy = cos * velocities_mps[i, 1] - sin * velocities_mps[i, 0]
        kind = min(max(kinds[i], 0), 3)
        n = 1 if kind == PEDESTRIAN else _outline_points(sizes_m[i])
        for j in range(n):
            px, py, radius = x, y, 0.5 * sizes_m[i, 0]
            if kind != PEDESTRIAN:
                px, py = _outline_point(x, y, poses_map[i, 2] - ego[2], sizes_m[i], j, n)
                radius = 0.0
            rows[k, 0], rows[k, 1], rows[k, 2], rows[k, 3] = px, py, vx, vy
            rows[k, 4], rows[k, 5], rows[k, 6] = radius, BRAKES_MPS2[kind], SWERVES_MPS2[kind]
            k += 1
    return rows


@njit(cache=True)
def _outline_points(size_m: Array) -> int:
    return int(max(8, math.ceil(2.0 * (size_m[0] + size_m[1]) / _EDGE_M)))


@njit(cache=True)
def _outline_point(x: float, y: float, yaw: float, size_m: Array, j: int, n: int) -> tuple[float, float]:
    """The j-th of n points along a rectangle's outline.

    Corners are met exactly: each side has a share of the points that begins at a corner.
    """
    length, width = size_m[0], size_m[1]
    lengthwise = min(max(1, round(0.5 * n * length / (length + width))), n // 2 - 1)
    crosswise = n // 2 - lengthwise
    half = lengthwise + crosswise
    sign = 1.0 if j < half else -1.0
    j = j % half
    if j < lengthwise:
        along, across = -0.5 * length + length * j / lengthwise, -0.5 * width
    else:
        along, across = 0.5 * length, -0.5 * width + width * (j - lengthwise) / crosswise
    along, across = sign * along, sign * across
    cos, sin = math.cos(yaw), math.sin(yaw)
    return x + cos * along - sin * across, y + sin * along + cos * across


def are_finite(tracks: Tracks) -> bool:
    """All positions, velocities and sizes are finite."""
    return bool(
        np.isfinite(tracks.poses_map).all()
        and np.isfinite(tracks.velocities_map_mps).all()
        and np.isfinite(tracks.sizes_m).all()
    )
