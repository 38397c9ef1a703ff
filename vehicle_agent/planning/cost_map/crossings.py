"""Crossings: what an infrastructure camera's report may change, and when a stop may be skipped.

After NUS, section V.

Where the vehicle cannot see for itself, a camera's report never makes it go faster than without the camera.
"""

import math
from typing import Literal

import msgspec

from contract.geometry import Array
from contract.roads.areas import AreaAhead
from vehicle_agent.planning.cost_map.cost_map import CostMap, seen_in
from vehicle_agent.planning.waypoint.approach import Approach
from vehicle_agent.planning.waypoint.selector import SpeedCommand
from vehicle_agent.signals import PedestrianPresence


class CrossingState(msgspec.Struct, frozen=True):
    """What is remembered of the crossing ahead.

    number   of the pass along the line
    clear    observations in a row that found it free
    spared   the vehicle may enter it without another stop
    """

    number: int = -1
    clear: int = 0
    spared: bool = False


class CrossingRule(msgspec.Struct, frozen=True):
    """stops "never": go as the cost map allows, slower where a camera reports people.
    "always": stop before every crossing, and go when it is observed free (the paper's baseline).
    "untold": the same, but a fresh report that it is free spares the stop where the vehicle observes it free
    too.

    reported_mps  past an occupied crossing, from its stop line on
    known_min     share of a crossing's ground that must be known to call it free
    clear_looks   this many observations in a row must find it free after a stop
    standing_mps, near_m   slower and nearer than this the vehicle has stopped for it
    spare_m       a stop is spared no earlier than this far before the line
    """

    stops: Literal["never", "always", "untold"] = "never"
    reported_mps: float = 0.8
    known_min: float = 0.9
    clear_looks: int = 5
    standing_mps: float = 0.1
    near_m: float = 0.8
    spare_m: float = 12.0

    def observe(
        self,
        state: CrossingState,
        number: int,
        area: AreaAhead,
        outline: Array,
        costs: CostMap,
        reported: PedestrianPresence | None,
        stop_m: float,
        speed_mps: float,
    ) -> CrossingState:
        """The state after one observation.

        stop_m: bumper to stop line; beyond the line the decision stands.
        """
        if state.number != number:
            state = CrossingState(number)
        if stop_m < -0.3:
            return msgspec.structs.replace(state, spared=True)
        known, taken = seen_in(costs.cells, costs.column, costs.row, outline)
        free = (
            costs.known
            and known >= self.known_min
            and taken == 0
            and (reported is None or reported.count == 0)
        )
        clear = state.clear + 1 if free else 0
        has_stopped = speed_mps < self.standing_mps and stop_m < self.near_m
        is_told = self.stops == "untold" and reported is not None and stop_m < self.spare_m
        may_go = clear >= self.clear_looks and (has_stopped or state.spared or is_told)
        return CrossingState(number, clear, may_go)

    def command(
        self,
        state: CrossingState,
        reported: PedestrianPresence | None,
        stop_m: float,
        speed_mps: float,
        approach: Approach,
    ) -> SpeedCommand | None:
        """The command to stop before the line, or to pass it slowly; None for neither."""
        if self.stops != "never" and not state.spared:
            return approach.command(stop_m, speed_mps, "crossing")
        if reported is None or reported.count == 0:
            return None
        return self._slowed(stop_m, speed_mps, approach)

    def _slowed(self, stop_m: float, speed_mps: float, approach: Approach) -> SpeedCommand:
        """Down to reported_mps at the stop line: as before a stop, but to a speed instead of to rest."""
        free_m = max(stop_m - (approach.delay_s + approach.ramp_s) * speed_mps, 0.0)
        allowed_mps = math.sqrt(self.reported_mps**2 + 2.0 * approach.decel_mps2 * free_m)
        needed_mps2 = max(speed_mps**2 - self.reported_mps**2, 0.0) / (2.0 * max(free_m, 0.3))
        share = min(max(2.0 * needed_mps2 / approach.decel_mps2 - 1.0, 0.0), 1.0)
        slope_mps2 = -share * min(needed_mps2, 1.5 * approach.decel_mps2)
        return SpeedCommand("reported_pedestrians", allowed_mps, slope_mps2)
