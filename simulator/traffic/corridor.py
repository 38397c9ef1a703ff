"""The road a vehicle is about to sweep, as ground truth for people and for the score."""

import math

import numpy as np
from numba import njit

from contract.geometry import Array, Pose2, arc_lengths, pose_at, project
from contract.roads.network import RoadNetwork

SPACING_M = 0.5
SAMPLES = 121
_WINDOW_POINTS = 40
_LOST_M = 4.0
_LOOKAHEAD_M = 120.0


class Corridor:
    """Samples of the line ahead of one vehicle's rear axle, every SPACING_M.

    The line is the vehicle's route (`follow`); without one, the lane it is on and the first successor of each
    lane after that.
    """

    def __init__(self, network: RoadNetwork) -> None:
        self._network = network
        self._points: Array = np.zeros((0, 2))
        self._s: Array = np.zeros(0)
        self._segment = 0
        self._has_route = False
        self.ahead: Array = np.zeros((SAMPLES, 2))

    def follow(self, points_map: Array) -> None:
        """Use this (n, 2) line from now on; ValueError for fewer than two points."""
        if len(points_map) < 2:
            raise ValueError("a route to follow needs at least two points")
        self._set(np.ascontiguousarray(points_map, dtype=np.float64))
        self._has_route = True

    def update(self, pose_map: Pose2) -> None:
        """Sample again from the vehicle's pose; past the line's end or off every line, straight ahead."""
        s_m = self._place(pose_map)
        if s_m is None:
            _sample_straight(pose_map.x_m, pose_map.y_m, pose_map.yaw_rad, self.ahead)
        else:
            _sample(self._points, self._s, s_m, self.ahead)

    def _place(self, pose_map: Pose2) -> float | None:
        s_m = self._on_line(pose_map)
        if s_m is not None and (self._has_route or self._s[-1] - s_m > SPACING_M * SAMPLES):
            return s_m
        self._from_lanes(pose_map)
        return self._on_line(pose_map)

    def _on_line(self, pose_map: Pose2) -> float | None:
        if len(self._points) < 2:
            return None
        last = self._segment + _WINDOW_POINTS
        s_m, d_m, segment = project(
            self._points, self._s, pose_map.x_m, pose_map.y_m, self._segment - 3, last
        )
        if abs(d_m) > _LOST_M:
            return None
        self._segment = int(segment)
        return float(s_m)

    def _from_lanes(self, pose_map: Pose2) -> None:
        self._points, self._has_route = np.zeros((0, 2)), False
        found = self._network.locate(pose_map.x_m, pose_map.y_m, pose_map.yaw_rad)
        if found is None:
            return
        lane_id, s_m, _ = found
        pieces: list[Array] = []
        length_m = -s_m
        while length_m < _LOOKAHEAD_M:
            line = self._network.lines[lane_id]
            pieces.append(line.points if not pieces else line.points[1:])
            length_m += line.length_m
            successors = self._network.successors(lane_id)
            if not successors:
                break
            lane_id = successors[0]
        points = np.concatenate(pieces)
        self._set(points)
        start = int(np.searchsorted(self._s, s_m))
        self._segment = max(0, start - 1)

    def _set(self, points: Array) -> None:
        self._points, self._s, self._segment = points, arc_lengths(points), 0


@njit(cache=True)
def _sample(points: Array, s: Array, s_m: float, out: Array) -> None:
    total = s[-1]
    _, _, end_yaw = pose_at(points, s, total)
    for k in range(out.shape[0]):
        at = s_m + k * SPACING_M
        x, y, _ = pose_at(points, s, at)
        over = max(0.0, at - total)
        out[k, 0] = x + over * math.cos(end_yaw)
        out[k, 1] = y + over * math.sin(end_yaw)


@njit(cache=True)
def _sample_straight(x: float, y: float, yaw: float, out: Array) -> None:
    for k in range(out.shape[0]):
        out[k, 0] = x + k * SPACING_M * math.cos(yaw)
        out[k, 1] = y + k * SPACING_M * math.sin(yaw)


@njit(cache=True)
def place_in_corridor(ahead: Array, x: float, y: float) -> tuple[float, float, float, float]:
    """(s, d, tx, ty): distance along from the rear axle, offset (left positive), unit tangent there.

    s is negative behind the rear axle and runs on straight past the far end.
    """
    n = ahead.shape[0]
    best, k = np.inf, 0
    for i in range(n):
        dx, dy = x - ahead[i, 0], y - ahead[i, 1]
        distance2 = dx * dx + dy * dy
        if distance2 < best:
            best, k = distance2, i
    a, b = max(0, k - 1), min(n - 1, k + 1)
    tx, ty = ahead[b, 0] - ahead[a, 0], ahead[b, 1] - ahead[a, 1]
    length = math.hypot(tx, ty)
    if length == 0.0:
        return k * SPACING_M, 0.0, 1.0, 0.0
    tx, ty = tx / length, ty / length
    dx, dy = x - ahead[k, 0], y - ahead[k, 1]
    return k * SPACING_M + dx * tx + dy * ty, tx * dy - ty * dx, tx, ty
