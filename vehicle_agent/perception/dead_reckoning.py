"""The vehicle's way between scans, from speed and yaw rate: the frame in which road users are tracked."""

import math

import msgspec

from contract.geometry import Pose2, compose, wrap_angle
from vehicle_agent.signals.objects import EgoMotion
from vehicle_agent.signals.pose_history import PoseHistory, pose_at

# A longer pause is a restart of the tick. The way in it is unknown, and the frame goes on where it was.
_PAUSE_NS_MAX = 400_000_000
_KEPT_NS = 1_000_000_000
# Words of the tick that are later than this leave the vehicle where it was last known to be.
_AHEAD_NS_MAX = 200_000_000


class ReckonedWay(msgspec.Struct, frozen=True):
    """Poses of the last second in a frame of its own that nothing corrects, and the newest motion."""

    poses_odom: PoseHistory = ()
    newest: EgoMotion | None = None

    def with_motion(self, motion: EgoMotion) -> "ReckonedWay":
        """The way with one tick more; a motion that is not newer changes nothing."""
        if self.newest is None:
            return ReckonedWay(((motion.stamp_ns, Pose2(0.0, 0.0, 0.0)),), motion)
        since_ns = motion.stamp_ns - self.newest.stamp_ns
        if since_ns <= 0:
            return self
        here = self.poses_odom[-1][1]
        if since_ns <= _PAUSE_NS_MAX:
            here = compose(here, _arc(self.newest, since_ns * 1e-9))
        oldest_ns = motion.stamp_ns - _KEPT_NS
        kept = tuple(entry for entry in self.poses_odom if entry[0] >= oldest_ns)
        return ReckonedWay((*kept, (motion.stamp_ns, here)), motion)

    def pose_odom(self, stamp_ns: int) -> Pose2:
        """Where the vehicle was, or is if its last known motion goes on for at most 0.2 s."""
        if self.newest is None:
            return Pose2(0.0, 0.0, 0.0)
        ahead_ns = stamp_ns - self.newest.stamp_ns
        if ahead_ns <= 0:
            return pose_at(self.poses_odom, stamp_ns)
        return compose(self.poses_odom[-1][1], _arc(self.newest, min(ahead_ns, _AHEAD_NS_MAX) * 1e-9))


def _arc(motion: EgoMotion, dt_s: float) -> Pose2:
    """The way of the rear axle at constant speed and yaw rate; the chord is right to the third order."""
    turn_rad, way_m = motion.yaw_rate_radps * dt_s, motion.speed_mps * dt_s
    return Pose2(way_m * math.cos(0.5 * turn_rad), way_m * math.sin(0.5 * turn_rad), wrap_angle(turn_rad))
