"""The pose of a lidar, scan by scan: deskew, thin, align with a map of what was seen, add to it.

The frame is Vizzo et al. 2023 ("KISS-ICP"); surfaces in the voxels and the second deskew are ours.
"""

import math
from dataclasses import dataclass, field

import msgspec
import numpy as np

from contract.geometry import Array
from vehicle_agent.localization.odometry.motion import deskewed, exponential, inverted, logarithm
from vehicle_agent.localization.odometry.registration import align
from vehicle_agent.localization.odometry.voxel_map import (
    VoxelMap,
    add_points,
    empty_map,
    first_of_voxels,
    remove_far,
)
from vehicle_agent.signals.point_cloud import PointCloud


class OdometryParams(msgspec.Struct, frozen=True):
    """Parameters of the odometry.

    voxel_share      edge of the map's voxels as a share of the mean range of the first scan: rooms need
                     smaller ones than streets; scans are thinned for the map to half of it
    voxel_m_min, voxel_m_max  bounds of that edge
    source_voxels    edge of the voxels to which the scan is thinned for the alignment, in voxels of the map
    range_m_min, range_m_max  of points; nearer ones are the vehicle itself
    threshold_m      expected deviation of the prediction at first; then as it was
    threshold_m_min  and at least this
    motion_m_min     deviations below this are noise, not motion
    steps_max        of the alignment, and of the second one after the second deskew
    step_min         at which the alignment ends, m and rad
    new_m, new_rad   a scan is added to the map once the sensor has moved or turned so far
    still_m, still_rad, still_scans  a sensor that has stayed within these for so many scans stands, until it
                     is found farther away
    period_ns        between scans whose stamps do not tell
    """

    voxel_share: float = 0.07
    voxel_m_min: float = 0.25
    voxel_m_max: float = 1.0
    source_voxels: float = 1.5
    range_m_min: float = 1.0
    range_m_max: float = 100.0
    threshold_m: float = 2.0
    threshold_m_min: float = 0.15
    motion_m_min: float = 0.1
    steps_max: int = 30
    step_min: float = 5e-4
    new_m: float = 0.05
    new_rad: float = 0.005
    still_m: float = 0.02
    still_rad: float = 0.003
    still_scans: int = 3
    period_ns: int = 100_000_000


@dataclass(slots=True, eq=False)
class OdometryState:
    """What the odometry remembers; changed in place.

    pose         T_map_sensor at stamp_ns, the map's origin being the first scan's sensor
    twist_per_s  (6,) of the last motion
    deviations   sum of squared deviations of predictions, and how many
    removed_m    (3,) where far voxels were last removed
    added        (4, 4) pose of the last scan that was added to the map
    rest         (4, 4) the pose about which it has stayed for the last scans, and for how many; at first it
                 may have stood for long
    """

    voxels: VoxelMap
    pose: Array = field(default_factory=lambda: np.eye(4))
    twist_per_s: Array = field(default_factory=lambda: np.zeros(6))
    stamp_ns: int | None = None
    deviations_m2: float = 0.0
    deviations: int = 0
    removed_m: Array = field(default_factory=lambda: np.zeros(3))
    added: Array = field(default_factory=lambda: np.eye(4))
    rest: Array = field(default_factory=lambda: np.eye(4))
    rest_scans: int = 1_000_000


class OdometryStep(msgspec.Struct, frozen=True):
    """The pose (4, 4) T_map_sensor at the scan's stamp, and how it was found.

    steps, partners, points  of the alignment; partners 0 for the first scan, and for one that was not used
    """

    stamp_ns: int
    pose: np.ndarray
    steps: int
    partners: int
    points: int


# Fewer points say nothing about a motion.
_POINTS_MIN = 50
_GAP_NS_MAX = 1_000_000_000
# Far voxels are removed whenever the sensor has gone this part of the range.
_REMOVAL_SHARE = 0.2


class LidarOdometry:
    """One lidar's odometry. Deterministic; runs beside the tick, as it takes tens of milliseconds."""

    def __init__(self, params: OdometryParams | None = None) -> None:
        self.params = params or OdometryParams()
        self.state = OdometryState(empty_map(self.params.voxel_m_max))

    def step(self, cloud: PointCloud) -> OdometryStep:
        """The pose at this scan's stamp. A scan that says nothing leaves the predicted pose."""
        params, state = self.params, self.state
        period_s = 1e-9 * self._period_ns(cloud.stamp_ns)
        prediction = state.pose @ exponential(state.twist_per_s * period_s)
        points, times_s = _usable(cloud, params)
        if len(points) < _POINTS_MIN:
            return self._taken(cloud.stamp_ns, prediction, None, 0, 0, len(points))
        if state.voxels.used == 0:
            state.voxels = empty_map(_voxel_m(points, params))
            add_points(state.voxels, points[first_of_voxels(points, 0.5 * state.voxels.voxel_m)])
            return self._taken(cloud.stamp_ns, prediction, None, 0, 0, len(points))
        voxel_m = state.voxels.voxel_m
        chosen = first_of_voxels(points, 0.5 * voxel_m)
        points, times_s = points[chosen], times_s[chosen]
        source = first_of_voxels(points, params.source_voxels * voxel_m)
        twist = state.twist_per_s
        sigma_m = self._sigma_m()
        pose, steps, partners = self._aligned(points[source], times_s[source], twist, prediction, sigma_m)
        if times_s.any():
            # The motion that was found says better how the scan was bent than the prediction did.
            twist = logarithm(inverted(state.pose) @ pose) / period_s
            pose, more, partners = self._aligned(points[source], times_s[source], twist, pose, sigma_m)
            steps += more
        deviation = inverted(prediction) @ pose
        self._learn(deviation, float(np.mean(np.linalg.norm(points[source], axis=1))))
        pose = self._rested(pose)
        twist = logarithm(inverted(state.pose) @ pose) / period_s
        if self._has_moved(pose):
            straight = deskewed(points, times_s, twist) if times_s.any() else points
            add_points(state.voxels, straight @ pose[:3, :3].T + pose[:3, 3])
            self._remove_far(pose)
            state.added = pose.copy()
        return self._taken(cloud.stamp_ns, pose, twist, steps, partners, len(source))

    def _aligned(
        self, points: Array, times_s: Array, twist: Array, guess: Array, sigma_m: float
    ) -> tuple[Array, int, int]:
        params = self.params
        straight = deskewed(points, times_s, twist) if times_s.any() else points
        return align(
            straight, self.state.voxels, guess, 3.0 * sigma_m, sigma_m, params.steps_max, params.step_min
        )

    def _rested(self, pose: Array) -> Array:
        """The pose, or while the sensor stands the one at which it came to a stand.

        The alignment of a sensor that stands is off by some millimetres, and differently so in each scan.
        """
        params, state = self.params, self.state
        if _is_apart(state.rest, pose, params.still_m, params.still_rad):
            state.rest, state.rest_scans = pose.copy(), 0
            return pose
        state.rest_scans += 1
        if state.rest_scans < params.still_scans:
            return pose
        if state.rest_scans == params.still_scans:
            state.rest = pose.copy()
        rest: Array = state.rest.copy()
        return rest

    def _has_moved(self, pose: Array) -> bool:
        """Whether a scan from here shows anything new.

        A vehicle that stands would fill its voxels with the same rings, of which no surface can be made.
        """
        return _is_apart(self.state.added, pose, self.params.new_m, self.params.new_rad)

    def _period_ns(self, stamp_ns: int) -> int:
        before_ns = self.state.stamp_ns
        if before_ns is None or not 0 < stamp_ns - before_ns <= _GAP_NS_MAX:
            return self.params.period_ns
        return stamp_ns - before_ns

    def _taken(
        self, stamp_ns: int, pose: Array, twist: Array | None, steps: int, partners: int, points: int
    ) -> OdometryStep:
        state = self.state
        state.pose, state.stamp_ns = pose, stamp_ns
        if twist is not None:
            state.twist_per_s = twist
        return OdometryStep(stamp_ns, pose.copy(), steps, partners, points)

    def _sigma_m(self) -> float:
        """How far predictions were off so far, root mean square (KISS-ICP, eq. 9)."""
        state, params = self.state, self.params
        if state.deviations == 0:
            return params.threshold_m
        return max(math.sqrt(state.deviations_m2 / state.deviations), params.threshold_m_min)

    def _learn(self, deviation: Array, range_m: float) -> None:
        params, state = self.params, self.state
        angle_rad = float(np.linalg.norm(logarithm(deviation)[3:]))
        # A turn moves points at this range by as much.
        total_m = 2.0 * range_m * math.sin(0.5 * angle_rad) + float(np.linalg.norm(deviation[:3, 3]))
        if total_m > params.motion_m_min:
            state.deviations_m2 += total_m * total_m
            state.deviations += 1

    def _remove_far(self, pose: Array) -> None:
        params, state = self.params, self.state
        if np.linalg.norm(pose[:3, 3] - state.removed_m) > _REMOVAL_SHARE * params.range_m_max:
            remove_far(state.voxels, pose[:3, 3], params.range_m_max)
            state.removed_m = pose[:3, 3].copy()


def _is_apart(one: Array, other: Array, apart_m: float, apart_rad: float) -> bool:
    moved = np.abs(logarithm(inverted(one) @ other))
    return bool(moved[:3].max() > apart_m or moved[3:].max() > apart_rad)


def _voxel_m(points: Array, params: OdometryParams) -> float:
    mean_m = float(np.mean(np.linalg.norm(points, axis=1)))
    return min(max(params.voxel_share * mean_m, params.voxel_m_min), params.voxel_m_max)


def _usable(cloud: PointCloud, params: OdometryParams) -> tuple[Array, Array]:
    """(points (n, 3), times (n,) s after the stamp) that are finite and in range."""
    points = cloud.points_sensor.astype(np.float64)
    squared = np.einsum("ij,ij->i", points, points)
    # A comparison with NaN is false.
    usable = (squared >= params.range_m_min**2) & (squared <= params.range_m_max**2)
    return points[usable], 1e-9 * cloud.offsets_ns[usable]
