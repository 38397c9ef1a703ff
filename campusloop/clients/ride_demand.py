"""The rides that simulated passengers book."""

from collections.abc import Sequence

import numpy as np

from campusloop.clients.passengers import BOARDING_METHODS, RideDemand
from contract.roads.model import RestingPlace, RoadMap
from contract.roads.network import RoadNetwork
from contract.roads.routing import find_route

RIDE_M_MIN = 500.0
# At 3 m/s a longer ride takes more than six minutes.
RIDE_M_MAX = 1000.0

StopPair = tuple[str, str]


def stop_pairs(road_map: RoadMap, length_m_min: float, length_m_max: float) -> list[StopPair]:
    """(pickup, dropoff) stop ids with a route of that length between them, in map order."""
    network = RoadNetwork(road_map)
    pairs = []
    for pickup in road_map.stops:
        for dropoff in road_map.stops:
            route = find_route(network, pickup.lane_id, pickup.s_m, dropoff.lane_id, dropoff.s_m)
            if pickup is not dropoff and route is not None and length_m_min <= route.length_m <= length_m_max:
                pairs.append((pickup.stop_id, dropoff.stop_id))
    return pairs


def nearest_pairs(
    road_map: RoadMap, pairs: Sequence[StopPair], places: Sequence[RestingPlace]
) -> list[StopPair]:
    """For each place the pair that a vehicle there serves with the shortest route, each pickup once.

    A place from which no pickup can be reached has no pair.
    """
    network = RoadNetwork(road_map)
    stops = {stop.stop_id: stop for stop in road_map.stops}
    chosen: list[StopPair] = []
    for place in places:
        routes_m = []
        for pair in pairs:
            pickup, dropoff = stops[pair[0]], stops[pair[1]]
            approach = find_route(network, place.lane_id, place.s_m, pickup.lane_id, pickup.s_m)
            ride = find_route(network, pickup.lane_id, pickup.s_m, dropoff.lane_id, dropoff.s_m)
            if approach is None or ride is None or pickup.stop_id in {first for first, _ in chosen}:
                continue
            routes_m.append((approach.length_m + ride.length_m, pair))
        if routes_m:
            chosen.append(min(routes_m)[1])
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
