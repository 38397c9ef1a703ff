"""Which rides the simulated passengers ask for."""

import numpy as np

from campusloop.clients.ride_demand import nearest_pairs, random_rides, stop_pairs
from campusloop.live.demo import first_rides
from campusloop.shipped import DEFAULT_MAP
from contract.roads.load import load_map
from contract.roads.network import RoadNetwork
from contract.roads.routing import find_route

MAP = load_map(DEFAULT_MAP)
STOPS = {stop.stop_id: stop for stop in MAP.stops}


def _route_m(pickup_id: str, dropoff_id: str) -> float:
    pickup, dropoff = STOPS[pickup_id], STOPS[dropoff_id]
    route = find_route(RoadNetwork(MAP), pickup.lane_id, pickup.s_m, dropoff.lane_id, dropoff.s_m)
    assert route is not None
    return route.length_m


def test_only_pairs_with_a_route_of_that_length_are_asked_for() -> None:
    pairs = stop_pairs(MAP, 500.0, 700.0)
    assert pairs
    assert all(500.0 <= _route_m(*pair) <= 700.0 for pair in pairs)


def test_the_first_rides_of_a_demo_begin_near_the_waiting_shuttles() -> None:
    """Within ten minutes at 3 m/s a visitor sees them end."""
    network = RoadNetwork(MAP)
    first = first_rides(MAP, 2, np.random.default_rng(1))[:2]
    for ride, place in zip(first, MAP.resting_places, strict=False):
        pickup = STOPS[ride.from_stop]
        approach = find_route(network, place.lane_id, place.s_m, pickup.lane_id, pickup.s_m)
        assert approach is not None
        assert approach.length_m + _route_m(ride.from_stop, ride.to_stop) < 700.0
    assert first[0].from_stop != first[1].from_stop


def test_two_vehicles_at_one_place_get_rides_from_two_stops() -> None:
    place = MAP.resting_places[0]
    (one, _), (other, _) = nearest_pairs(MAP, stop_pairs(MAP, 250.0, 1000.0), (place, place))
    assert one != other


def test_the_same_seed_asks_for_the_same_rides() -> None:
    pairs = stop_pairs(MAP, 500.0, 1000.0)
    one, again = (random_rides(20, pairs, 90.0, np.random.default_rng(7)) for _ in range(2))
    assert one == again
    assert [ride.after_s for ride in one] == sorted(ride.after_s for ride in one)
