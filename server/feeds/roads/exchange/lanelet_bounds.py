"""The left and right bounds of lanes, as Lanelet2 wants them: two lanes follow each other when they share the
last and first point of both bounds."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from contract.geometry import Array
from contract.roads.design_vehicle import WIDTH_M
from contract.roads.model import Lane
from server.feeds.roads.lanes.curves import end_poses, offset, peak_curvature

# A bound stays this far inside the centre of the sharpest bend, so that it does not fold.
_SHARE_OF_RADIUS = 0.8
_HALF_MAX_M = 2.0
_HALF_MIN_M = WIDTH_M / 2.0
_SIMPLIFY_M = 0.02


@dataclass(frozen=True, slots=True)
class Bounds:
    """left, right: (n, 2) points in the direction of travel; joints: the number of the joint at the start and
    at the end."""

    left: Array
    right: Array
    joints: tuple[int, int]


def half_width_m(lane: Lane) -> float:
    """Half of what the lane covers: of the road, where both directions share it, else of its own side."""
    own_m = lane.width_m / 2.0 if lane.can_pass else lane.width_m
    half_m = min(own_m / 2.0, _HALF_MAX_M)
    peak = peak_curvature(np.array(lane.points, dtype=np.float64))
    if peak > 0.0:
        half_m = min(half_m, _SHARE_OF_RADIUS / peak)
    return max(half_m, _HALF_MIN_M)


def joints_of(lanes: Sequence[Lane]) -> dict[tuple[str, bool], int]:
    """{(lane_id, is the end): joint}: ends and starts that meet have one number, by first use."""
    root: dict[tuple[str, bool], tuple[str, bool]] = {}

    def find(end: tuple[str, bool]) -> tuple[str, bool]:
        root.setdefault(end, end)
        while root[end] != end:
            end = root[end]
        return end

    for lane in lanes:
        for successor in lane.successors:
            one, other = find((lane.lane_id, True)), find((successor, False))
            if one != other:
                root[other] = one
    numbers: dict[tuple[str, bool], int] = {}
    joints = {}
    for lane in lanes:
        for is_end in (False, True):
            key = find((lane.lane_id, is_end))
            joints[lane.lane_id, is_end] = numbers.setdefault(key, len(numbers))
    return joints


def unsaid_by_joints(lanes: Sequence[Lane], joints: Mapping[tuple[str, bool], int]) -> set[str]:
    """Lanes of which the shared points would say other successors, or another order of them."""
    begins: dict[int, list[str]] = {}
    for lane in lanes:
        begins.setdefault(joints[lane.lane_id, False], []).append(lane.lane_id)
    return {
        lane.lane_id for lane in lanes if begins.get(joints[lane.lane_id, True], []) != list(lane.successors)
    }


def bounds_of(lanes: Sequence[Lane], joints: Mapping[tuple[str, bool], int]) -> dict[str, Bounds]:
    """Every lane's bounds; at a joint all of them have the narrowest lane's width and one heading."""
    narrowest: dict[int, float] = {}
    corners: dict[int, tuple[Array, Array]] = {}
    lines = {lane.lane_id: np.array(lane.points, dtype=np.float64) for lane in lanes}
    halves = {lane.lane_id: half_width_m(lane) for lane in lanes}
    for lane in lanes:
        for is_end in (False, True):
            joint = joints[lane.lane_id, is_end]
            narrowest[joint] = min(halves[lane.lane_id], narrowest.get(joint, np.inf))
    for lane in lanes:
        poses = end_poses(lines[lane.lane_id])
        for is_end in (False, True):
            joint = joints[lane.lane_id, is_end]
            x_m, y_m, yaw = poses[1 if is_end else 0]
            left = narrowest[joint] * np.array([-np.sin(yaw), np.cos(yaw)])
            corners.setdefault(joint, (np.array([x_m, y_m]) + left, np.array([x_m, y_m]) - left))
    found = {}
    for lane in lanes:
        first, last = joints[lane.lane_id, False], joints[lane.lane_id, True]
        line, half_m = lines[lane.lane_id], halves[lane.lane_id]
        sides = [
            _side(offset(line, sign * half_m), corners[first][number], corners[last][number])
            for number, sign in enumerate((1.0, -1.0))
        ]
        found[lane.lane_id] = Bounds(sides[0], sides[1], (first, last))
    return found


def _side(points: Array, first: Array, last: Array) -> Array:
    inner = shapely.get_coordinates(shapely.simplify(shapely.LineString(points), _SIMPLIFY_M))[1:-1]
    side: Array = np.vstack((first, inner, last))
    return side
