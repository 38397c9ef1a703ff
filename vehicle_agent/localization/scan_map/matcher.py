"""Scans as the lidars' driver hands them over, compared with the map of surfaces."""

import numpy as np

from contract.runlog.matched_scans import MatchedScan
from vehicle_agent.localization.scan_map.localizer import (
    LocalizerParams,
    ScanLocalizer,
    ScanPrior,
    TileSource,
)
from vehicle_agent.signals import LocalizationJob, ScanAnswer, ScanUnplaced
from vehicle_agent.signals.point_cloud import PointCloud

# Returns this near to the outline are the vehicle's own.
_BODY_MARGIN_M = 0.2


class SurfaceMatcher:
    """The `ScanMatcher` of the map of surfaces: points of the vehicle itself are left out."""

    def __init__(
        self, tiles: TileSource, tile_m: float, voxel_m: float, body_m: tuple[float, float, float],
        params: LocalizerParams | None = None,
    ) -> None:  # fmt: skip
        """body_m: the outline's front, back (both from the rear axle, positive) and half width."""
        # The driver has moved the points to the base frame.
        self._localizer = ScanLocalizer(tiles, tile_m, voxel_m, np.eye(4), params)
        self._front_m, self._back_m, self._half_m = (size + _BODY_MARGIN_M for size in body_m)

    def step(self, cloud: PointCloud, job: LocalizationJob) -> ScanAnswer:
        """See `ScanMatcher`."""
        x, y = cloud.points_sensor[:, 0], cloud.points_sensor[:, 1]
        own = (-self._back_m < x) & (x < self._front_m) & (np.abs(y) < self._half_m)
        prior = ScanPrior(job.pose_map, job.covariance, job.speed_mps, job.yaw_rate_radps, job.is_lost)
        found = self._localizer.step(cloud.selected(~own), prior)
        if found is not None:
            return found
        return ScanUnplaced(cloud.stamp_ns, "too_little" if self._localizer.has_map else "no_map")

    def take_matched(self) -> MatchedScan | None:
        """See `ScanMatcher`."""
        return self._localizer.matched.take()
