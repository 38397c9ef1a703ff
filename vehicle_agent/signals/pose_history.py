"""The vehicle's recent poses: a percept arrives later than its scan."""

import itertools

from contract.geometry import Pose2, wrap_angle

# (stamp_ns, pose_map), oldest first.
PoseHistory = tuple[tuple[int, Pose2], ...]


def pose_at(poses: tuple[tuple[int, Pose2], ...], stamp_ns: int) -> Pose2:
    """The pose at a stamp, interpolated; outside the stored time the nearest one."""
    if stamp_ns <= poses[0][0]:
        return poses[0][1]
    for (before_ns, before), (after_ns, after) in itertools.pairwise(poses):
        if before_ns <= stamp_ns <= after_ns:
            t = (stamp_ns - before_ns) / (after_ns - before_ns)
            return Pose2(
                before.x_m + t * (after.x_m - before.x_m),
                before.y_m + t * (after.y_m - before.y_m),
                wrap_angle(before.yaw_rad + t * wrap_angle(after.yaw_rad - before.yaw_rad)),
            )
    return poses[-1][1]
