"""The free line of sight in each direction: a person may be hidden behind a parked car."""

import math

import msgspec
import numpy as np
from numba import njit

from contract.geometry import Array, Pose2
from contract.roads.walls import edges_near
from vehicle_agent.signals import PEDESTRIAN, Tracks, View


class VisibilityParams(msgspec.Struct, frozen=True):
    """sensor_x_m  the sensor ahead of the rear axle
    bearings      number of rays over the full circle; range_m: their length
    cell_m        an obstacle cell hides this much to each side of its centre
    standing_mps  a slower vehicle hides what is behind it
    """

    sensor_x_m: float
    bearings: int = 720
    range_m: float = 40.0
    cell_m: float = 0.15
    standing_mps: float = 0.5

    def view(self, pose_map: Pose2, points_map: Array, tracks: Tracks, edges: Array) -> View:
        """The view now; edges (n, 4): walls of the map.

        Standing vehicles hide people behind them. People do not, and moving vehicles do not either: they
        have gone before a person could come from behind them.
        """
        cos, sin = math.cos(pose_map.yaw_rad), math.sin(pose_map.yaw_rad)
        x_m, y_m = pose_map.x_m + self.sensor_x_m * cos, pose_map.y_m + self.sensor_x_m * sin
        speeds = np.hypot(tracks.velocities_map_mps[:, 0], tracks.velocities_map_mps[:, 1])
        is_hiding = (tracks.kinds != PEDESTRIAN) & (speeds < self.standing_mps)
        boxes = _outline_edges(tracks.poses_map[is_hiding], tracks.sizes_m[is_hiding])
        walls = np.vstack((edges_near(edges, x_m, y_m, self.range_m), boxes))
        ranges = ranges_by_bearing(
            x_m, y_m, pose_map.yaw_rad, points_map, self.cell_m, walls, self.bearings, self.range_m
        )
        return View(Pose2(x_m, y_m, pose_map.yaw_rad), ranges)


def points_on_walls(edges: Array, pose_map: Pose2, within_m: float, step_m: float = 0.4) -> Array:
    """(m, 2) points every step_m along the walls (n, 4) within within_m of the vehicle."""
    position = np.array([pose_map.x_m, pose_map.y_m])
    near_edges = edges_near(edges, pose_map.x_m, pose_map.y_m, within_m)
    pieces = [np.empty((0, 2))]
    for x0, y0, x1, y1 in near_edges.tolist():
        count = max(2, math.ceil(math.hypot(x1 - x0, y1 - y0) / step_m) + 1)
        fraction = np.linspace(0.0, 1.0, count)[:, None]
        points = np.array([x0, y0]) + fraction * np.array([x1 - x0, y1 - y0])
        pieces.append(points[np.hypot(points[:, 0] - position[0], points[:, 1] - position[1]) <= within_m])
    return np.vstack(pieces)


def _outline_edges(poses: Array, sizes: Array) -> Array:
    """(4 n, 4) the sides of boxes: poses (n, 3) of their centres, sizes (n, 2)."""
    n = len(poses)
    cos, sin = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    corners = np.empty((n, 4, 2))
    for k, (u, v) in enumerate(((0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5), (0.5, -0.5))):
        along, aside = u * sizes[:, 0], v * sizes[:, 1]
        corners[:, k, 0] = poses[:, 0] + cos * along - sin * aside
        corners[:, k, 1] = poses[:, 1] + sin * along + cos * aside
    sides: Array = np.concatenate((corners, np.roll(corners, -1, axis=1)), axis=2).reshape(4 * n, 4)
    return sides


@njit(cache=True)
def ranges_by_bearing(
    x_m: float,
    y_m: float,
    yaw_rad: float,
    points: Array,
    cell_m: float,
    edges: Array,
    bearings: int,
    range_m: float,
) -> Array:
    """(bearings,) free line of sight; ray i has the bearing -pi + (i + 0.5) 2 pi / bearings in the body."""
    ranges = np.full(bearings, range_m)
    step = 2.0 * math.pi / bearings
    for p in range(points.shape[0]):
        dx, dy = points[p, 0] - x_m, points[p, 1] - y_m
        distance = math.hypot(dx, dy)
        if distance >= range_m or distance < 1e-3:
            continue
        bearing = math.atan2(dy, dx) - yaw_rad
        half = math.atan2(cell_m, distance)
        first = math.floor((bearing - half + math.pi) / step)
        last = math.floor((bearing + half + math.pi) / step)
        for k in range(first, last + 1):
            i = k % bearings
            ranges[i] = min(ranges[i], distance)
    for i in range(bearings):
        angle = yaw_rad - math.pi + (i + 0.5) * step
        ux, uy = math.cos(angle), math.sin(angle)
        for e in range(edges.shape[0]):
            ax, ay = edges[e, 0] - x_m, edges[e, 1] - y_m
            bx, by = edges[e, 2] - edges[e, 0], edges[e, 3] - edges[e, 1]
            across = ux * by - uy * bx
            if abs(across) < 1e-12:
                continue
            t = (ax * by - ay * bx) / across
            q = (ax * uy - ay * ux) / across
            if t > 0.0 and 0.0 <= q <= 1.0:
                ranges[i] = min(ranges[i], t)
    return ranges
