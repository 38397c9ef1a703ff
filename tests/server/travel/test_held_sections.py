"""Travel times of a shuttle under way: what it holds it drives to the end, and only then it turns off."""

import math

import pytest

from contract.roads.network import RoadNetwork
from server.domain.rules import FleetRules
from server.travel.fleet_roads import FleetRoads
from server.travel.held_sections import times_over_held
from tests.server.usecases.shipped_maps import shipped_map

RULES = FleetRules()
NETWORK = RoadNetwork(shipped_map("snow-lion"))
ROADS = FleetRoads(NETWORK, RULES.speed_cap_mps, RULES.travel_time_factor)
OWN = frozenset(NETWORK.resting_places)
# The stop with the most road before it on its own lane.
STOP = max(NETWORK.road_map.stops, key=lambda stop: stop.s_m)
NUMBER = ROADS.stop_numbers[STOP.stop_id]
HELD = tuple(s.section_id for s in NETWORK.sections_of(STOP.lane_id))
STOPPING_M = 6.0


def seconds(before_m: float, heading_for: str = "", held: tuple[str, ...] = HELD) -> float:
    """To the stop from a place so far before it."""
    place = (STOP.lane_id, STOP.s_m - before_m)
    first = NETWORK.section_at(*place).section_id
    ahead = held[held.index(first) :]
    return float(times_over_held(ROADS, ahead, place, OWN, frozenset(), STOPPING_M, heading_for)[NUMBER])


def along_lane_s(before_m: float) -> float:
    between_s = NETWORK.time_between(STOP.lane_id, STOP.s_m - before_m, STOP.s_m, RULES.speed_cap_mps)
    return between_s * RULES.travel_time_factor


def around_s(before_m: float) -> float:
    """Past the stop to the lane's end, and from there back to it."""
    end_m = NETWORK.lines[STOP.lane_id].length_m
    to_end_s = NETWORK.time_between(STOP.lane_id, STOP.s_m - before_m, end_m, RULES.speed_cap_mps)
    back_s = ROADS.times_to_stops((STOP.lane_id, end_m), OWN, frozenset())[NUMBER]
    return float(to_end_s * RULES.travel_time_factor + back_s)


@pytest.mark.parametrize("before_m", [STOPPING_M, 2.0 * STOPPING_M, STOP.s_m])
def test_a_stop_on_the_held_sections_is_called_at_in_passing(before_m: float) -> None:
    assert seconds(before_m) == pytest.approx(along_lane_s(before_m))


def test_a_stop_nearer_than_the_stopping_distance_is_reached_by_going_around() -> None:
    before_m = STOPPING_M - 0.1
    assert seconds(before_m) == pytest.approx(around_s(before_m))
    assert seconds(before_m) > along_lane_s(before_m) + 30.0


def test_the_stop_that_the_shuttle_brakes_for_already_is_not_passed() -> None:
    before_m = STOPPING_M - 0.1
    assert seconds(before_m, heading_for=STOP.stop_id) == pytest.approx(along_lane_s(before_m))


def test_a_stop_behind_the_shuttle_is_reached_by_going_around() -> None:
    assert seconds(-1.0, heading_for=STOP.stop_id) == pytest.approx(around_s(-1.0))


def test_a_shuttle_that_holds_road_up_to_a_closed_one_reaches_nothing_beyond() -> None:
    closed = ROADS.closed_to(frozenset(HELD[2:]))
    place = (STOP.lane_id, 0.0)
    open_s = times_over_held(ROADS, HELD[:2], place, OWN, frozenset(), STOPPING_M)
    closed_s = times_over_held(closed, HELD[:2], place, OWN, frozenset(), STOPPING_M)
    assert all(math.isfinite(time_s) for time_s in open_s)
    assert all(math.isinf(time_s) for time_s in closed_s)
