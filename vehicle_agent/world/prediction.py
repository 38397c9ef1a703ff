"""Predicted poses of road users: people straight on, vehicles along their lanes (Snow Lion, lessons learned).

The paper found a constant velocity model and lane keeping sufficient for stable driving in shared space. A
standard deviation that grows with time describes the uncertainty.
"""

import math

import msgspec
import numpy as np
from numba import njit

from contract.geometry import Array, pose_at
from contract.roads.network import RoadNetwork
from vehicle_agent.signals import CYCLIST, PEDESTRIAN, VEHICLE, Predictions, Tracks

_LANE_KINDS = (CYCLIST, VEHICLE)
_LANE_ANGLE_RAD = 0.5


class Predictor(msgspec.Struct, frozen=True):
    """horizon_s, step_s      of the predicted times
    position_std_m           standard deviation of a track's position now
    person_std_mps, vehicle_std_mps  its growth; it ends at std_m_max
    still_mps                a slower track stands: its velocity is the tracker's noise
    lane_m, lane_mps_min     a vehicle this near to a lane's line, faster than this and along it, keeps to it
    """

    horizon_s: float = 9.0
    step_s: float = 0.25
    position_std_m: float = 0.1
    person_std_mps: float = 0.2
    vehicle_std_mps: float = 0.35
    std_m_max: float = 1.5
    still_mps: float = 0.2
    lane_m: float = 1.5
    lane_mps_min: float = 1.0

    def predictions(self, tracks: Tracks, network: RoadNetwork) -> Predictions:
        """The predictions, in the tracks' order."""
        times_s: Array = np.arange(round(self.horizon_s / self.step_s) + 1, dtype=np.float64) * self.step_s
        speeds = np.hypot(tracks.velocities_map_mps[:, 0], tracks.velocities_map_mps[:, 1])
        still = speeds < self.still_mps
        poses = straight_on(tracks.poses_map, tracks.velocities_map_mps * ~still[:, None], times_s)
        for i in range(len(tracks.ids)):
            if tracks.kinds[i] in _LANE_KINDS:
                self._keep_lane(poses[i], tracks.velocities_map_mps[i], times_s, network)
        growth_mps = np.where(tracks.kinds == PEDESTRIAN, self.person_std_mps, self.vehicle_std_mps)
        growth_mps = np.where(still, 0.5 * growth_mps, growth_mps)
        sigmas = np.minimum(self.position_std_m + growth_mps[:, None] * times_s, self.std_m_max)
        return Predictions(tracks.stamp_ns, times_s, poses, sigmas)

    def _keep_lane(self, poses: Array, velocity_mps: Array, times_s: Array, network: RoadNetwork) -> None:
        speed_mps = math.hypot(*velocity_mps)
        if speed_mps < self.lane_mps_min:
            return
        x_m, y_m = float(poses[0, 0]), float(poses[0, 1])
        course_rad = math.atan2(velocity_mps[1], velocity_mps[0])
        located = network.locate(x_m, y_m, course_rad)
        if located is None or abs(located[2]) > self.lane_m:
            return
        lane_id, s_m, d_m = located
        _, _, lane_yaw_rad = network.pose(lane_id, s_m)
        if math.cos(course_rad - lane_yaw_rad) < math.cos(_LANE_ANGLE_RAD):
            return
        points, s = _lane_ahead(network, lane_id, s_m + speed_mps * float(times_s[-1]))
        along_lane(points, s, s_m, d_m, speed_mps, times_s, poses)


def _lane_ahead(network: RoadNetwork, lane_id: str, until_m: float) -> tuple[Array, Array]:
    """((n, 2), (n,)) points of the lane and the straightest lanes after it, to until_m from its start."""
    pieces, offsets, length_m = [network.lines[lane_id].points], [network.lines[lane_id].s], 0.0
    length_m = network.lines[lane_id].length_m
    while length_m < until_m:
        successors = network.successors(lane_id)
        if not successors:
            break
        lane_id = min(successors, key=lambda name: _bend_rad(network, name))
        line = network.lines[lane_id]
        pieces.append(line.points[1:])
        offsets.append(line.s[1:] + length_m)
        length_m += line.length_m
    return np.concatenate(pieces), np.concatenate(offsets)


def _bend_rad(network: RoadNetwork, lane_id: str) -> float:
    line = network.lines[lane_id]
    turned = network.pose(lane_id, line.length_m)[2] - network.pose(lane_id, 0.0)[2]
    return abs(math.remainder(turned, math.tau))


@njit(cache=True)
def straight_on(poses: Array, velocities: Array, times: Array) -> Array:
    """(n, k, 3) poses (n, 3) extrapolated at their velocities (n, 2) to each of the times (k,)."""
    n, k = poses.shape[0], times.shape[0]
    out = np.empty((n, k, 3))
    for i in range(n):
        for j in range(k):
            out[i, j, 0] = poses[i, 0] + velocities[i, 0] * times[j]
            out[i, j, 1] = poses[i, 1] + velocities[i, 1] * times[j]
            out[i, j, 2] = poses[i, 2]
    return out


@njit(cache=True)
def along_lane(
    points: Array, s: Array, s_m: float, d_m: float, speed_mps: float, times: Array, out: Array
) -> None:
    """Fills out (k, 3) with poses along a line at constant speed, d_m to its left; straight on beyond it."""
    end = s[-1]
    for j in range(times.shape[0]):
        at = s_m + speed_mps * times[j]
        x, y, yaw = pose_at(points, s, at)
        beyond = max(0.0, at - end)
        out[j, 0] = x - d_m * math.sin(yaw) + beyond * math.cos(yaw)
        out[j, 1] = y + d_m * math.cos(yaw) + beyond * math.sin(yaw)
        out[j, 2] = yaw
