"""Dead reckoning: every scan's pose by lidar odometry, and the scans of which the map is made."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

import msgspec
import numpy as np

from contract.geometry import Array
from vehicle_agent.localization.odometry.lidar_odometry import LidarOdometry
from vehicle_agent.localization.odometry.motion import deskewed, inverted, logarithm
from vehicle_agent.localization.odometry.voxel_map import Array32, first_of_voxels
from vehicle_agent.signals.point_cloud import PointCloud


class KeyframeParams(msgspec.Struct, frozen=True):
    """Which scans become keyframes, and what is kept of them.

    step_m, step_rad         a keyframe after so much of the way, or of a turn
    thinned_m                edge of the voxels of which one point each is kept
    range_m_min, range_m_max nearer points are the vehicle; farther ones blur with small errors of direction
    partners_min             share of points with a partner below which a scan's pose is called poor
    """

    step_m: float = 1.0
    step_rad: float = 0.15
    thinned_m: float = 0.2
    range_m_min: float = 2.0
    range_m_max: float = 60.0
    partners_min: float = 0.4


@dataclass(slots=True, eq=False)
class Reckoned:
    """A drive by dead reckoning; the frame is the first scan's sensor.

    stamps_ns    (n,) of all scans; keyframe_of (n,): the keyframe before each
    relatives    (n, 4, 4) T_keyframe_scan
    poses        (k, 4, 4) of the keyframes; keyframes (k,): their scans
    clouds       k arrays (m, 3) float32, straightened, in the sensor's frame
    scans_empty  scans without enough points, whose pose is the predicted one
    scans_poor   scans of which few points had a partner
    stamps_back  scans whose stamp did not rise
    """

    stamps_ns: list[int] = field(default_factory=list)
    keyframe_of: list[int] = field(default_factory=list)
    relatives: list[Array] = field(default_factory=list)
    poses: list[Array] = field(default_factory=list)
    keyframes: list[int] = field(default_factory=list)
    clouds: list[Array32] = field(default_factory=list)
    scans_empty: int = 0
    scans_poor: int = 0
    stamps_back: int = 0


def reckoned(scans: Iterable[PointCloud], params: KeyframeParams, advance: Callable[[int], None]) -> Reckoned:
    """All scans in order; what the reader of the scans raises goes on to the caller."""
    odometry, drive = LidarOdometry(), Reckoned()
    for cloud in scans:
        is_late = bool(drive.stamps_ns) and cloud.stamp_ns <= drive.stamps_ns[-1]
        step = odometry.step(cloud)
        drive.scans_empty += step.partners == 0 and bool(drive.stamps_ns)
        drive.scans_poor += 0 < step.partners < params.partners_min * step.points
        drive.stamps_back += is_late
        if not drive.poses or _is_far(drive.poses[-1], step.pose, params):
            twist = odometry.state.twist_per_s if drive.poses else np.zeros(6)
            points = _kept(cloud, twist, params)
            # A blind scan shows nothing; the next one that sees takes its place.
            if len(points) or not drive.poses:
                drive.poses.append(step.pose)
                drive.keyframes.append(len(drive.stamps_ns))
                drive.clouds.append(points)
        drive.stamps_ns.append(cloud.stamp_ns)
        drive.keyframe_of.append(len(drive.poses) - 1)
        drive.relatives.append(inverted(drive.poses[-1]) @ step.pose)
        advance(1)
    return drive


def scan_poses(drive: Reckoned, poses: Array) -> Array:
    """(n, 4, 4) of all scans, from poses (k, 4, 4) of the keyframes: spread between two by dead reckoning."""
    keyframes = np.array(drive.keyframe_of)
    found: Array = poses[keyframes] @ np.array(drive.relatives)
    following = np.minimum(keyframes + 1, len(poses) - 1)
    ends = np.array(drive.keyframes)
    for number in range(len(poses) - 1):
        first, last = ends[number], ends[number + 1]
        # What the graph moved the next keyframe by against dead reckoning grows along the scans between.
        reached = poses[number] @ inverted(drive.poses[number]) @ drive.poses[number + 1]
        share = np.arange(last - first) / (last - first)
        found[first:last, :3, 3] += share[:, None] * (poses[following[first], :3, 3] - reached[:3, 3])
    return found


def _is_far(from_: Array, to: Array, params: KeyframeParams) -> bool:
    moved = logarithm(inverted(from_) @ to)
    return bool(np.linalg.norm(moved[:3]) >= params.step_m or np.linalg.norm(moved[3:]) >= params.step_rad)


def _kept(cloud: PointCloud, twist_per_s: Array, params: KeyframeParams) -> Array32:
    points = cloud.points_sensor.astype(np.float64)
    squared = np.einsum("ij,ij->i", points, points)
    # A comparison with NaN is false.
    usable = (squared >= params.range_m_min**2) & (squared <= params.range_m_max**2)
    points, times_s = points[usable], 1e-9 * cloud.offsets_ns[usable]
    if times_s.any():
        points = deskewed(points, times_s, twist_per_s)
    kept: Array32 = points[first_of_voxels(points, params.thinned_m)].astype(np.float32)
    return kept
