"""The rides that simulated passengers book."""

import math
from collections.abc import Sequence

import numpy as np

from campusloop.clients.passengers import BOARDING_METHODS, RideDemand
from contract.roads.model import RestingPlace, RoadMap
from contract.roads.network import RoadNetwork
from contract.roads.travel_times import Place, travel_time_matrix

RIDE_M_MIN = 500.0
# At 3 m/s a longer ride takes more than six minutes.
RIDE_M_MAX = 1000.0

StopPair = tuple[str, str]


def stop_pairs(road_map: RoadMap, length_m_min: float, length_m_max: float) -> list[StopPair]:
    """(pickup, dropoff) stop ids with a route of that length between them, in map order."""
    stops = road_map.stops
    _, lengths_m = travel_time_matrix(RoadNetwork(road_map), [(stop.lane_id, stop.s_m) for stop in stops])
    return [
        (pickup.stop_id, dropoff.stop_id)
        for i, pickup in enumerate(stops)
        for j, dropoff in enumerate(stops)
        if i != j and length_m_min <= lengths_m[i, j] <= length_m_max
    ]


def nearest_pairs(
    road_map: RoadMap, pairs: Sequence[StopPair], places: Sequence[RestingPlace]
) -> list[StopPair]:
    """For each place the pair that a vehicle there serves with the shortest route, each pickup once.

    A place from which no pickup can be reached has no pair.
    """
    ends: list[Place] = [(place.lane_id, place.s_m) for place in places]
    stops: list[Place] = [(stop.lane_id, stop.s_m) for stop in road_map.stops]
    _, lengths_m = travel_time_matrix(RoadNetwork(road_map), ends + stops)
    row = {stop.stop_id: len(ends) + number for number, stop in enumerate(road_map.stops)}
    chosen: list[StopPair] = []
    for place in range(len(ends)):
        taken = {pickup for pickup, _ in chosen}
        routes_m = [
            (lengths_m[place, row[pickup]] + lengths_m[row[pickup], row[dropoff]], (pickup, dropoff))
            for pickup, dropoff in pairs
            if pickup not in taken
        ]
        length_m, pair = min(routes_m, default=(math.inf, None))
        if pair is not None and math.isfinite(length_m):
            chosen.append(pair)
    return chosen


def random_rides(
    count: int, pairs: Sequence[StopPair], spacing_s: float, rng: np.random.Generator
) -> list[RideDemand]:
    """Rides between the given pairs of stops, spacing_s apart on average."""
    rides = []
    after_s = 0.0
    for number in range(1, count + 1):
        from_stop, to_stop = pairs[int(rng.integers(len(pairs)))]
        party = int(rng.choice([1, 1, 1, 2, 2, 3]))
        how = BOARDING_METHODS[int(rng.integers(len(BOARDING_METHODS)))]
        rides.append(RideDemand(number, round(after_s, 1), from_stop, to_stop, party, how))
        after_s += float(rng.exponential(spacing_s))
    return rides
