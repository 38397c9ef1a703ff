"""The scans that a localizer has placed, once a second, for run logs: which points lie on the map."""

from contract.geometry import Array
from contract.runlog.matched_scans import MatchedScan, matched_scan
from vehicle_agent.localization.scan_map.matching import Match, MatchParams
from vehicle_agent.localization.scan_map.rays import point_kinds
from vehicle_agent.localization.scan_map.surfel_index import SurfelIndex
from vehicle_agent.signals.arriving import ScanPose

_EVERY_NS = 1_000_000_000


class MatchedScans:
    """Give it every placed scan; it keeps those that are due."""

    def __init__(self) -> None:
        self._newest: MatchedScan | None = None
        self._kept_ns: int | None = None

    def take(self) -> MatchedScan | None:
        """The scan that was kept since the last call; each is given once."""
        taken, self._newest = self._newest, None
        return taken

    def add(
        self, placed: ScanPose, points: Array, match: Match, index: SurfelIndex, params: MatchParams
    ) -> None:
        """points (n, 3) of the scan, sensor frame."""
        if self._kept_ns is not None and 0 <= placed.stamp_ns - self._kept_ns < _EVERY_NS:
            return
        self._kept_ns = placed.stamp_ns
        kinds = point_kinds(
            points, match.pose, index.voxel_m, index.keys, index.elements, params.reach_m, params.inlier_m
        )
        points_map: Array = points @ match.pose[:2, :3].T + match.pose[:2, 3]
        self._newest = matched_scan(placed.stamp_ns, placed.pose_map, placed.agreement, points_map, kinds)
