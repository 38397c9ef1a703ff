"""Obstacle cells in the map frame, with a memory for the lidar's blind zone."""

import math

import msgspec
import numpy as np

from contract.geometry import Array, Pose2, inverse, transform_points
from vehicle_agent.perception.lidar_faults import NO_CONDITIONS, lidar_faults, newest_conditions
from vehicle_agent.signals import (
    Detections,
    Ego,
    Fault,
    LidarConditions,
    ObstaclePercept,
    PerceptionInput,
)
from vehicle_agent.signals.pose_history import PoseHistory, pose_at


class CellsState(msgspec.Struct, frozen=True):
    """What perception remembers: recent poses, the last detections, and cells in the blind zone.

    hidden_map (n, 2), hidden_ns (n,)  cells in the blind zone, and when each was last detected
    hidden_low (n,)                    which of them are kerbs
    hidden_left (n,)                   which of them may have left: somebody has appeared since
    recent_map                         (k, 2) cells of each of the last scans near the zone, oldest first
    lidars                             what the lidars' driver said last
    """

    poses: PoseHistory
    detections: Detections
    hidden_map: np.ndarray
    hidden_ns: np.ndarray
    lidars: LidarConditions = NO_CONDITIONS
    hidden_low: np.ndarray = msgspec.field(default_factory=lambda: np.empty(0, np.bool_))
    hidden_left: np.ndarray = msgspec.field(default_factory=lambda: np.empty(0, np.bool_))
    recent_map: tuple[np.ndarray, ...] = ()


class HeightMapPerception(msgspec.Struct, frozen=True):
    """Moves percepts to the map frame with the vehicle's pose at the scan.

    A lidar on the roof does not see below its lowest ring: a person close to the bumper is not detected (GEM,
    section V). A cell last detected there is therefore kept for `memory_ns`. Before a vehicle at rest it is
    kept for `rest_memory_ns`, unless somebody appears who may be who stood there: who leaves is seen.

    lidar_x_m, lidar_z_m, ring_rad_min  position of the lidar, elevation of its lowest ring
    person_m     height of the shortest person for whom the blind zone is computed
    memory_m     a newer cell this near replaces a remembered one
    rest_mps     a slower vehicle is at rest
    appears_m, recent_scans  a cell with none so near in so many scans before it is somebody who appears
    leaves_mps, leaves_m     who has left is within leaves_m, and this speed times the time unseen
    bounds_m     and comes into view so near outside the zone
    history_ns   poses are kept this long, for percepts that arrive late
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
    rest_memory_ns: int = 4_000_000_000
    rest_mps: float = 0.1
    appears_m: float = 0.75
    recent_scans: int = 5
    leaves_mps: float = 3.0
    leaves_m: float = 1.0
    bounds_m: float = 1.5
    history_ns: int = 600_000_000

    def initial(self) -> CellsState:
        no_points = np.empty((0, 2))
        return CellsState((), Detections(0, no_points, False), no_points, np.empty(0, np.int64))

    @property
    def blind_radius_m(self) -> float:
        """Radius around the lidar in which a person of `person_m` is below the lowest ring."""
        below_m = max(0.0, self.lidar_z_m - self.person_m)
        return below_m / math.tan(-self.ring_rad_min) + self.blind_margin_m

    def step(
        self, state: CellsState, percepts: tuple[PerceptionInput, ...], ego: Ego
    ) -> tuple[Detections, CellsState]:
        """The obstacles now: the cells of the newest scan, and the remembered cells of the blind zone."""
        poses = (*state.poses, (ego.stamp_ns, ego.pose_map))
        oldest_ns = ego.stamp_ns - self.history_ns
        if poses[0][0] < oldest_ns:
            poses = tuple(entry for entry in poses if entry[0] >= oldest_ns)
        state = msgspec.structs.replace(state, poses=poses, lidars=newest_conditions(state.lidars, percepts))
        scans = [percept for percept in percepts if isinstance(percept, ObstaclePercept)]
        newer = [scan for scan in scans if scan.stamp_ns > state.detections.stamp_ns]
        if not newer:
            return state.detections, state
        percept = max(newer, key=lambda item: item.stamp_ns)
        if percept.points_used == 0:
            # The scan shows nothing, so it cannot show that a known obstacle has gone.
            detections = msgspec.structs.replace(state.detections, stamp_ns=percept.stamp_ns, blind=True)
            return detections, msgspec.structs.replace(state, detections=detections)
        return self._with_scan(state, percept, abs(ego.speed_mps) < self.rest_mps)

    def _with_scan(
        self, state: CellsState, percept: ObstaclePercept, at_rest: bool
    ) -> tuple[Detections, CellsState]:
        pose_map = pose_at(state.poses, percept.stamp_ns)
        new_map = transform_points(pose_map, percept.cells_base)
        new_ns = np.full(len(new_map), percept.stamp_ns, np.int64)
        bounds = self._at_bounds(percept.cells_base)
        has_left = self._may_have_left(state, new_map[bounds], percept.stamp_ns)
        lasts_ns = np.where(has_left | (not at_rest), self.memory_ns, self.rest_memory_ns)
        remembered = self._still_hidden(state, pose_map, new_map, percept.stamp_ns, lasts_ns)
        hidden_map: Array = np.vstack((state.hidden_map[remembered], new_map))
        hidden_ns = np.concatenate((state.hidden_ns[remembered], new_ns))
        points_map: Array = np.vstack((new_map, state.hidden_map[remembered]))
        new_low = percept.is_low if len(percept.is_low) == len(new_map) else np.zeros(len(new_map), np.bool_)
        old_low = state.hidden_low[remembered]
        in_zone = self._in_blind_zone(
            transform_points(inverse(pose_map), hidden_map), 2.0 * self.blind_margin_m
        )
        detections = Detections(
            percept.stamp_ns, points_map, False, is_low=np.concatenate((new_low, old_low))
        )
        hidden_low = np.concatenate((old_low, new_low))[in_zone]
        hidden_left = np.concatenate((has_left[remembered], np.zeros(len(new_map), np.bool_)))[in_zone]
        return detections, CellsState(
            state.poses, detections, hidden_map[in_zone], hidden_ns[in_zone], state.lidars, hidden_low,
            hidden_left, (*state.recent_map, new_map[bounds])[-self.recent_scans :],
        )  # fmt: skip

    def faults(self, state: CellsState, now_ns: int) -> tuple[Fault, ...]:
        """What is wrong with single lidars, as their driver says."""
        return lidar_faults(state.lidars, now_ns)

    def _may_have_left(self, state: CellsState, new_map: Array, now_ns: int) -> np.ndarray:
        """(n,) True for remembered cells of which somebody who has appeared since may be the one.

        new_map (k, 2) the scan's cells at the zone's bounds
        """
        left: np.ndarray = state.hidden_left.copy()
        if not len(left) or self.rest_memory_ns <= self.memory_ns:
            return left
        known_map = np.vstack(state.recent_map) if state.recent_map else new_map[:0]
        appears = new_map[~_near_any(new_map, known_map, self.appears_m)]
        if len(appears):
            reach_m = self.leaves_m + self.leaves_mps * 1e-9 * (now_ns - state.hidden_ns)
            apart = np.linalg.norm(state.hidden_map[:, None, :] - appears[None, :, :], axis=2)
            left |= apart.min(axis=1) <= reach_m
        return left

    def _still_hidden(
        self, state: CellsState, pose_map: Pose2, new_map: Array, now_ns: int, lasts_ns: np.ndarray
    ) -> np.ndarray:
        """(n,) True for cells still in the blind zone, no older than lasts_ns, without a newer one nearby."""
        hidden_base = transform_points(inverse(pose_map), state.hidden_map)
        remembered = self._in_blind_zone(hidden_base, 0.0) & (now_ns - state.hidden_ns <= lasts_ns)
        if remembered.any():
            remembered &= ~_near_any(state.hidden_map, new_map, self.memory_m)
        return remembered

    def _at_bounds(self, cells_base: Array) -> np.ndarray:
        """(n,) which cells (n, 2) lie in the zone, or no farther outside than who leaves comes into view."""
        away_m = np.hypot(cells_base[:, 0] - self.lidar_x_m, cells_base[:, 1])
        at: np.ndarray = away_m <= self.blind_radius_m + self.bounds_m
        return at

    def _in_blind_zone(self, points_base: Array, margin_m: float) -> np.ndarray:
        x, y = points_base[:, 0], points_base[:, 1]
        radius_m = self.blind_radius_m + margin_m
        below_ring = (x - self.lidar_x_m) ** 2 + y**2 <= radius_m**2
        inside = (-self.body_back_m <= x) & (x <= self.body_front_m) & (np.abs(y) <= self.body_half_width_m)
        return below_ring & ~inside


def _near_any(points: Array, others: Array, within_m: float) -> np.ndarray:
    """(n,) which of the points (n, 2) lie within within_m of one of the others (k, 2)."""
    if not len(points) or not len(others):
        return np.zeros(len(points), np.bool_)
    apart = points[:, None, :] - others[None, :, :]
    near: np.ndarray = np.min(apart[..., 0] ** 2 + apart[..., 1] ** 2, axis=1) <= within_m**2
    return near
