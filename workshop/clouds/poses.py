"""Files of true poses that lie beside a recording: KITTI's and TUM's."""

from pathlib import Path

import numpy as np

from contract.geometry import Array
from workshop.clouds.errors import CloudFileError

_NAMES = ("poses", "groundtruth", "ground_truth", "gt_poses", "poses_tum", "poses_kitti")
_KITTI, _TUM = 12, 8


def poses_file(recording: Path) -> Path | None:
    """The poses of a recording, a folder of scans or a bag: beside it, or in the folder."""
    folder = recording if recording.is_dir() else recording.parent
    stems = (recording.stem, f"{recording.stem}_poses", *_NAMES)
    for place in dict.fromkeys((folder, folder.parent)):
        for stem in stems:
            path = place / f"{stem}.txt"
            if path.exists():
                return path
    return None


def read_poses(path: Path) -> tuple[Array, Array | None]:
    """(poses (n, 4, 4), stamps (n,) s or None); CloudFileError.

    KITTI has 12 numbers a line, TUM time, x, y, z and a quaternion.
    """
    try:
        table = np.loadtxt(
            path, ndmin=2, delimiter="," if "," in path.read_text(encoding="utf-8")[:400] else None
        )
    except (OSError, ValueError) as error:
        raise CloudFileError(path, f"no file of poses: {error}") from error
    if not len(table) or not np.isfinite(table).all() or table.shape[1] not in (_KITTI, _TUM):
        raise CloudFileError(
            path, f"has {table.shape[1] if len(table) else 0} finite numbers a line, not 12 or 8"
        )
    poses = np.tile(np.eye(4), (len(table), 1, 1))
    if table.shape[1] == _KITTI:
        poses[:, :3] = table.reshape(-1, 3, 4)
        return poses, None
    poses[:, :3, 3] = table[:, 1:4]
    x, y, z, w = (table[:, 4:] / np.linalg.norm(table[:, 4:], axis=1)[:, None]).T
    poses[:, 0, :3] = np.column_stack((1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)))
    poses[:, 1, :3] = np.column_stack((2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)))
    poses[:, 2, :3] = np.column_stack((2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)))
    return poses, table[:, 0]
