"""Loop closure: keyframes where the lidar came back to a place, by looks and by nearness, each verified."""

import bisect
import math
from collections.abc import Callable, Sequence

import msgspec
import numpy as np
from scipy.spatial import cKDTree

from contract.geometry import Array
from vehicle_agent.localization.odometry.motion import inverted, logarithm
from vehicle_agent.localization.odometry.voxel_map import Array32
from workshop.cloud_mapping.descriptors import RINGS, SECTORS, descriptor, similar_places
from workshop.cloud_mapping.pose_graph import Edge, Ground
from workshop.cloud_mapping.submaps import Submap, SubmapParams, joined, registered, submap


class LoopParams(msgspec.Struct, frozen=True):
    """How loops are looked for.

    every            keyframes from one that is compared to the next
    apart            keyframes that lie between two that are compared: nearer ones are one pass
    neighbours, distance_max  candidates by looks that are compared, and how unlike they may look
    looks_m          with fixes, places that look alike are compared only if they are so near each other
    passes_max       other passes of the place that a keyframe is registered with
    correction_m, correction_rad  a registration of near keyframes that corrects by more is another place
    """

    every: int = 4
    apart: int = 60
    neighbours: int = 20
    distance_max: float = 0.66
    looks_m: float = 30.0
    passes_max: int = 2
    correction_m: float = 3.0
    correction_rad: float = 0.15
    submap: SubmapParams = SubmapParams()


class LoopCloser:
    """The keyframes of a drive, or of several, whose submaps are made by dead reckoning and kept."""

    def __init__(
        self,
        clouds: Sequence[Array32],
        poses: Array,
        ground: Ground,
        params: LoopParams,
        starts: Sequence[int] = (0,),
    ) -> None:
        """starts: the first keyframe of each drive. No submap has keyframes of two drives."""
        self._clouds, self._poses, self._ground, self._params = clouds, poses, ground, params
        self._starts = [*starts, len(clouds)]
        self._submaps: dict[int, Submap] = {}
        self.compared = list(range(0, len(clouds), params.every))
        self.tried = 0

    def by_looks(self, poses: Array | None, advance: Callable[[int], None]) -> list[Edge]:
        """Loops between keyframes that look alike; poses (k, 4, 4): where fixes have them, None without."""
        params = self._params
        grids = np.zeros((len(self.compared), RINGS, SECTORS))
        for row, number in enumerate(self.compared):
            # The sensor's axes lean with the road; the ground says how.
            level = _levelled(self._ground.normals[number])
            clouds, its_poses, middle = self._drive_of(number)
            points = joined(clouds, its_poses, middle, params.submap.keyframes) @ level.T
            grids[row] = descriptor(points, -float(self._ground.heights_m[number]))
            advance(1)
        edges = []
        apart = math.ceil(params.apart / params.every)
        for newer, older, yaw_rad in similar_places(grids, apart, params.neighbours, params.distance_max):
            guess = np.eye(4)
            guess[:2, :2] = [[math.cos(yaw_rad), -math.sin(yaw_rad)], [math.sin(yaw_rad), math.cos(yaw_rad)]]
            from_, to = self.compared[older], self.compared[newer]
            if poses is not None and _apart_m(poses, from_, to) > params.looks_m:
                continue
            edge = self._edge(from_, to, guess, is_near=False)
            if edge is not None:
                edges.append(edge)
        return edges

    def by_nearness(self, poses: Array, near_m: float, advance: Callable[[int], None]) -> list[Edge]:
        """Loops between keyframes that poses (k, 4, 4) of the graph so far have near each other."""
        places = poses[self.compared][:, :3, 3]
        tree, edges = cKDTree(places[:, :2]), []
        for row, number in enumerate(self.compared):
            for other in self._passes(row, tree, places, near_m):
                guess = inverted(poses[other]) @ poses[number]
                edge = self._edge(other, number, guess, is_near=True)
                if edge is not None:
                    edges.append(edge)
            advance(1)
        return edges

    def _passes(self, row: int, tree: cKDTree, places: Array, near_m: float) -> list[int]:
        """The nearest compared keyframe of each earlier pass of a place, the nearest passes first."""
        params = self._params
        apart = math.ceil(params.apart / params.every)
        drives = [bisect.bisect_right(self._starts, number) for number in self.compared]
        near = sorted(
            i for i in tree.query_ball_point(places[row, :2], near_m)
            if i <= row - apart or (i < row and drives[i] != drives[row])
        )  # fmt: skip
        passes: list[tuple[float, int]] = []
        before = -apart
        for other in near:
            # Heights of different drives are not comparable before a loop joins them.
            distance_m = float(np.linalg.norm((places[other] - places[row])[:2]))
            if passes and other - before < apart // 2 and drives[other] == drives[before]:
                passes[-1] = min(passes[-1], (distance_m, other))
            else:
                passes.append((distance_m, other))
            before = other
        return [self.compared[other] for _, other in sorted(passes)[: params.passes_max]]

    def _edge(self, older: int, newer: int, guess: Array, *, is_near: bool) -> Edge | None:
        params = self._params
        self.tried += 1
        found = registered(self._submap(older), self._submap(newer), guess, params.submap)
        if found is None:
            return None
        correction = np.abs(logarithm(inverted(guess) @ found.pose))
        if is_near and (
            np.linalg.norm(correction[:3]) > params.correction_m
            or np.linalg.norm(correction[3:]) > params.correction_rad
        ):
            return None
        return Edge(older, newer, found.pose, found.information, True)

    def _submap(self, number: int) -> Submap:
        if number not in self._submaps:
            self._submaps[number] = submap(*self._drive_of(number), self._params.submap)
            # Those of long ago are seldom asked for again, and each takes some MB.
            if len(self._submaps) > _SUBMAPS_KEPT:
                del self._submaps[next(iter(self._submaps))]
        return self._submaps[number]

    def _drive_of(self, number: int) -> tuple[Sequence[Array32], Array, int]:
        """(clouds, poses, its place among them) of the drive of a keyframe."""
        at = bisect.bisect_right(self._starts, number)
        first, last = self._starts[at - 1], self._starts[at]
        return self._clouds[first:last], self._poses[first:last], number - first


_SUBMAPS_KEPT = 80


def _apart_m(poses: Array, one: int, other: int) -> float:
    return float(np.linalg.norm(poses[one, :2, 3] - poses[other, :2, 3]))


def _levelled(normal: Array) -> Array:
    """(3, 3) the rotation that turns a normal (3,) near the z axis to it."""
    x, y, z = normal
    cross = np.array([[0.0, 0.0, -x], [0.0, 0.0, -y], [x, y, 0.0]])
    turned: Array = np.eye(3) + cross + cross @ cross / (1.0 + z)
    return turned
