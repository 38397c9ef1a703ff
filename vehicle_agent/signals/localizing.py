"""What localization asks of its worker: a process of its own that compares scans with a map."""

import msgspec
import numpy as np

from contract.geometry import Pose2

# A slower vehicle stands: an operator may tell it where it is.
_STANDING_MPS = 0.05


class PoseHint(msgspec.Struct, frozen=True):
    """An operator says where the vehicle stands.

    hint_id  a repeat changes nothing
    """

    hint_id: str
    pose_map: Pose2


def takes_hints(speed_mps: float) -> bool:
    """Whether a vehicle of this speed stands, so that the place that a hint names is still its own."""
    return abs(speed_mps) < _STANDING_MPS


class LocalizationJob(msgspec.Struct, frozen=True, tag="localization_job"):
    """Where the vehicle is by all that the tick knows; a worker compares the newest scan with its map there.

    stamp_ns    of the tick
    pose_map    of the rear axle's centre
    pose_odom   the same in a frame that nothing corrects: differences between jobs are the vehicle's way
    covariance  (3, 3) of x, y, yaw of pose_map
    speed_mps, yaw_rate_radps  of the vehicle
    is_lost     whether a wider search is worth its time
    is_unknown  nothing has told the vehicle's place yet: pose_map and covariance say nothing
    """

    stamp_ns: int
    pose_map: Pose2
    pose_odom: Pose2
    covariance: np.ndarray
    speed_mps: float
    yaw_rate_radps: float
    is_lost: bool = False
    is_unknown: bool = False
