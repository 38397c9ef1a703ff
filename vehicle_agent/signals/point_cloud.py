"""A lidar scan, the same from every source: packets, files and bags."""

import msgspec
import numpy as np


class PointCloud(msgspec.Struct, frozen=True):
    """One scan of one lidar.

    stamp_ns       of the scan, in the clock of its source
    points_sensor  (n, 3) float32, metres, in the sensor's frame as its maker defines it
    intensities    (n,) float32, 0 where the source has none
    rings          (n,) uint16, 0 the lowest beam; 0 where the source has none
    offsets_ns     (n,) int64, the time of each point after stamp_ns; all 0 where the source has no times
    """

    stamp_ns: int
    points_sensor: np.ndarray
    intensities: np.ndarray
    rings: np.ndarray
    offsets_ns: np.ndarray

    def __len__(self) -> int:
        return len(self.points_sensor)

    def selected(self, chosen: np.ndarray) -> "PointCloud":
        """The points that `chosen` names: (n,) bool or indices."""
        return PointCloud(
            self.stamp_ns,
            self.points_sensor[chosen],
            self.intensities[chosen],
            self.rings[chosen],
            self.offsets_ns[chosen],
        )


def point_cloud(
    stamp_ns: int,
    points_sensor: np.ndarray,
    intensities: np.ndarray | None = None,
    rings: np.ndarray | None = None,
    offsets_ns: np.ndarray | None = None,
) -> PointCloud:
    """A cloud of these points (n, 3); what the source does not have is 0."""
    count = len(points_sensor)
    return PointCloud(
        stamp_ns,
        np.ascontiguousarray(points_sensor, dtype=np.float32).reshape(count, 3),
        np.zeros(count, dtype=np.float32) if intensities is None else intensities.astype(np.float32),
        np.zeros(count, dtype=np.uint16) if rings is None else rings.astype(np.uint16),
        np.zeros(count, dtype=np.int64) if offsets_ns is None else offsets_ns.astype(np.int64),
    )
