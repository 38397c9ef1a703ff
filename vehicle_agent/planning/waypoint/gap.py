"""The gap to the fleet vehicle ahead on the same line."""

import msgspec
import numpy as np

from contract.geometry import Array, project, transform_points
from vehicle_agent.planning.waypoint.selector import SpeedCommand
from vehicle_agent.signals import FleetVehicle, LeadVehicle


class GapRule(msgspec.Struct, frozen=True):
    """v = (gap - standstill) / time gap.

    beside_m  a fleet vehicle whose whole outline is farther than this from the line is not in the way
    """

    body_front_m: float
    body_back_m: float
    body_half_width_m: float
    standstill_m: float = 5.0
    time_gap_s: float = 2.0
    look_m: float = 40.0
    beside_m: float = 1.2

    def lead(
        self, points: Array, s: Array, s_m: float, first: int, others: tuple[FleetVehicle, ...]
    ) -> LeadVehicle | None:
        """The nearest fleet vehicle ahead.

        points (n, 2) and s (n,) of the line; `first` the segment of s_m.
        """
        found: LeadVehicle | None = None
        last = first
        while last < len(s) - 1 and s[last] < s_m + self.look_m:
            last += 1
        for other in others:
            tail_m = self._tail_m(points, s, s_m, (first, last), other)
            if tail_m is None:
                continue
            gap_m = tail_m - s_m - self.body_front_m
            if found is None or gap_m < found.gap_m:
                found = LeadVehicle(other.vehicle_id, gap_m, other.speed_mps)
        return found

    def _tail_m(
        self, points: Array, s: Array, s_m: float, segments: tuple[int, int], other: FleetVehicle
    ) -> float | None:
        """Where along the line the vehicle's outline begins; None when it is beside the line, behind or
        beyond.

        A vehicle that crosses the line has corners on both sides of it, or one near it.
        """
        pose = other.pose_map
        outline = transform_points(pose, self._outline())
        projected = [project(points, s, x_m, y_m, *segments) for x_m, y_m in outline]
        along = [float(along_m) for along_m, _, _ in projected]
        beside = [float(beside_m) for _, beside_m, _ in projected]
        is_off = min(beside) > self.beside_m or max(beside) < -self.beside_m
        is_elsewhere = max(along) <= s_m + 0.5 or min(along) >= s[segments[1]]
        return None if is_off or is_elsewhere else min(along)

    def _outline(self) -> Array:
        """(4, 2) corners, m from the rear axle."""
        back_m, front_m, half_m = -self.body_back_m, self.body_front_m, self.body_half_width_m
        return np.array([[back_m, half_m], [back_m, -half_m], [front_m, -half_m], [front_m, half_m]])

    def command(self, lead: LeadVehicle | None) -> SpeedCommand | None:
        """The speed that keeps the gap; None without a vehicle ahead."""
        if lead is None:
            return None
        return SpeedCommand("gap", max(0.0, (lead.gap_m - self.standstill_m) / self.time_gap_s))
