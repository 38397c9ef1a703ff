"""Where the import says that others may cross, and where to stand clear of them."""

import itertools
from pathlib import Path

import msgspec
import numpy as np
import pytest
import shapely

from contract.geometry import arc_lengths
from contract.roads.areas import crosses_itself, outline_array
from contract.roads.design_vehicle import FRONT_REACH_M, REAR_OVERHANG_M, WIDTH_M
from contract.roads.load import encode_map, load_map
from contract.roads.model import SCENARIOS, ObservationArea, RoadMap
from contract.roads.network import RoadNetwork
from server.feeds.roads.import_osm import import_osm
from tests.server.feeds.roads.osm_text import END_TAGS, SQUARE_WAYS, square_file
from tests.server.feeds.roads.shipped import CAMPUS_MAP, SNOW_LION_MAP

# A crossing of the west side of the square, half way.
CROSSING_WAYS = SQUARE_WAYS | {102: ([1, 9, 3], {"highway": "service", "name": "West", "width": "4"})}


def with_crossing(folder: Path) -> RoadMap:
    path = square_file(
        folder,
        points={9: (0.0, 100.0)},
        ways=CROSSING_WAYS,
        node_tags=END_TAGS | {9: {"highway": "crossing"}},
    )
    return import_osm(path).map


def body_at(network: RoadNetwork, lane_id: str, bumper_s_m: float) -> shapely.Polygon:
    """A shuttle whose front bumper stands there, its rear axle as far behind as it is long."""
    x, y, yaw = network.pose(lane_id, max(0.0, bumper_s_m - FRONT_REACH_M))
    cos, sin = np.cos(yaw), np.sin(yaw)
    front, half = min(FRONT_REACH_M, bumper_s_m), 0.5 * WIDTH_M
    corners = ((-REAR_OVERHANG_M, -half), (front, -half), (front, half), (-REAR_OVERHANG_M, half))
    return shapely.Polygon([(x + cos * a - sin * b, y + sin * a + cos * b) for a, b in corners])


def test_a_crossing_becomes_a_rectangle_across_the_road_with_a_stop_line_from_each_side(
    tmp_path: Path,
) -> None:
    road_map = with_crossing(tmp_path)
    (area,) = [area for area in road_map.observation_areas if area.kind == "crossing"]
    assert area.area_id == "crossing-9"
    outline = shapely.Polygon(area.outline)
    assert outline.area == np.float64(outline.area)
    low, high = outline_array(area).min(axis=0), outline_array(area).max(axis=0)
    assert np.allclose(high - low, [4.0 + 2 * 2.0, 4.0], atol=0.2)
    network = RoadNetwork(road_map)
    assert len(area.stop_lines) == 2
    for lane_id, s_m in area.stop_lines:
        x, y, _ = network.pose(lane_id, s_m)
        assert 0.4 < outline.distance(shapely.Point(x, y)) < 0.7
        assert not body_at(network, lane_id, s_m).intersects(outline)


def test_a_junction_of_three_ways_is_watched_and_one_of_two_is_not(tmp_path: Path) -> None:
    road_map = import_osm(square_file(tmp_path)).map
    areas = [area for area in road_map.observation_areas if area.kind == "intersection"]
    centres = np.array([outline_array(area).mean(axis=0) for area in areas])
    # Corners 1 and 4 have dead ends beside their two sides, 5 and 6 the crossbar; 2 and 3 are bends.
    assert len(areas) == 4
    assert np.all(np.min(np.hypot(*(centres[:, None] - centres[None]).T) + 1e9 * np.eye(4), axis=0) > 50.0)


def test_signals_protect_an_intersection(tmp_path: Path) -> None:
    tags = END_TAGS | {5: {"highway": "traffic_signals"}}
    road_map = import_osm(square_file(tmp_path, node_tags=tags)).map
    assert len(road_map.observation_areas) == 3


def test_who_stands_at_a_stop_line_is_clear_of_the_turns_of_others() -> None:
    road_map = load_map(CAMPUS_MAP)
    network = RoadNetwork(road_map)
    turns = [lane for lane in road_map.lanes if lane.kind == "turn"]
    tree = shapely.STRtree([shapely.LineString(lane.points) for lane in turns])
    checked = 0
    for area in (a for a in road_map.observation_areas if a.kind == "intersection"):
        for lane_id, s_m in area.stop_lines:
            if s_m < FRONT_REACH_M + REAR_OVERHANG_M:
                continue  # a lane too short for the whole body: its tail stands in the junction before
            near = tree.query(body_at(network, lane_id, s_m).buffer(3.0))
            others = [
                turns[int(i)] for i in near if lane_id not in network.predecessors(turns[int(i)].lane_id)
            ]
            inside = [t for t in others if _runs_through(area, t.points)]
            strip = body_at(network, lane_id, s_m)
            for turn in inside:
                # A turn into this very road ends where this lane begins to be shared with it.
                line = shapely.LineString(turn.points[:-4])
                assert not strip.intersects(line.buffer(0.2)), (area.area_id, lane_id, turn.lane_id)
                checked += 1
    assert checked > 20


def _runs_through(area: ObservationArea, points: tuple[tuple[float, float], ...]) -> bool:
    outline = shapely.Polygon(area.outline)
    return bool(outline.contains(shapely.LineString(points).centroid))


def test_the_shipped_campus_watches_its_junctions_with_sound_outlines() -> None:
    road_map = load_map(CAMPUS_MAP)
    assert len(road_map.observation_areas) > 100
    for area in road_map.observation_areas:
        assert shapely.Polygon(area.outline).is_valid
        assert not crosses_itself(outline_array(area))


def test_a_map_without_areas_is_written_without_the_field(tmp_path: Path) -> None:
    bare = msgspec.structs.replace(load_map(SNOW_LION_MAP), observation_areas=())
    assert b"observation_areas" not in encode_map(bare)


def test_the_shipped_maps_have_crossings_and_roads_where_cars_pull_out() -> None:
    for path, crossings in ((CAMPUS_MAP, 7), (SNOW_LION_MAP, 7)):
        road_map = load_map(path)
        areas = [area for area in road_map.observation_areas if area.kind == "crossing"]
        assert len(areas) == crossings
        assert all(area.stop_lines for area in areas)
        assert {lane.scenario for lane in road_map.lanes} == set(SCENARIOS)


def test_every_station_has_a_crossing_that_both_directions_stop_before() -> None:
    road_map = load_map(SNOW_LION_MAP)
    for area in road_map.observation_areas:
        assert {lane_id.split("-")[0] for lane_id, _ in area.stop_lines} == {"east", "west"}


def test_stop_lines_lie_on_their_lanes() -> None:
    road_map = load_map(CAMPUS_MAP)
    lengths = {lane.lane_id: float(arc_lengths(np.array(lane.points))[-1]) for lane in road_map.lanes}
    lines = itertools.chain.from_iterable(area.stop_lines for area in road_map.observation_areas)
    assert all(0.0 <= s_m <= lengths[lane_id] for lane_id, s_m in lines)


@pytest.mark.parametrize(
    ("ways", "is_crossing"),
    [
        ({201: ([20, 9, 21], {"highway": "footway"})}, True),
        ({201: ([20, 9], {"highway": "path"}), 202: ([9, 21], {"highway": "steps"})}, True),
        ({201: ([20, 9], {"highway": "footway"})}, False),
        ({201: ([20, 9, 22], {"highway": "footway"})}, False),
    ],
)
def test_a_footway_that_goes_on_beyond_the_road_is_a_crossing(
    tmp_path: Path, ways: dict[int, tuple[list[int], dict[str, str]]], is_crossing: bool
) -> None:
    path = square_file(
        tmp_path,
        points={9: (0.0, 100.0), 20: (-20.0, 100.0), 21: (20.0, 101.0), 22: (-20.0, 110.0)},
        ways=CROSSING_WAYS | ways,
        node_tags=END_TAGS,
    )
    found = [a.area_id for a in import_osm(path).map.observation_areas if a.kind == "crossing"]
    assert found == (["crossing-9"] if is_crossing else [])


@pytest.mark.parametrize(("aside_m", "is_aisle"), [(10.0, True), (14.0, False)])
def test_a_road_beside_a_car_park_or_its_entrance_is_a_parking_aisle(
    tmp_path: Path, aside_m: float, is_aisle: bool
) -> None:
    corners = {30: (-aside_m, 90.0), 31: (-aside_m, 110.0), 32: (-40.0, 110.0), 33: (-40.0, 90.0)}
    entrance = {40: (200.0 + aside_m, 100.0)}
    path = square_file(
        tmp_path,
        points={9: (0.0, 100.0)} | corners | entrance,
        ways=CROSSING_WAYS | {203: ([30, 31, 32, 33, 30], {"amenity": "parking"})},
        node_tags=END_TAGS | {40: {"amenity": "parking_entrance"}},
    )
    report = import_osm(path)
    # The map's frame begins in the middle of the square.
    aisles = [shapely.LineString(lane.points) for lane in report.map.lanes if lane.scenario == "parking_lot"]
    for place in ((-100.0, 0.0), (100.0, 0.0)):
        assert any(aisle.distance(shapely.Point(place)) < 3.0 for aisle in aisles) is is_aisle
    assert not any(aisle.distance(shapely.Point(0.0, 0.0)) < 3.0 for aisle in aisles)
    assert sum("parking aisle" in line for line in report.repairs) == (2 if is_aisle else 0)
    # Nobody rests before the way out of a car park because of it.
    assert len(report.map.resting_places) >= 2
