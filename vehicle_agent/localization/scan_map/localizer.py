"""The worker's part of scan-to-map localization: scan by scan, where the vehicle is on the map.

Snow Lion paper, section III: registration of the scan with the map's region of interest around the prior.
"""

import math
from collections.abc import Callable

import msgspec
import numpy as np

from contract.geometry import Array, Pose2, wrap_angle
from contract.point_map.tiles import Surfels, no_surfels
from vehicle_agent.localization.odometry.motion import deskewed, inverted
from vehicle_agent.localization.odometry.voxel_map import first_of_voxels
from vehicle_agent.localization.scan_map.matched_scans import MatchedScans
from vehicle_agent.localization.scan_map.matching import Match, MatchParams, in_plane, match_scan
from vehicle_agent.localization.scan_map.rays import beams_through
from vehicle_agent.localization.scan_map.search import likely_poses
from vehicle_agent.localization.scan_map.surfel_index import SurfelIndex, index_surfels
from vehicle_agent.signals.arriving import ScanPose
from vehicle_agent.signals.point_cloud import PointCloud

# The elements of tile (ix, iy), or None where the map has none. It may read a file.
TileSource = Callable[[int, int], Surfels | None]


class ScanPrior(msgspec.Struct, frozen=True):
    """Where the vehicle was at a scan's stamp, by all else.

    pose_map    of the rear axle's centre; covariance (3, 3) of x, y, yaw
    speed_mps, yaw_rate_radps  of the vehicle during the scan
    is_lost     whether a wider search is worth its time
    """

    pose_map: Pose2
    covariance: Array
    speed_mps: float
    yaw_rate_radps: float
    is_lost: bool = False


class LocalizerParams(msgspec.Struct, frozen=True):
    """The region of interest, what of a scan is used, and the search.

    around        tiles on each side of the vehicle's own
    thinned_m     edge of the voxels of which one point each is used
    range_m_min, range_m_max  of points
    above_m, above_ratio      a point so far above the road, plus a share of its distance, is above it
    up_min        fewer points above the road say nothing of the place
    prior_scale   the prior counts with so many times its variance, so that a wrong one does not hold
    prior_m, prior_rad  least deviations of the prior in the plane
    height_m, lean_rad  of height, and of roll and pitch, from one scan to the next
    near_m        a prior this sure is near: wide kernels would draw it to what has changed
    beams         so many are followed to see whether walls are in their way
    search_m, search_rad, search_step_rad  half the window of the search, and the step of its turns
    search_points, search_kept, search_aligned  points that are scored, poses that are aligned, and points
                  with which they are
    search_agreement, search_lead  of the best pose, and its lead over the second place
    """

    around: int = 2
    thinned_m: float = 0.8
    range_m_min: float = 2.0
    range_m_max: float = 50.0
    above_m: float = 0.4
    above_ratio: float = 0.03
    up_min: int = 60
    prior_scale: float = 4.0
    prior_m: float = 0.3
    prior_rad: float = 0.02
    height_m: float = 0.2
    lean_rad: float = 0.02
    near_m: float = 0.15
    beams: int = 150
    search_m: float = 10.0
    search_rad: float = 0.4
    search_step_rad: float = 0.05
    search_points: int = 120
    search_kept: int = 3
    search_aligned: int = 300
    search_agreement: float = 0.3
    search_lead: float = 0.1
    match: MatchParams = MatchParams()


class ScanLocalizer:
    """One vehicle's worker. Deterministic; it keeps the map around it, and the last height and lean.

    matched  scans that it has placed, for run logs
    """

    def __init__(
        self, tiles: TileSource, tile_m: float, voxel_m: float, T_base_sensor: Array,
        params: LocalizerParams | None = None,
    ) -> None:  # fmt: skip
        self.params = params or LocalizerParams()
        self._tiles, self._tile_m, self._voxel_m = tiles, tile_m, voxel_m
        self._mount, self._mount_back = T_base_sensor, inverted(T_base_sensor)
        self._cache: dict[tuple[int, int], Surfels] = {}
        self._at: tuple[int, int] | None = None
        self._index: SurfelIndex = index_surfels(no_surfels(), voxel_m)
        self._lean: Array = np.eye(3)
        self._height_m: float | None = None
        self.matched = MatchedScans()

    @property
    def has_map(self) -> bool:
        """Whether the map had anything around the last scan."""
        return self._index.count > 0

    def step(self, cloud: PointCloud, prior: ScanPrior) -> ScanPose | None:
        """Where the vehicle was at the scan's stamp. None: no map here, or a scan that says too little."""
        pose, params = prior.pose_map, self.params
        self._load(pose.x_m, pose.y_m)
        points, above = self._usable(cloud, prior)
        if self._index.count == 0 or above.sum() < params.up_min:
            return None
        if prior.is_lost:
            found = self._searched(points, above, pose)
            if found is not None:
                through = self._through(points, above, found)
                placed = self._scan_pose(cloud.stamp_ns, found, through, searched=True)
                self.matched.add(placed, points, found, self._index, params.match)
                return placed
        matching = params.match
        if self._is_near(prior):
            matching = msgspec.structs.replace(matching, kernel_m=matching.kernel_m[-1:])
        match = match_scan(points, above, self._index, self._guess(pose), self._information(prior), matching)
        placed = self._scan_pose(cloud.stamp_ns, match, self._through(points, above, match), searched=False)
        self.matched.add(placed, points, match, self._index, params.match)
        return placed

    def _is_near(self, prior: ScanPrior) -> bool:
        """Whether the prior is so sure that points at 20 m are where they seem to be."""
        x2, y2, yaw2 = np.diag(prior.covariance)
        return not prior.is_lost and bool(x2 + y2 + 400.0 * yaw2 < self.params.near_m**2)

    def _through(self, points: Array, above: Array, match: Match) -> float:
        """Share of the beams above the road that would have gone through walls."""
        params, index = self.params, self._index
        up = points[above > 0.0]
        # Contiguous: kernels are compiled for that, before the first scan.
        up = np.ascontiguousarray(up[:: max(1, math.ceil(len(up) / params.beams))])
        count = beams_through(
            up, match.pose, index.voxel_m, index.keys, index.elements, params.match.reach_m,
            params.match.inlier_m,
        )  # fmt: skip
        return count / len(up)

    def _load(self, x_m: float, y_m: float) -> None:
        """The tiles around a place; those that were left are forgotten."""
        at = (math.floor(x_m / self._tile_m), math.floor(y_m / self._tile_m))
        if at == self._at:
            return
        around = range(-self.params.around, self.params.around + 1)
        wanted = [(at[0] + dx, at[1] + dy) for dx in around for dy in around]
        kept: dict[tuple[int, int], Surfels] = {}
        for key in wanted:
            surfels = self._cache.get(key)
            kept[key] = (self._tiles(*key) or no_surfels()) if surfels is None else surfels
        parts = [surfels for surfels in kept.values() if len(surfels)]
        whole = joined(parts)
        self._cache, self._at, self._index = kept, at, index_surfels(whole, self._voxel_m)

    def _usable(self, cloud: PointCloud, prior: ScanPrior) -> tuple[Array, Array]:
        """(thinned points (n, 3), straightened by the prior's motion; 1.0 above the road (n,))."""
        params = self.params
        points = cloud.points_sensor.astype(np.float64)
        squared = np.einsum("ij,ij->i", points, points)
        # A comparison with NaN is false.
        near = (squared >= params.range_m_min**2) & (squared <= params.range_m_max**2)
        points, times_s = points[near], 1e-9 * cloud.offsets_ns[near]
        if times_s.any():
            turn = self._mount[:3, :3].T
            swing = prior.yaw_rate_radps
            velocity = np.array([prior.speed_mps - swing * self._mount[1, 3], swing * self._mount[0, 3], 0.0])
            twist = np.concatenate((turn @ velocity, turn @ np.array([0.0, 0.0, swing])))
            points = deskewed(points, times_s, twist)
        points = points[first_of_voxels(points, params.thinned_m)]
        based = points @ self._mount[:3, :3].T + self._mount[:3, 3]
        distance = np.hypot(based[:, 0], based[:, 1])
        above = based[:, 2] > params.above_m + params.above_ratio * distance
        return points, above.astype(np.float64)

    def _guess(self, pose: Pose2) -> Array:
        """T_map_sensor (4, 4): the vehicle stands on the map's road, and leans as it did in the last scan."""
        T: Array = np.eye(4)
        cos, sin = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
        T[:3, :3] = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]]) @ self._lean
        T[:2, 3] = pose.x_m, pose.y_m
        if self._height_m is None:
            self._height_m = self._index.ground_m(pose.x_m, pose.y_m)
        T[2, 3] = self._height_m or 0.0
        guess: Array = T @ self._mount
        return guess

    def _information(self, prior: ScanPrior) -> Array:
        """(6, 6) of the guess. The lever between axle and lidar is short beside the prior's deviations."""
        params = self.params
        covariance = params.prior_scale * prior.covariance + np.diag(
            [params.prior_m**2, params.prior_m**2, params.prior_rad**2]
        )
        information = np.diag([0.0, 0.0, params.height_m**-2, params.lean_rad**-2, params.lean_rad**-2, 0.0])
        kept = np.ix_([0, 1, 5], [0, 1, 5])
        information[kept] = np.linalg.inv(covariance)
        return information

    def _searched(self, points: Array, above: Array, pose: Pose2) -> Match | None:
        """The best pose of a window around a place, if it stands out."""
        params = self.params
        up = points[above > 0.0]
        up = up[:: max(1, len(up) // params.search_points)]
        index = self._index
        ground_m = index.ground_m(pose.x_m, pose.y_m)
        if ground_m is not None:
            self._height_m, self._lean = ground_m, np.eye(3)
        based = up @ self._mount[:3, :3].T + self._mount[:3, 3]
        window = (params.search_m, params.search_rad, params.search_step_rad)
        places = likely_poses(based, index, pose, self._height_m or 0.0, window, params.search_kept)
        loose = np.diag([1.0, 1.0, params.height_m**-2, params.lean_rad**-2, params.lean_rad**-2, 100.0])
        step = max(1, len(points) // params.search_aligned)
        few, few_above = np.ascontiguousarray(points[::step]), np.ascontiguousarray(above[::step])
        found = [
            match_scan(few, few_above, index, self._guess(place), loose, params.match) for place in places
        ]
        found.sort(key=lambda match: -match.agreement)
        best = found[0]
        others = [m for m in found if np.linalg.norm(m.pose[:2, 3] - best.pose[:2, 3]) > 1.0]
        lead = best.agreement - (others[0].agreement if others else 0.0)
        if best.agreement < params.search_agreement or lead < params.search_lead:
            return None
        fine = msgspec.structs.replace(params.match, kernel_m=params.match.kernel_m[-1:])
        return match_scan(points, above, index, best.pose, loose, fine)

    def _scan_pose(self, stamp_ns: int, match: Match, through: float, *, searched: bool) -> ScanPose:
        params, T = self.params, match.pose @ self._mount_back
        yaw_rad = math.atan2(T[1, 0], T[0, 0])
        if match.agreement > params.search_agreement:
            cos, sin = math.cos(yaw_rad), math.sin(yaw_rad)
            self._lean = np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]]) @ T[:3, :3]
            self._height_m = float(T[2, 3])
        information = in_plane(match.information + 1e-3 * np.eye(6))
        # From the sensor to the axle: the axle moves by the turn times the lever.
        lever = T[:2, 3] - match.pose[:2, 3]
        moved = np.array([[1.0, 0.0, -lever[1]], [0.0, 1.0, lever[0]], [0.0, 0.0, 1.0]])
        covariance = moved @ np.linalg.inv(information) @ moved.T
        return ScanPose(
            stamp_ns,
            Pose2(float(T[0, 3]), float(T[1, 3]), wrap_angle(yaw_rad)),
            0.5 * (covariance + covariance.T),
            match.agreement,
            match.points_up,
            searched,
            through,
        )


def joined(parts: list[Surfels]) -> Surfels:
    if not parts:
        return no_surfels()
    names = parts[0].__struct_fields__
    return Surfels(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))
