"""Keeping away from the fleet mate ahead on the same line."""

import msgspec

from contract.geometry import Array, project
from vehicle_agent.planning.selector import SpeedCommand
from vehicle_agent.signals import LeadVehicle, OtherVehicle


class GapRule(msgspec.Struct, frozen=True):
    """v = (gap - standstill) / time gap.

    beside_m  a mate whose rear axle is farther than this from the line is not on it
    """

    body_front_m: float
    body_back_m: float
    standstill_m: float = 5.0
    time_gap_s: float = 2.0
    look_m: float = 40.0
    beside_m: float = 1.8

    def lead(
        self, points: Array, s: Array, s_m: float, first: int, others: tuple[OtherVehicle, ...]
    ) -> LeadVehicle | None:
        """The nearest fleet mate ahead. points (n, 2) and s (n,) of the line; `first` the segment of s_m."""
        found: LeadVehicle | None = None
        last = first
        while last < len(s) - 1 and s[last] < s_m + self.look_m:
            last += 1
        for other in others:
            pose = other.pose_map
            along_m, beside_m, _ = project(points, s, pose.x_m, pose.y_m, first, last)
            gap_m = float(along_m) - self.body_back_m - s_m - self.body_front_m
            if abs(beside_m) > self.beside_m or along_m <= s_m + 0.5:
                continue
            if found is None or gap_m < found.gap_m:
                found = LeadVehicle(other.vehicle_id, gap_m, other.speed_mps)
        return found

    def command(self, lead: LeadVehicle | None) -> SpeedCommand | None:
        """The speed that keeps the gap; None without a mate ahead."""
        if lead is None:
            return None
        return SpeedCommand("gap", max(0.0, (lead.gap_m - self.standstill_m) / self.time_gap_s))
