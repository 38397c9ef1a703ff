"""Routes and the lines along them."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from contract.roads.model import RoadMap
from contract.roads.network import RoadNetwork
from contract.roads.routing import find_route, route_line, route_sections, route_spans
from contract.roads.times_to_places import TimesToPlaces
from contract.roads.travel_times import travel_time_matrix
from tests.contract.roads.generated_maps import generated_map
from tests.contract.roads.ring_map import ring_map

SPEED_CAP_MPS = 15.0 / 3.6


@pytest.fixture(scope="module")
def ring() -> RoadNetwork:
    return RoadNetwork(ring_map())


def test_a_destination_ahead_on_the_lane_is_driven_to_directly(ring: RoadNetwork) -> None:
    route = find_route(ring, "side-0", 20.0, "side-0", 60.0)
    assert route is not None
    assert route.lane_ids == ("side-0",)
    assert route.length_m == pytest.approx(40.0)
    assert route.time_s == pytest.approx(10.0)


def test_a_destination_behind_on_the_lane_means_going_around(ring: RoadNetwork) -> None:
    route = find_route(ring, "side-0", 60.0, "side-0", 20.0)
    assert route is not None
    assert route.lane_ids[0] == route.lane_ids[-1] == "side-0"
    assert len(route.lane_ids) == 9
    assert route.length_m == pytest.approx(sum(line.length_m for line in ring.lines.values()) - 40.0)


def test_a_blocked_section_closes_the_ring(ring: RoadNetwork) -> None:
    blocked = frozenset({"side-2/1"})
    assert find_route(ring, "side-1", 0.0, "side-3", 10.0, blocked) is None
    assert find_route(ring, "side-0", 0.0, "side-2", 10.0, blocked) is not None


def test_a_vehicle_may_leave_the_blocked_section_it_stands_in(ring: RoadNetwork) -> None:
    assert find_route(ring, "side-2", 30.0, "side-3", 10.0, frozenset({"side-2/1"})) is not None


def test_an_unknown_lane_is_a_key_error(ring: RoadNetwork) -> None:
    with pytest.raises(KeyError):
        find_route(ring, "nowhere", 0.0, "side-0", 0.0)


def test_sections_of_two_legs_join_where_the_first_one_ends(ring: RoadNetwork) -> None:
    out = find_route(ring, "side-0", 10.0, "side-0", 60.0)
    on = find_route(ring, "side-0", 60.0, "side-1", 10.0)
    assert out is not None
    assert on is not None
    assert route_sections(ring, out, on) == (
        "side-0/0", "side-0/1", "side-0/2", "side-0/3", "corner-0/0", "side-1/0",
    )  # fmt: skip


def test_a_route_of_no_length_has_the_section_that_it_is_in(ring: RoadNetwork) -> None:
    route = find_route(ring, "side-0", 60.0, "side-0", 60.0)
    assert route is not None
    assert route_spans(ring, route) == (("side-0/2", 0.0, 0.0),)


def test_a_route_that_begins_where_a_section_ends_begins_with_the_next_section(ring: RoadNetwork) -> None:
    route = find_route(ring, "side-0", 25.0, "side-0", 60.0)
    assert route is not None
    assert route_sections(ring, route) == ("side-0/1", "side-0/2")


@pytest.mark.parametrize(("length_m", "points"), [(0.0, 1), (0.01, 2), (0.03, 2)])
def test_the_line_of_a_short_route_has_its_ends_once(ring: RoadNetwork, length_m: float, points: int) -> None:
    route = find_route(ring, "side-0", 60.0, "side-0", 60.0 + length_m)
    assert route is not None
    line = route_line(ring, route)
    assert len(line.points) == points
    assert line.s[-1] == pytest.approx(length_m)


Ends = tuple[int, float, int, float]


def _ends(road_map: RoadMap) -> st.SearchStrategy[Ends]:
    lane, share = st.integers(0, len(road_map.lanes) - 1), st.floats(0.0, 1.0)
    return st.tuples(lane, share, lane, share)


MADE = generated_map(2)
NETWORK = RoadNetwork(MADE)


def _places(ends: Ends) -> tuple[tuple[str, float], tuple[str, float]]:
    first, second = MADE.lanes[ends[0]].lane_id, MADE.lanes[ends[2]].lane_id
    return (first, ends[1] * NETWORK.lines[first].length_m), (
        second,
        ends[3] * NETWORK.lines[second].length_m,
    )


@settings(max_examples=60, deadline=None)
@given(_ends(MADE))
def test_a_star_is_as_fast_as_searching_everything(ends: Ends) -> None:
    origin, destination = _places(ends)
    route = find_route(NETWORK, *origin, *destination, speed_cap_mps=SPEED_CAP_MPS)
    times_s, lengths_m = travel_time_matrix(NETWORK, [origin, destination], SPEED_CAP_MPS)
    assert route is not None
    assert route.time_s == pytest.approx(times_s[0, 1], abs=1e-6)
    assert route.length_m == pytest.approx(lengths_m[0, 1], abs=1e-3)


@settings(max_examples=40, deadline=None)
@given(_ends(MADE))
def test_the_line_along_a_route_is_smooth_dense_and_tiled_by_its_sections(ends: Ends) -> None:
    origin, destination = _places(ends)
    route = find_route(NETWORK, *origin, *destination)
    assert route is not None
    if route.length_m < 5.0:
        return
    line = route_line(NETWORK, route)
    assert np.diff(line.s).max() <= 1.03
    assert line.s[-1] == pytest.approx(route.length_m, abs=0.05)
    assert np.hypot(*(line.points[0] - NETWORK.pose(*origin)[:2])) < 1e-6
    assert np.hypot(*(line.points[-1] - NETWORK.pose(*destination)[:2])) < 1e-6
    assert len(line.s) == len(line.curvature_1pm) == len(line.speed_limit_mps) == len(line.lane_number)
    headings = np.unwrap(np.arctan2(*np.diff(line.points, axis=0).T[::-1]))
    assert np.abs(np.diff(headings)).max() < 0.3
    assert line.sections[0][1] == 0.0
    assert line.sections[-1][2] == pytest.approx(route.length_m)
    for (_, _, end_m), (_, begin_m, _) in pairwise(line.sections):
        assert end_m == pytest.approx(begin_m)


def test_the_same_question_has_the_same_answer() -> None:
    origin, destination = _places((3, 0.2, 40, 0.7))
    routes = {find_route(RoadNetwork(generated_map(2)), *origin, *destination) for _ in range(2)}
    assert len(routes) == 1


def test_the_matrix_is_zero_on_its_diagonal_and_infinite_where_there_is_no_way() -> None:
    ring = RoadNetwork(ring_map())
    times_s, lengths_m = travel_time_matrix(
        ring, [("side-0", 10.0), ("side-2", 90.0)], blocked=frozenset({"side-1/0"})
    )
    assert times_s[0, 0] == lengths_m[1, 1] == 0.0
    assert math.isinf(times_s[0, 1])
    assert math.isfinite(times_s[1, 0])


@given(
    st.lists(_ends(MADE), min_size=1, max_size=3), st.sets(st.integers(0, len(MADE.sections) - 1), max_size=4)
)
@settings(deadline=None)
def test_times_to_places_equal_the_rows_of_the_matrix(ends: list[Ends], shut: set[int]) -> None:
    places = [place for pair in ends for place in _places(pair)]
    blocked = frozenset(MADE.sections[number].section_id for number in shut)
    matrix, _ = travel_time_matrix(NETWORK, places, SPEED_CAP_MPS, blocked)
    for origin, row in zip(places, matrix, strict=True):
        closed = blocked - {NETWORK.section_at(*origin).section_id}
        times = TimesToPlaces(NETWORK, places, SPEED_CAP_MPS, closed).from_place(origin)
        assert times == pytest.approx(row)
