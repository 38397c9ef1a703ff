"""Observation areas on a line, and the room beside it."""

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from contract.roads.areas import areas_ahead, crosses_itself, ground_m2, inside
from contract.roads.load import decode_map, encode_map, with_version
from contract.roads.model import Building, ObservationArea, RoadMap
from contract.roads.network import RoadNetwork
from contract.roads.routing import ReferenceLine, find_route, route_line
from contract.roads.width import drivable_width
from tests.contract.roads.ring_map import ring_map

SQUARE = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]])
# Across side-0, which runs east from (0, 0) and is 4 m wide.
CROSSING = ObservationArea(
    "zebra", "crossing", ((38.0, -4.0), (42.0, -4.0), (42.0, 4.0), (38.0, 4.0)), (("side-0", 37.5),)
)


def watched_ring() -> RoadMap:
    return with_version(replace(ring_map(), observation_areas=(CROSSING,)))


def a_line(
    road_map: RoadMap, from_s_m: float, to_lane: str, to_s_m: float
) -> tuple[RoadNetwork, ReferenceLine]:
    network = RoadNetwork(road_map)
    route = find_route(network, "side-0", from_s_m, to_lane, to_s_m)
    assert route is not None
    return network, route_line(network, route)


def test_points_are_told_inside_from_outside() -> None:
    points = np.array([[1.0, 1.0], [3.0, 1.0], [-0.1, 1.0], [1.0, 2.1]])
    assert inside(SQUARE, points).tolist() == [True, False, False, False]


@given(
    corners=st.lists(st.floats(1.0, 9.0), min_size=3, max_size=9),
    turned_rad=st.floats(0.0, 6.0),
    seed=st.integers(0, 1000),
)
def test_inside_is_what_the_outline_encloses_whatever_its_shape(
    corners: list[float], turned_rad: float, seed: int
) -> None:
    """A star of corners at these distances from the origin."""
    angles = turned_rad + np.linspace(0.0, 2.0 * np.pi, len(corners), endpoint=False)
    outline = np.column_stack((corners * np.cos(angles), corners * np.sin(angles)))
    points = np.random.default_rng(seed).uniform(-9.0, 9.0, (50, 2))
    enclosed = shapely.contains_xy(shapely.Polygon(outline), points[:, 0], points[:, 1])
    assert inside(outline, points).tolist() == enclosed.tolist()


def test_a_point_level_with_a_corner_is_on_the_side_where_it_is() -> None:
    diamond = np.array([[0.0, -1.0], [1.0, 0.0], [0.0, 1.0], [-1.0, 0.0]])
    points = np.array([[0.0, 0.0], [0.5, 0.0], [-0.5, 0.0], [2.0, 0.0], [-2.0, 0.0]])
    assert inside(diamond, points).tolist() == [True, True, True, False, False]


def test_a_bow_tie_crosses_itself_and_a_square_does_not() -> None:
    assert not crosses_itself(SQUARE)
    assert crosses_itself(SQUARE[[0, 2, 1, 3]])
    assert ground_m2(SQUARE) == pytest.approx(4.0)
    small = 0.1 * SQUARE
    assert not crosses_itself(small)
    assert crosses_itself(small[[0, 2, 1, 3]])


def test_an_outline_that_touches_itself_crosses_itself() -> None:
    notched = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [2.0, 1.0], [0.0, 4.0]])
    assert not crosses_itself(notched)
    touching = notched.copy()
    touching[3, 1] = 0.0
    assert crosses_itself(touching)


def test_areas_survive_being_written_and_are_part_of_the_version() -> None:
    road_map = watched_ring()
    assert decode_map(encode_map(road_map)) == road_map
    assert road_map.map_version != ring_map().map_version


def test_a_line_meets_an_area_where_it_crosses_it() -> None:
    network, line = a_line(watched_ring(), 5.0, "side-1", 50.0)
    (ahead,) = areas_ahead(network, line)
    assert ahead.area_id == "zebra"
    assert ahead.stop_s_m == pytest.approx(32.5, abs=0.05)
    assert 32.5 < ahead.enter_s_m <= 34.1
    assert 35.9 <= ahead.leave_s_m < 37.1


def test_a_line_around_the_ring_meets_the_area_again() -> None:
    network, line = a_line(watched_ring(), 20.0, "side-0", 19.0)
    assert len(areas_ahead(network, line)) == 1
    network, line = a_line(watched_ring(), 60.0, "side-0", 55.0)
    (ahead,) = areas_ahead(network, line)
    assert ahead.stop_s_m > 300.0


def test_a_line_that_begins_in_the_area_stops_where_it_begins() -> None:
    network, line = a_line(watched_ring(), 40.0, "side-1", 50.0)
    (ahead,) = areas_ahead(network, line)
    assert (ahead.stop_s_m, ahead.enter_s_m) == (0.0, 0.0)


def test_a_line_beyond_the_area_does_not_meet_it() -> None:
    network, line = a_line(watched_ring(), 60.0, "side-1", 50.0)
    assert areas_ahead(network, line) == ()


def test_a_single_line_road_is_as_wide_to_both_sides() -> None:
    network, line = a_line(ring_map(), 5.0, "side-1", 50.0)
    left_m, right_m = drivable_width(network, line, ())
    assert np.allclose(left_m, 2.0)
    assert np.allclose(right_m, 2.0)


def test_a_building_cuts_the_side_it_stands_on() -> None:
    network, line = a_line(ring_map(), 5.0, "side-1", 50.0)
    house = Building(((40.0, 1.5), (50.0, 1.5), (50.0, 9.0), (40.0, 9.0)), 5.0)
    left_m, right_m = drivable_width(network, line, (house,))
    x = line.points[:, 0]
    beside = (x > 40.0) & (x < 50.0) & (np.abs(line.points[:, 1]) < 0.1)
    assert np.allclose(left_m[beside], 1.5)
    assert np.allclose(left_m[x < 38.0], 2.0)
    assert np.allclose(right_m, 2.0)


def test_a_wall_on_the_line_leaves_no_room() -> None:
    network, line = a_line(ring_map(), 5.0, "side-0", 90.0)
    wall = Building(((50.0, -1.0), (51.0, -1.0), (51.0, 1.0), (50.0, 1.0)), 5.0)
    left_m, right_m = drivable_width(network, line, (wall,))
    on_it = (line.points[:, 0] > 50.0) & (line.points[:, 0] < 51.0)
    assert np.all(np.minimum(left_m, right_m)[on_it] == 0.0)


def test_where_two_can_pass_only_the_own_side_counts() -> None:
    lanes = ring_map().lanes
    east = replace(lanes[0], can_pass=True, width_m=7.0)
    west_points = tuple((x, 3.0) for x, _ in reversed(east.points))
    west = replace(east, lane_id="side-0w", points=west_points, successors=())
    road_map = replace(ring_map(), lanes=(east, *lanes[1:], west))
    sections = (
        *road_map.sections,
        replace(road_map.sections[0], section_id="w", lane_id="side-0w", s_to_m=100.0),
    )
    network, line = a_line(replace(road_map, sections=sections), 5.0, "side-0", 90.0)
    left_m, right_m = drivable_width(network, line, ())
    assert np.allclose(left_m, 1.5)
    assert np.allclose(right_m, 1.5)
