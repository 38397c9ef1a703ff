"""Travel times of a vehicle that moves: it drives the sections that it holds to their end."""

import math
from collections.abc import Sequence

import numpy as np

from contract.geometry import Array
from contract.roads.travel_times import Place
from server.travel.fleet_roads import FleetRoads
from server.travel.road_access import Own


def times_over_held(
    roads: FleetRoads,
    held: Sequence[str],
    place: Place,
    own: Own,
    opened: frozenset[str],
    stopping_m: float,
    heading_for: str = "",
) -> Array:
    """(n,) planned seconds to every stop from a place on the first of the held sections.

    A way that turns off begins where the held sections end. A stop on them is passed on the way, if it lies
    at least stopping_m ahead. `heading_for` names the stop that the shuttle drives to already: it has begun
    to brake for it in time.
    """
    network, cap_mps = roads.network, roads.speed_cap_mps
    passed = np.full(len(roads.stop_ids), np.inf)
    clock_s, travelled_m = 0.0, 0.0
    lane_id, s_m = place
    for section_id in held:
        section = network.sections[section_id]
        if section.lane_id != lane_id or not section.s_from_m <= s_m <= section.s_to_m:
            lane_id, s_m = section.lane_id, section.s_from_m
        for number, (stop_lane_id, stop_s_m) in enumerate(roads.stop_places):
            ahead_m = travelled_m + stop_s_m - s_m
            is_on_it = stop_lane_id == lane_id and s_m <= stop_s_m <= section.s_to_m
            is_in_time = ahead_m >= stopping_m or roads.stop_ids[number] == heading_for
            if is_on_it and is_in_time and math.isinf(passed[number]):
                passed[number] = clock_s + network.time_between(lane_id, s_m, stop_s_m, cap_mps)
        clock_s += network.time_between(lane_id, s_m, section.s_to_m, cap_mps)
        travelled_m += section.s_to_m - s_m
        s_m = section.s_to_m
    beyond = roads.times_to_stops((lane_id, s_m), own, opened) + clock_s * roads.slack
    if roads.closed and _ends_before_closed_road(roads, held, (lane_id, s_m)):
        beyond = np.full(len(roads.stop_ids), np.inf)
    times: Array = np.where(np.isfinite(passed), passed * roads.slack, beyond)
    return times


def _ends_before_closed_road(roads: FleetRoads, held: Sequence[str], end: Place) -> bool:
    """The held sections end in mid-lane, before a closed road."""
    return roads.network.section_at(*end).section_id in roads.access.closed_for(held[-1])
