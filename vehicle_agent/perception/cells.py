"""Obstacle cells in the map frame, and what has just walked under the lidar's rays."""

import math

import msgspec
import numpy as np

from contract.geometry import Array, Pose2, inverse, transform_points
from vehicle_agent.perception.pose_history import PoseHistory, pose_at
from vehicle_agent.signals import Detections, Ego, ObstaclePercept, Percept


class CellsState(msgspec.Struct, frozen=True):
    """What perception remembers: recent poses, the last answer, and cells that the lidar cannot see now.

    hidden_map (n, 2) and hidden_ns (n,): cells in the blind zone and when each was last seen
    """

    poses: PoseHistory
    seen: Detections
    hidden_map: np.ndarray
    hidden_ns: np.ndarray


class HeightMapPerception(msgspec.Struct, frozen=True):
    """Moves percepts to the map frame with the pose that the vehicle had at the scan.

    A lidar on the roof does not see under its lowest ring: a person who steps close to the bumper vanishes
    (GEM, section V). A cell last seen there is therefore kept for `memory_ns`.

    lidar_x_m, lidar_z_m, ring_rad_min  where the lidar sits, and its lowest ring
    person_m                            the shortest person who must not be lost
    """

    lidar_x_m: float
    lidar_z_m: float
    ring_rad_min: float
    body_front_m: float
    body_back_m: float
    body_half_width_m: float
    person_m: float = 1.4
    blind_margin_m: float = 0.4
    memory_ns: int = 4_000_000_000
    memory_m: float = 0.6
    history_ns: int = 600_000_000

    def initial(self) -> CellsState:
        nothing = np.empty((0, 2))
        return CellsState((), Detections(0, nothing, False), nothing, np.empty(0, np.int64))

    @property
    def blind_radius_m(self) -> float:
        """Around the lidar, where a person of `person_m` is under the lowest ring."""
        under_m = max(0.0, self.lidar_z_m - self.person_m)
        return under_m / math.tan(-self.ring_rad_min) + self.blind_margin_m

    def step(
        self, state: CellsState, percepts: tuple[Percept, ...], ego: Ego
    ) -> tuple[Detections, CellsState]:
        """The obstacles known now: those of the newest scan, and those hidden since."""
        poses = (*state.poses, (ego.stamp_ns, ego.pose_map))
        oldest_ns = ego.stamp_ns - self.history_ns
        if poses[0][0] < oldest_ns:
            poses = tuple(entry for entry in poses if entry[0] >= oldest_ns)
        state = msgspec.structs.replace(state, poses=poses)
        scans = [percept for percept in percepts if isinstance(percept, ObstaclePercept)]
        newer = [scan for scan in scans if scan.stamp_ns > state.seen.stamp_ns]
        if not newer:
            return state.seen, state
        percept = max(newer, key=lambda item: item.stamp_ns)
        if percept.points_used == 0:
            # Nothing was seen, so nothing known may be forgotten either.
            seen = Detections(percept.stamp_ns, state.seen.points_map, True)
            return seen, msgspec.structs.replace(state, seen=seen)
        return self._sighted(state, percept)

    def _sighted(self, state: CellsState, percept: ObstaclePercept) -> tuple[Detections, CellsState]:
        pose_map = pose_at(state.poses, percept.stamp_ns)
        fresh_map = transform_points(pose_map, percept.cells_base)
        fresh_ns = np.full(len(fresh_map), percept.stamp_ns, np.int64)
        kept = self._kept(state, pose_map, fresh_map, percept.stamp_ns)
        hidden_map: Array = np.vstack((state.hidden_map[kept], fresh_map))
        hidden_ns = np.concatenate((state.hidden_ns[kept], fresh_ns))
        points_map: Array = np.vstack((fresh_map, state.hidden_map[kept]))
        near = self._in_blind_zone(transform_points(inverse(pose_map), hidden_map), 2.0 * self.blind_margin_m)
        seen = Detections(percept.stamp_ns, points_map, False)
        return seen, CellsState(state.poses, seen, hidden_map[near], hidden_ns[near])

    def _kept(self, state: CellsState, pose_map: Pose2, fresh_map: Array, now_ns: int) -> np.ndarray:
        """(n,) which hidden cells still count: in the blind zone, not too old, and not seen again nearby."""
        hidden_base = transform_points(inverse(pose_map), state.hidden_map)
        kept = self._in_blind_zone(hidden_base, 0.0) & (now_ns - state.hidden_ns <= self.memory_ns)
        if len(fresh_map) and kept.any():
            apart = state.hidden_map[:, None, :] - fresh_map[None, :, :]
            kept &= np.min(apart[..., 0] ** 2 + apart[..., 1] ** 2, axis=1) > self.memory_m**2
        return kept

    def _in_blind_zone(self, points_base: Array, margin_m: float) -> np.ndarray:
        x, y = points_base[:, 0], points_base[:, 1]
        radius_m = self.blind_radius_m + margin_m
        under = (x - self.lidar_x_m) ** 2 + y**2 <= radius_m**2
        inside = (-self.body_back_m <= x) & (x <= self.body_front_m) & (np.abs(y) <= self.body_half_width_m)
        return under & ~inside
