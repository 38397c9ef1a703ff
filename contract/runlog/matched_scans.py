"""Scans that localization compared with its map, as run logs keep them: thinned, once a second.

No room reads them, so they are no part of a run's input tape, and a replay does without.
"""

from typing import Annotated

import msgspec
import numpy as np

from contract.geometry import Array, Pose2

# Of one scan: 2,000 points take 13 kB of JSON before the log compresses them.
POINTS_MAX = 2_000
# What a point says: it lies on the map, on something that the map has not, or beyond a wall of the map.
AGREES, NEW, THROUGH = range(3)
# Points are this near to the vehicle, so that centimetres fit into 16 bits.
REACH_M = 320.0


class MatchedScan(msgspec.Struct, frozen=True, tag="matched_scan"):
    """One scan at the pose at which the map agrees best.

    stamp_ns    of the scan; pose_map: of the vehicle then; agreement: as in its `ScanPose`
    offsets_cm  int16, little-endian: x0, y0, x1, y1, ... from the pose's place along the map's axes
    kinds       uint8 of each point: AGREES, NEW or THROUGH
    """

    stamp_ns: int
    pose_map: Pose2
    agreement: float
    offsets_cm: Annotated[bytes, msgspec.Meta(max_length=4 * POINTS_MAX)]
    kinds: Annotated[bytes, msgspec.Meta(max_length=POINTS_MAX)]


def matched_scan(
    stamp_ns: int, pose_map: Pose2, agreement: float, points_map: Array, kinds: np.ndarray
) -> MatchedScan:
    """points_map (n, 2); kinds (n,); of more than POINTS_MAX every second, third ... is kept."""
    step = max(1, -(-len(kinds) // POINTS_MAX))
    offsets_m = points_map[::step] - [pose_map.x_m, pose_map.y_m]
    near = np.abs(offsets_m).max(axis=1, initial=0.0) < REACH_M
    offsets_cm = np.rint(100.0 * offsets_m[near]).astype("<i2")
    chosen = kinds[::step][near].astype(np.uint8)
    return MatchedScan(stamp_ns, pose_map, agreement, offsets_cm.tobytes(), chosen.tobytes())


def points_of(scan: MatchedScan) -> tuple[Array, np.ndarray]:
    """(points (n, 2) in the map frame, kinds (n,)); what has no partner at the end is left out."""
    kinds = np.frombuffer(scan.kinds, dtype=np.uint8)
    count = min(len(kinds), len(scan.offsets_cm) // 4)
    offsets = np.frombuffer(scan.offsets_cm[: 4 * count], dtype="<i2").reshape(-1, 2)
    points: Array = 0.01 * offsets + np.array([scan.pose_map.x_m, scan.pose_map.y_m])
    return points, kinds[:count]
