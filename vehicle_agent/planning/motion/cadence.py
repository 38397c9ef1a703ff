"""When to plan again (Snow Lion, motion planning): as rarely as the road allows.

Planning too often passes the noise of localization and perception on to the wheels. Planning too rarely makes
the vehicle respond late. So a vehicle on a free road keeps its trajectory until that nears its end, and one
with road users near its way plans at every opportunity.
"""

import math

import msgspec
import numpy as np

from contract.geometry import Array
from vehicle_agent.signals import Corridor, Ego, Tracks, Trajectory, World


class Cadence(msgspec.Struct, frozen=True):
    """When to plan.

    beside_m, ahead_s, ahead_m  a road user this near to the line, this far ahead, is a reason to plan
    left_s                      a trajectory that lasts no longer than this is renewed
    deviation_m, deviation_mps  farther from the trajectory, or from its speed, the vehicle is off it
    stopped_mps                 also when it brakes from more than this while the vehicle stands already
    every_ticks                 plan at most this often: 10 Hz
    """

    beside_m: float = 5.0
    ahead_s: float = 5.0
    ahead_m: float = 12.0
    left_s: float = 3.5
    deviation_m: float = 0.4
    deviation_mps: float = 0.7
    stopped_mps: float = 0.15
    every_ticks: int = 5

    def is_near_road_users(self, world: World, corridor: Corridor, ego: Ego) -> bool:
        """A road user, or an obstacle on the line itself, is near enough to change the plan."""
        reach_m = self.ahead_m + self.ahead_s * ego.speed_mps
        if _near(corridor, world.points_map, reach_m, 0.5 * self.beside_m):
            return True
        return _near(corridor, _soon(world.tracks), reach_m, self.beside_m)

    def is_running_out(self, trajectory: Trajectory, now_ns: int) -> bool:
        """It ends soon, and not at rest."""
        rows = trajectory.rows
        left_s = float(rows[-1, 0]) - (now_ns - trajectory.stamp_ns) * 1e-9
        return left_s < self.left_s and float(rows[-1, 5]) > 0.05

    def is_off_trajectory(self, here: Array, ego: Ego) -> bool:
        """here (8,): the trajectory's row of now."""
        off_m = math.hypot(here[1] - ego.pose_map.x_m, here[2] - ego.pose_map.y_m)
        speed_mps, accel_mps2 = float(here[5]), float(here[6])
        stopped = ego.speed_mps < 0.05 and speed_mps > self.stopped_mps and accel_mps2 < 0.0
        return stopped or off_m > self.deviation_m or abs(speed_mps - ego.speed_mps) > self.deviation_mps


def _soon(tracks: Tracks) -> Array:
    """Where tracks are, and where they are in one, two and three seconds: (4 n, 2)."""
    places = [tracks.poses_map[:, :2] + t * tracks.velocities_map_mps for t in (0.0, 1.0, 2.0, 3.0)]
    soon: Array = np.vstack(places)
    return soon


def _near(corridor: Corridor, places_map: Array, reach_m: float, beside_m: float) -> bool:
    if not len(places_map) or not len(corridor.s_m):
        return False
    # Every fourth station is 2 m apart: enough to tell near from far.
    stations = corridor.points_map[(corridor.s_m - corridor.s_m[0]) <= reach_m + 8.0][::4]
    low, high = stations.min(axis=0) - beside_m, stations.max(axis=0) + beside_m
    boxed = places_map[((low <= places_map) & (places_map <= high)).all(axis=1)]
    if not len(boxed):
        return False
    apart2 = ((boxed[:, None, :] - stations[None, :, :]) ** 2).sum(axis=2)
    return bool(apart2.min() < beside_m**2)
