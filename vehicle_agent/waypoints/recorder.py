"""Records waypoints during a drive (GEM, section IV)."""

import math

import msgspec

from contract.geometry import Pose2
from vehicle_agent.signals import Ego

_NO_TURN_RADPS = 1e-3


class Waypoint(msgspec.Struct, frozen=True):
    """A place on the driven path, map frame; speed_mps is the driver's, radius_m the curve's."""

    x_m: float
    y_m: float
    speed_mps: float
    radius_m: float


class WaypointRecorder:
    """Records a waypoint every `spacing_m`; poses that are not valid are skipped."""

    def __init__(self, spacing_m: float = 1.0) -> None:
        if spacing_m <= 0.0:
            raise ValueError("waypoints need a spacing above 0 m")
        self._spacing_m = spacing_m
        self._last: Pose2 | None = None
        self.waypoints: list[Waypoint] = []

    def observe(self, ego: Ego) -> None:
        """Takes the pose of a tick."""
        if not ego.valid:
            return
        pose = ego.pose_map
        last = self._last
        if last is not None and math.hypot(pose.x_m - last.x_m, pose.y_m - last.y_m) < self._spacing_m:
            return
        self._last = pose
        radius_m = turn_radius_m(ego.speed_mps, ego.yaw_rate_radps)
        self.waypoints.append(Waypoint(pose.x_m, pose.y_m, ego.speed_mps, radius_m))


def turn_radius_m(speed_mps: float, yaw_rate_radps: float) -> float:
    """r = v / omega; inf on a straight (GEM, section IV, where v x omega is a misprint)."""
    turn_radps = abs(yaw_rate_radps)
    return math.inf if turn_radps < _NO_TURN_RADPS else abs(speed_mps) / turn_radps
