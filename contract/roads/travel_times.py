"""Travel times between many places at once."""

import heapq
import math
from collections.abc import Sequence

import numpy as np

from contract.geometry import Array
from contract.roads.network import SAME_PLACE_M, RoadNetwork

Place = tuple[str, float]


def travel_time_matrix(
    network: RoadNetwork,
    places: Sequence[Place],
    speed_cap_mps: float = math.inf,
    blocked: frozenset[str] = frozenset(),
) -> tuple[Array, Array]:
    """(times_s, lengths_m), both (n, n), of the fastest drive from each place to each other.

    places   (lane_id, s_m)
    blocked  ids of sections that may not be entered; a row's own starting section is exempt
    Zero on the diagonal; infinite where there is no way. Entries equal `find_route`'s. KeyError for a lane
    that the map does not have.
    """
    n = len(places)
    times: Array = np.full((n, n), math.inf)
    lengths: Array = np.full((n, n), math.inf)
    for i, origin in enumerate(places):
        closed = blocked - {network.section_at(*origin).section_id}
        ends = _lane_ends(network, origin, closed, speed_cap_mps)
        for j, destination in enumerate(places):
            times[i, j], lengths[i, j] = _arrival(network, origin, destination, ends, closed, speed_cap_mps)
    return times, lengths


def _lane_ends(
    network: RoadNetwork, origin: Place, closed: frozenset[str], speed_cap_mps: float
) -> dict[str, tuple[float, float]]:
    """(time_s, length_m) at the end of every lane that can be driven to its end (Dijkstra 1959)."""
    lane_id, s_m = origin
    if not network.is_open(lane_id, s_m, math.inf, closed):
        return {}
    closed_lanes = {network.sections[section_id].lane_id for section_id in closed}
    length_m = network.lines[lane_id].length_m
    first = (network.time_between(lane_id, s_m, length_m, speed_cap_mps), length_m - s_m)
    queue = [(first[0], network.lane_numbers[lane_id], first[1], lane_id)]
    settled: dict[str, tuple[float, float]] = {}
    while queue:
        time_s, _, travelled_m, reached = heapq.heappop(queue)
        if reached in settled:
            continue
        settled[reached] = (time_s, travelled_m)
        for successor in network.successors(reached):
            if successor in settled or successor in closed_lanes:
                continue
            entry = (
                time_s + network.travel_time_s(successor, speed_cap_mps),
                network.lane_numbers[successor],
                travelled_m + network.lines[successor].length_m,
                successor,
            )
            heapq.heappush(queue, entry)
    return settled


def _arrival(
    network: RoadNetwork,
    origin: Place,
    destination: Place,
    ends: dict[str, tuple[float, float]],
    closed: frozenset[str],
    speed_cap_mps: float,
) -> tuple[float, float]:
    if origin == destination:
        return 0.0, 0.0
    lane_id, s_m = destination
    if (
        origin[0] == lane_id
        and origin[1] <= s_m + SAME_PLACE_M
        and network.is_open(lane_id, origin[1], s_m, closed)
    ):
        ahead_m = max(0.0, s_m - origin[1])
        return network.time_between(lane_id, origin[1], origin[1] + ahead_m, speed_cap_mps), ahead_m
    if not network.is_open(lane_id, 0.0, s_m, closed):
        return math.inf, math.inf
    before = [ends[lane] for lane in network.predecessors(lane_id) if lane in ends]
    if not before:
        return math.inf, math.inf
    time_s, travelled_m = min(before)
    return time_s + network.time_between(lane_id, 0.0, s_m, speed_cap_mps), travelled_m + s_m
