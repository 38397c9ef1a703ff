"""Travel times to the same few places from anywhere: worked out once from each lane's end, then looked up."""

import math
from collections.abc import Sequence

import numpy as np
from numba import njit

from contract.geometry import Array, BoolArray, IntArray
from contract.roads.network import SAME_PLACE_M, RoadNetwork
from contract.roads.travel_times import Place


class TimesToPlaces:
    """Seconds of the fastest drive to fixed places, some sections being closed.

    places   (lane_id, s_m); closed  ids of sections that may not be entered
    `from_place` equals a row of `travel_time_matrix`. KeyError for a lane that the map does not have.
    """

    def __init__(
        self, network: RoadNetwork, places: Sequence[Place], speed_cap_mps: float, closed: frozenset[str]
    ) -> None:
        self._network = network
        self._closed = closed
        self._speed_cap_mps = speed_cap_mps
        self._on_lane: dict[str, list[tuple[int, float]]] = {}
        for number, (lane_id, s_m) in enumerate(places):
            self._on_lane.setdefault(lane_id, []).append((number, s_m))
        self._places = tuple(places)
        shut: BoolArray = np.zeros(len(network.lanes), np.bool_)
        for section_id in closed:
            shut[network.lane_numbers[network.sections[section_id].lane_id]] = True
        lane_s = network.lane_times(speed_cap_mps)
        first, before = network.lanes_before
        self._after_s: Array = np.full((len(network.lanes), len(places)), math.inf)
        for number, (lane_id, s_m) in enumerate(places):
            if network.is_open(lane_id, 0.0, s_m, closed):
                lane = network.lane_numbers[lane_id]
                entered_s = network.time_between(lane_id, 0.0, s_m, speed_cap_mps)
                _spread(first, before, lane_s, shut, lane, entered_s, self._after_s[:, number])

    def from_place(self, origin: Place) -> Array:
        """(places,) seconds; zero to the origin itself, infinite where there is no way."""
        lane_id, s_m = origin
        network, cap = self._network, self._speed_cap_mps
        times: Array = np.full(len(self._places), math.inf)
        if network.is_open(lane_id, s_m, math.inf, self._closed):
            to_end_s = network.time_between(lane_id, s_m, network.lines[lane_id].length_m, cap)
            times = self._after_s[network.lane_numbers[lane_id]] + to_end_s
        for number, there_m in self._on_lane.get(lane_id, ()):
            if (lane_id, there_m) == origin:
                times[number] = 0.0
            elif s_m <= there_m + SAME_PLACE_M and network.is_open(lane_id, s_m, there_m, self._closed):
                times[number] = network.time_between(lane_id, s_m, max(s_m, there_m), cap)
        return times


@njit(cache=True)
def _spread(
    first: IntArray,
    before: IntArray,
    lane_s: Array,
    shut: BoolArray,
    target: int,
    entered_s: float,
    after_s: Array,
) -> None:
    """Fill after_s (lanes,): seconds from the end of each lane to a place that lies entered_s into `target`.

    Label correcting with a queue: lanes before[first[n] : first[n + 1]] lead into lane n.
    """
    lanes = len(lane_s)
    queue = np.zeros(lanes + 1, np.int64)
    waiting = np.zeros(lanes, np.bool_)
    head = tail = 0
    for k in range(first[target], first[target + 1]):
        lane = before[k]
        if entered_s < after_s[lane]:
            after_s[lane] = entered_s
            queue[tail], waiting[lane] = lane, True
            tail = (tail + 1) % (lanes + 1)
    while head != tail:
        lane = queue[head]
        head = (head + 1) % (lanes + 1)
        waiting[lane] = False
        if shut[lane]:
            continue
        time_s = after_s[lane] + lane_s[lane]
        for k in range(first[lane], first[lane + 1]):
            earlier = before[k]
            if time_s < after_s[earlier]:
                after_s[earlier] = time_s
                if not waiting[earlier]:
                    queue[tail], waiting[earlier] = earlier, True
                    tail = (tail + 1) % (lanes + 1)
