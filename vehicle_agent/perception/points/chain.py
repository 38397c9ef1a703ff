"""Perception from points: ground, obstacle cells, objects and tracks of one scan after another."""

import msgspec
import numpy as np

from contract.geometry import Array, BoolArray, Pose2
from vehicle_agent.perception.points.cells import PointHeights, lowest_heights, percept_of, point_heights
from vehicle_agent.perception.points.clusters import ClusterParams, objects_of_points
from vehicle_agent.perception.points.grid import PointGrid
from vehicle_agent.perception.points.union import union
from vehicle_agent.perception.tracking.tracker import ObjectTracker
from vehicle_agent.perception.tracking.tracks import ObjectTrackerState
from vehicle_agent.signals import ObstaclePercept, TrackPercept
from vehicle_agent.signals.objects import SeenObjects

# A return so near to an object's middle is its own, or the ground's at its feet.
_AROUND_M = 0.4


class PointPerception(msgspec.Struct, frozen=True):
    """The whole chain of one vehicle, without a network.

    grid      extent and rules of the cells; `above_m` and the outline are the vehicle's
    clusters  which objects are looked for
    tracker   gives them identities and velocities
    unseen_m  x and radius: nearer to (x, 0), base frame, little more than people's heads is in the beams
    """

    grid: PointGrid
    clusters: ClusterParams = ClusterParams()
    tracker: ObjectTracker = ObjectTracker()
    unseen_m: tuple[float, float] = (0.0, 0.0)

    def initial(self) -> ObjectTrackerState:
        return self.tracker.initial()

    def step(
        self,
        state: ObjectTrackerState,
        points_base: np.ndarray,
        intensities: np.ndarray,
        stamp_ns: int,
        pose_map: Pose2,
        found: SeenObjects | None = None,
    ) -> tuple[ObstaclePercept, TrackPercept, ObjectTrackerState]:
        """Cells and tracks of one scan of all lidars, moved to stamp_ns.

        points_base  (n, 3) float32, base frame at stamp_ns, z from the ground under the rear axle
        intensities  (n,) as the lidars give them
        pose_map     of the vehicle at stamp_ns
        found        objects that another finder has at stamp_ns: clusters in them are theirs
        Raises ValueError for points of another shape.
        """
        heights = point_heights(points_base, self.grid)
        points = np.ascontiguousarray(points_base, dtype=np.float32)
        cells = percept_of(heights, stamp_ns, self.grid)
        seen = objects_of_points(points, heights, stamp_ns, self.grid, self.clusters)
        if found is not None:
            seen = union(seen, found, self._is_unseen(found.poses_base[:, :2]))
        seen = self._with_visible_heights(seen, points, heights)
        tracks, state = self.tracker.step(state, seen, pose_map)
        return cells, tracks, state

    def without_below(self, state: ObjectTrackerState) -> ObjectTrackerState:
        """Without those who are not seen because all beams pass over them, as `ObjectTracker` says."""
        return self.tracker.without_below(state)

    def people_below(self, state: ObjectTrackerState, pose_map: Pose2) -> np.ndarray:
        """(n, 3) of those and who may soon be, as `ObjectTracker` says."""
        return self.tracker.people_below(state, pose_map)

    def with_below(
        self, state: ObjectTrackerState, people_base: np.ndarray, pose_map: Pose2
    ) -> ObjectTrackerState:
        """With people of whom an earlier worker knew, as `ObjectTracker` says."""
        return self.tracker.with_below(state, people_base, pose_map)

    def _is_unseen(self, places_base: Array) -> BoolArray:
        """(n,) places (n, 2) where the points may show nothing of a person whom another sensor sees."""
        x_m, radius_m = self.unseen_m
        near: BoolArray = np.hypot(places_base[:, 0] - x_m, places_base[:, 1]) < radius_m
        return near | self.tracker.below_beams.contains(places_base)

    def _with_visible_heights(
        self, seen: SeenObjects, points: np.ndarray, heights: PointHeights
    ) -> SeenObjects:
        """The objects, with the height of their visible part where all of a person may be below the beams."""
        places = seen.poses_base[:, :2]
        near = np.flatnonzero(self.tracker.below_beams.contains(places, margin_m=_AROUND_M))
        visible_m = np.full(len(places), np.nan)
        if len(near):
            lowest = lowest_heights(points, heights.heights_m, heights.cell_of, places[near], _AROUND_M)
            visible_m[near] = np.where(np.isfinite(lowest), seen.sizes_m[near, 2] - lowest, np.nan)
        return msgspec.structs.replace(seen, visible_m=visible_m)
