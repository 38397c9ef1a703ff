"""KITTI's velodyne files: float32 x, y, z and intensity, one point after the other."""

from pathlib import Path

import numpy as np

from vehicle_agent.signals.point_cloud import PointCloud
from workshop.clouds.errors import CloudFileError
from workshop.clouds.fields import cloud_of_fields

_COLUMNS = ("x", "y", "z", "intensity")
# nuScenes writes the ring as a fifth column, and names its files so.
_NUSCENES_SUFFIX = ".pcd.bin"
# No lidar measures farther; floats of another format give such numbers.
_REACH_M_MAX = 10_000.0


def read_kitti_bin(path: Path, stamp_ns: int | None = None) -> PointCloud:
    """The points of such a file; CloudFileError. It has no times."""
    columns = (*_COLUMNS, "ring") if path.name.endswith(_NUSCENES_SUFFIX) else _COLUMNS
    try:
        data = path.read_bytes()
    except OSError as error:
        raise CloudFileError(path, error.strerror or "cannot be read") from error
    if len(data) % (4 * len(columns)):
        raise CloudFileError(
            path, f"{len(data)} bytes are no whole number of points of {4 * len(columns)} bytes"
        )
    table = np.frombuffer(data, dtype="<f4").reshape(-1, len(columns))
    if (np.abs(table[:, :3]) > _REACH_M_MAX).any():
        raise CloudFileError(
            path, "has points more than 10 km away: these are no float32 coordinates in metres"
        )
    return cloud_of_fields({name: table[:, k] for k, name in enumerate(columns)}, stamp_ns)
