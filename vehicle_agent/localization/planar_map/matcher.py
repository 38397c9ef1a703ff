"""Planar scans as their driver hands them over, compared with the occupancy map."""

import numpy as np

from contract.geometry import Array, Pose2
from contract.runlog.matched_scans import MatchedScan
from vehicle_agent.localization.planar_map.field_window import OccupancyTiles
from vehicle_agent.localization.planar_map.localizer import PlanarLocalizer, PlanarLocalizerParams
from vehicle_agent.signals import LocalizationJob, ScanAnswer
from vehicle_agent.signals.laser_scan import LaserScan
from vehicle_agent.signals.point_cloud import PointCloud


class PlanarMatcher:
    """The `ScanMatcher` of the occupancy map."""

    def __init__(
        self, tiles: OccupancyTiles, T_base_laser: Pose2, step_rad: float, seed: int,
        params: PlanarLocalizerParams | None = None,
    ) -> None:  # fmt: skip
        """step_rad: between two beams of the scanner."""
        self.localizer = PlanarLocalizer(tiles, T_base_laser, seed, params)
        self._laser, self._step_rad = T_base_laser, step_rad

    def step(self, cloud: PointCloud, job: LocalizationJob) -> ScanAnswer:
        """See `ScanMatcher`."""
        scan = laser_scan(cloud.stamp_ns, cloud.points_sensor, self._laser, self._step_rad)
        return self.localizer.step(scan, job)

    def take_matched(self) -> MatchedScan | None:
        """See `ScanMatcher`. Planar scans are not kept: particles agree with many poses at once."""
        return None


def laser_scan(stamp_ns: int, points_base: Array, T_base_laser: Pose2, step_rad: float) -> LaserScan:
    """The scan of points (n, 3), base frame: a beam each step_rad of a whole turn, without a return where
    no point is. Points that are not finite are no return."""
    x, y = points_base[:, 0] - T_base_laser.x_m, points_base[:, 1] - T_base_laser.y_m
    angles = np.arctan2(y, x) - T_base_laser.yaw_rad
    angles = np.asarray(np.pi - np.mod(np.pi - angles, 2.0 * np.pi), dtype=np.float64)
    ranges = np.hypot(x, y).astype(np.float64)
    beams = round(2.0 * np.pi / step_rad)
    angles_rad: Array = step_rad * (np.arange(beams, dtype=np.float64) - beams // 2)
    ranges_m: Array = np.full(beams, np.inf)
    seen = np.flatnonzero(np.isfinite(ranges) & (ranges > 0.0))
    # The farther of two on one beam is written first.
    seen = seen[np.argsort(-ranges[seen], kind="stable")]
    at = np.clip(np.rint(angles[seen] / step_rad).astype(np.int64) + beams // 2, 0, beams - 1)
    ranges_m[at], angles_rad[at] = ranges[seen], angles[seen]
    return LaserScan(stamp_ns, ranges_m, angles_rad)
