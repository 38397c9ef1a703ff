"""The two safe speeds of the NUS navigation module (section IV-B): by steering and by cost ahead."""

import math

import msgspec

from contract.geometry import Array
from vehicle_agent.planning.cost_map.cost_map import CostMap, ahead_of
from vehicle_agent.planning.waypoint.selector import SpeedCommand


class SafeSpeeds(msgspec.Struct, frozen=True):
    """Both fall off exponentially; the paper gives the form and no constants.

    steer_scale_rad  v = v_max exp(-|steer| / scale): at 1 rad a cart with 1.65 m of wheelbase keeps 0.5 m/s2
                     of lateral acceleration up to its lock
    cost_scale       v = v_max exp(-mean cost / scale); one person on the path makes a mean of about 0.12
    ahead_m          the fixed distance ahead of the bumper over which costs are averaged
    unknown_cost     of a cell that has not been seen
    side_m           by which the projected cart is wider than the cart
    """

    speed_mps_max: float = 2.0
    steer_scale_rad: float = 1.0
    cost_scale: float = 0.15
    ahead_m: float = 6.0
    unknown_cost: float = 0.1
    side_m: float = 0.2

    def by_steering(self, steer_rad: float) -> SpeedCommand:
        """The speed for a front-wheel angle."""
        return SpeedCommand("steering", self.speed_mps_max * math.exp(-abs(steer_rad) / self.steer_scale_rad))

    def by_cost(self, mean_cost: float) -> SpeedCommand:
        """The speed for a normalized mean cost of 0..1."""
        return SpeedCommand("cost_map", self.speed_mps_max * math.exp(-mean_cost / self.cost_scale))

    def mean_cost(self, costs: CostMap, poses: Array, front_m: float, half_width_m: float) -> float:
        """Over the ground that the cart will cover along (k, 3) base poses, 0..1."""
        half_m = half_width_m + self.side_m
        return float(
            ahead_of(costs.cells, costs.column, costs.row, poses, front_m, half_m, self.unknown_cost)
        )
