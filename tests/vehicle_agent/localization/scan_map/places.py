"""A small town square as surface elements, and scans of it from known poses."""

import math

import numpy as np

from contract.geometry import Array, Pose2
from contract.point_map.tiles import Surfels
from vehicle_agent.signals.point_cloud import PointCloud, point_cloud

MOUNT = np.eye(4)
MOUNT[:3, 3] = 1.0, 0.0, 2.0
TILE_M, VOXEL_M = 32.0, 0.5
# Corner and the two edges of each wall, and of the ground.
GROUND = ((-30.0, -30.0, 0.0), (60.0, 0.0, 0.0), (0.0, 60.0, 0.0))
SQUARE = (
    ((-20.0, 14.0, 0.0), (38.0, 0.0, 0.0), (0.0, 0.0, 6.0)),
    ((-20.0, -9.0, 0.0), (17.0, 0.0, 0.0), (0.0, 0.0, 6.0)),
    ((22.0, -14.0, 0.0), (0.0, 25.0, 0.0), (0.0, 0.0, 6.0)),
    ((5.0, -12.0, 0.0), (0.0, 5.0, 0.0), (0.0, 0.0, 4.0)),
    ((-12.0, 8.0, 0.0), (3.0, 2.0, 0.0), (0.0, 0.0, 3.0)),
)
# Two walls without ends in sight.
CORRIDOR = (
    ((-300.0, 6.0, 0.0), (600.0, 0.0, 0.0), (0.0, 0.0, 6.0)),
    ((-300.0, -6.0, 0.0), (600.0, 0.0, 0.0), (0.0, 0.0, 6.0)),
)


def points_on(quads: tuple, per_m2: float, seed: int, within_m: float = 45.0) -> Array:
    rng = np.random.default_rng(seed)
    parts = []
    for corner, first, second in quads:
        a, b = np.array(first), np.array(second)
        count = round(per_m2 * float(np.linalg.norm(a) * np.linalg.norm(b)))
        parts.append(np.array(corner) + rng.random((count, 1)) * a + rng.random((count, 1)) * b)
    points = np.concatenate(parts)
    return points[np.hypot(points[:, 0], points[:, 1]) < within_m]


def a_map(quads: tuple) -> dict[tuple[int, int], Surfels]:
    """Tiles: the voxels that the surfaces go through, with their normals."""
    means, normals = [], []
    for quad in (GROUND, *quads):
        points = points_on((quad,), 60.0, 3)
        voxels = np.floor((points + 1e-6) / VOXEL_M).astype(int)
        _, first = np.unique(voxels, axis=0, return_index=True)
        normal = np.cross(quad[1], quad[2])
        means.append(points[first])
        normals.append(np.tile(normal / np.linalg.norm(normal), (len(first), 1)))
    mean, normal = np.concatenate(means), np.concatenate(normals)
    tiles = {}
    at = np.floor(mean[:, :2] / TILE_M).astype(int)
    for ix, iy in np.unique(at, axis=0).tolist():
        chosen = (at == (ix, iy)).all(axis=1)
        count = int(chosen.sum())
        tiles[(ix, iy)] = Surfels(mean[chosen], normal[chosen], np.full(count, 0.02), np.full(count, 9.0))
    return tiles


def a_scan(quads: tuple, pose: Pose2, seed: int, stamp_ns: int = 0, noise_m: float = 0.02) -> PointCloud:
    """What is around, seen from the vehicle's pose; nothing hides anything."""
    points = points_on((GROUND, *quads), 4.0, seed)
    points = points + np.random.default_rng([seed, 1]).normal(0.0, noise_m, points.shape)
    cos, sin = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
    moved = points - np.array([pose.x_m, pose.y_m, 0.0])
    based = moved @ np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    return point_cloud(stamp_ns, based - MOUNT[:3, 3])
