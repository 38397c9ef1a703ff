"""The log by dead reckoning: keyframes, the edges between them, and every scan beside its keyframe."""

from collections.abc import Callable

import msgspec
import numpy as np

from contract.geometry import Array, IntArray
from vehicle_agent.localization.laser import dead_reckoning
from vehicle_agent.localization.laser.dead_reckoning import DeadReckoningParams
from vehicle_agent.localization.laser.pose_arrays import between, composed
from vehicle_agent.localization.laser.surfaces import Surface
from workshop.carmen.laser_logs import LaserLog
from workshop.laser_mapping.pose_graph import Edge, in_axes_of


class Keyframes(msgspec.Struct, frozen=True):
    """poses (k, 3) of the laser by dead reckoning; scans (k,) their numbers in the log."""

    poses: Array
    scans: IntArray
    surfaces: tuple[Surface, ...]
    edges: tuple[Edge, ...]

    def __len__(self) -> int:
        return len(self.poses)


class DeadReckoned(msgspec.Struct, frozen=True):
    """poses (n, 3) of the laser at every scan; matched, poor: how many scans were matched, and how many of
    these with too few inliers."""

    keyframes: Keyframes
    poses: Array
    matched: int
    poor: int


def dead_reckoned(log: LaserLog, params: DeadReckoningParams, advance: Callable[[int], None]) -> DeadReckoned:
    """The whole log; `advance` is told of each scan."""
    angles_rad = log.beams.angles_rad
    mount = np.array([log.T_base_laser.x_m, log.T_base_laser.y_m, log.T_base_laser.yaw_rad])
    odometry = composed(log.odometry, mount)
    state, way_information = None, np.zeros((3, 3))
    outputs: list[dead_reckoning.DeadReckoning] = []
    scans: list[int] = []
    for number in range(len(log)):
        output, state = dead_reckoning.step(state, log.ranges_m[number], angles_rad, odometry[number], params)
        outputs.append(output)
        if output.is_keyframe or number == 0:
            scans.append(number)
        advance(1)
    poses = np.array([output.pose for output in outputs])
    key_poses = poses[scans]
    edges = []
    for last, number in enumerate(scans[1:], start=1):
        way_information = in_axes_of(key_poses[last - 1], outputs[number].information)
        edges.append(
            Edge(last - 1, last, between(key_poses[last - 1], key_poses[last]), way_information, False)
        )
    matches = [output.match for output in outputs if output.match is not None]
    keyframes = Keyframes(
        key_poses, np.array(scans), tuple(outputs[number].surface for number in scans), tuple(edges)
    )
    poor = sum(match.inlier_ratio < params.inlier_ratio_min for match in matches)
    return DeadReckoned(keyframes, poses, len(matches), poor)


def scan_poses(reckoned: DeadReckoned, keyframe_poses: Array) -> Array:
    """(n, 3) every scan's pose once its keyframes have new ones.

    Between two keyframes a scan keeps its way from both; they are blended by its place between them.
    """
    keyframes = reckoned.keyframes
    numbers = np.arange(len(reckoned.poses))
    before = np.searchsorted(keyframes.scans, numbers, side="right") - 1
    after = np.minimum(before + 1, len(keyframes) - 1)
    span = np.maximum(keyframes.scans[after] - keyframes.scans[before], 1)
    share = np.where(after > before, (numbers - keyframes.scans[before]) / span, 0.0)
    from_before = composed(keyframe_poses[before], between(keyframes.poses[before], reckoned.poses))
    from_after = composed(keyframe_poses[after], between(keyframes.poses[after], reckoned.poses))
    # The difference of the two is a small pose, which can be scaled.
    return composed(from_before, between(from_before, from_after) * share[:, None])
