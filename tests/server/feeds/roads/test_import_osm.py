"""From OpenStreetMap to a drivable map, and what is said about it."""

import csv
import math
from pathlib import Path

import numpy as np
import osmium
import pytest

from contract.geometry import Array, curvatures
from contract.roads.load import MapError, encode_map, load_map
from contract.roads.model import RoadMap
from contract.roads.network import RoadNetwork
from contract.roads.projection import map_from_wgs84
from contract.roads.routing import find_route
from server.feeds.roads.generated import generated_osm
from server.feeds.roads.import_osm import ImportOptions, ImportReport, import_osm
from server.feeds.roads.osm.osm_file import Bounds
from tests.server.feeds.roads.osm_text import (
    ORIGIN,
    SQUARE_WAYS,
    Points,
    Ways,
    osm_text,
    square_file,
)
from tests.server.feeds.roads.shipped import CAMPUS, CAMPUS_MAP, CAMPUS_SOURCE

SERVICE = {"highway": "service"}


def imported(folder: Path, **changes: object) -> ImportReport:
    return import_osm(square_file(folder, **changes))  # type: ignore[arg-type]


def lane_names(road_map: RoadMap) -> set[str]:
    return {lane.name for lane in road_map.lanes}


def drives_near(road_map: RoadMap, x_m: float, y_m: float, reach_m: float = 8.0) -> bool:
    """Positions are in the square's own metres."""
    shift = _shift(road_map, ORIGIN.latitude_deg, ORIGIN.longitude_deg)
    points = np.array([point for lane in road_map.lanes for point in lane.points])
    return bool(np.hypot(*(points - shift - [x_m, y_m]).T).min() < reach_m)


def _shift(road_map: RoadMap, latitude_deg: float, longitude_deg: float) -> Array:
    shift: Array = map_from_wgs84(road_map.origin, np.array([latitude_deg]), np.array([longitude_deg]))[0]
    return shift


def _block(first_id: int, west: float, south: float, east: float, north: float) -> Points:
    ring = ((west, south), (east, south), (east, north), (west, north))
    return {first_id + k: corner for k, corner in enumerate(ring)}


def test_equal_files_give_equal_maps(tmp_path: Path) -> None:
    assert encode_map(imported(tmp_path).map) == encode_map(imported(tmp_path).map)


def test_the_origin_is_the_middle_of_the_declared_bounds(tmp_path: Path) -> None:
    road_map = imported(tmp_path).map
    assert _shift(road_map, 31.0, 121.0) == pytest.approx((-100.0, -100.0), abs=0.1)


def test_without_declared_bounds_the_extent_of_the_roads_is_used_and_said(tmp_path: Path) -> None:
    report = imported(tmp_path, bounds=None)
    assert any("declares no bounds" in line for line in report.repairs)
    assert _shift(report.map, 31.0, 121.0) == pytest.approx((-100.0, -100.0), abs=0.1)


def test_ways_before_nodes_give_the_same_map(tmp_path: Path) -> None:
    path = square_file(tmp_path)
    lines = path.read_text(encoding="utf-8").splitlines()
    ways = [line for line in lines if line.startswith("<way")]
    rest = [line for line in lines if not line.startswith("<way")]
    other = tmp_path / "unsorted.osm"
    other.write_text("\n".join([*rest[:3], *ways, *reversed(rest[3:-1]), rest[-1]]), encoding="utf-8")
    assert import_osm(other).map == import_osm(path).map


def test_pbf_gives_the_same_map_as_xml(tmp_path: Path) -> None:
    path, packed = square_file(tmp_path), tmp_path / "square.osm.pbf"
    header = osmium.io.Header()
    with osmium.io.Reader(str(path)) as reader:
        header.add_box(reader.header().box())
    with osmium.SimpleWriter(str(packed), header=header) as writer:
        for item in osmium.FileProcessor(str(path)):
            writer.add(item)
    assert import_osm(packed).map.lanes == import_osm(path).map.lanes


def test_roads_are_clipped_to_the_bounds_and_the_loss_is_told(tmp_path: Path) -> None:
    far: Points = {20: (600.0, 0.0)}
    report = imported(tmp_path, points=far, ways={110: ([2, 20], SERVICE)})
    points = np.array([point for lane in report.map.lanes for point in lane.points])
    assert points[:, 0].max() < 250.0 + 20.0
    assert any("way 110: 250 m outside the bounds" in line for line in report.dropped)


def test_a_way_that_leaves_the_bounds_and_comes_back_is_not_joined_across(tmp_path: Path) -> None:
    far: Points = {20: (400.0, 50.0), 21: (400.0, 150.0)}
    report = imported(tmp_path, points=far, ways={110: ([2, 20, 21, 4], SERVICE)})
    assert not drives_near(report.map, 348.0, 100.0, 30.0)


def test_a_one_way_street_is_driven_one_way(tmp_path: Path) -> None:
    for value, direction in (("yes", 1), ("-1", -1)):
        ways: Ways = {104: ([5, 6], {"highway": "service", "name": "Middle", "oneway": value})}
        lanes = [lane for lane in imported(tmp_path, ways=ways).map.lanes if lane.name == "Middle"]
        roads = [lane for lane in lanes if lane.kind == "road"]
        assert len(roads) == 1
        assert (roads[0].points[-1][1] - roads[0].points[0][1]) * direction > 100.0


@pytest.mark.parametrize(
    "tags",
    [
        {"highway": "service", "access": "private"},
        {"highway": "service", "access": "no"},
        {"highway": "residential", "motor_vehicle": "no"},
        {"highway": "service", "width": "1.9"},
        {"highway": "service", "maxheight": "2"},
        {"highway": "footway"},
        {"highway": "path", "width": "2"},
        {"highway": "steps", "width": "5"},
        {"highway": "primary"},
        {"highway": "construction"},
        {"highway": "service", "area": "yes"},
    ],
)
def test_ways_that_a_shuttle_may_not_or_cannot_use_are_left_out(tmp_path: Path, tags: dict[str, str]) -> None:
    assert not drives_near(imported(tmp_path, ways={104: ([5, 6], tags)}).map, 100.0, 100.0)


@pytest.mark.parametrize(
    "tags",
    [
        {"highway": "service", "access": "private", "psv": "yes"},
        {"highway": "service", "motor_vehicle": "no", "bus": "designated"},
        {"highway": "path", "width": "3.5 m"},
        {"highway": "living_street"},
    ],
)
def test_ways_that_are_opened_for_buses_or_wide_enough_are_driven(
    tmp_path: Path, tags: dict[str, str]
) -> None:
    assert drives_near(imported(tmp_path, ways={104: ([5, 6], tags)}).map, 100.0, 100.0)


@pytest.mark.parametrize(
    ("tags", "passes"),
    [
        ({"barrier": "bollard"}, False),
        ({"barrier": "gate", "access": "no"}, False),
        ({"barrier": "lift_gate", "access": "private"}, False),
        ({"barrier": "gate"}, True),
        ({"barrier": "bollard", "bus": "yes"}, True),
    ],
)
def test_barriers_let_through_whom_their_tags_let_through(
    tmp_path: Path, tags: dict[str, str], passes: bool
) -> None:
    report = imported(tmp_path, points={9: (100, 100)}, ways={104: ([5, 9, 6], SERVICE)}, node_tags={9: tags})
    here = _shift(report.map, 31.0, 121.0) + np.array([100.0, 100.0])
    crossing = [
        lane
        for lane in report.map.lanes
        if np.hypot(*(np.array(lane.points) - here).T).min() < 1.0 and lane.kind == "road"
    ]
    assert bool(crossing) == passes


def test_roads_on_different_layers_cross_without_meeting(tmp_path: Path) -> None:
    points: Points = {9: (100, 100), 10: (0, 100), 11: (200, 100)}
    ways: Ways = {
        104: ([5, 9, 6], {**SERVICE, "name": "Middle"}),
        102: ([1, 10, 3], SERVICE),
        103: ([2, 11, 4], SERVICE),
        107: ([10, 9, 11], {**SERVICE, "layer": "1", "bridge": "yes", "name": "Over"}),
    }
    meeting = imported(
        tmp_path, points=points, ways=ways | {107: (ways[107][0], {**SERVICE, "name": "Over"})}
    )
    apart = imported(tmp_path, points=points, ways=ways)

    def turns(road_map: RoadMap) -> int:
        here = _shift(road_map, 31.0, 121.0) + np.array([100.0, 100.0])
        return sum(
            1
            for lane in road_map.lanes
            if lane.kind == "turn" and np.hypot(*(np.array(lane.points) - here).T).min() < 12.0
        )

    assert turns(meeting.map) >= 8
    assert turns(apart.map) == 0
    assert any("do not meet" in line for line in apart.repairs)


def test_a_road_is_wide_enough_to_pass_only_where_the_tags_say_so(tmp_path: Path) -> None:
    for tags, wide in (
        ({"lanes": "2"}, True),
        ({"width": "5"}, True),
        ({"width": "4.8"}, False),
        ({}, False),
    ):
        ways: Ways = {104: ([5, 6], {**SERVICE, "name": "Middle", **tags})}
        lanes = [
            lane
            for lane in imported(tmp_path, ways=ways).map.lanes
            if lane.name == "Middle" and lane.kind == "road"
        ]
        assert [lane.can_pass for lane in lanes] == [wide, wide]
        apart = math.dist(lanes[0].points[10], lanes[1].points[-11])
        assert (apart > 1.63 + 0.8 - 0.01) == wide


def test_traffic_keeps_to_the_side_that_is_asked_for(tmp_path: Path) -> None:
    ways: Ways = {104: ([5, 6], {**SERVICE, "name": "Middle", "lanes": "2"})}
    path = square_file(tmp_path, ways=ways)
    for left_hand, sign in ((False, 1.0), (True, -1.0)):
        road_map = import_osm(path, ImportOptions(left_hand=left_hand)).map
        middle_x = _shift(road_map, 31.0, 121.0)[0] + 100.0
        north = next(
            lane
            for lane in road_map.lanes
            if lane.name == "Middle" and lane.kind == "road" and lane.points[0][1] < lane.points[-1][1]
        )
        assert (north.points[10][0] - middle_x) * sign > 1.0


def test_speed_limits_are_read_in_both_units(tmp_path: Path) -> None:
    for text, expected in (("10", 10 / 3.6), ("10 mph", 4.4704), ("nonsense", 20 / 3.6)):
        ways: Ways = {104: ([5, 6], {**SERVICE, "name": "Middle", "maxspeed": text})}
        lanes = [
            x for x in imported(tmp_path, ways=ways).map.lanes if x.name == "Middle" and x.kind == "road"
        ]
        assert lanes[0].speed_limit_mps == pytest.approx(expected)


def test_repeated_nodes_twin_nodes_and_doubled_ways_are_repaired(tmp_path: Path) -> None:
    points: Points = {9: (100, 100), 19: (100.03, 100.0)}
    ways: Ways = {
        104: ([5, 9, 9], {**SERVICE, "name": "Middle"}),
        107: ([19, 6], {**SERVICE, "name": "Middle"}),
        108: ([6, 19], {**SERVICE, "name": "Middle"}),
    }
    report = imported(tmp_path, points=points, ways=ways)
    assert drives_near(report.map, 100.0, 100.0, 1.0)
    for words in ("no length removed", "lie in the same place", "another way draws too"):
        assert any(words in line for line in report.repairs), words


def test_a_node_that_the_file_lacks_cuts_the_way_and_is_told(tmp_path: Path) -> None:
    report = imported(tmp_path, ways={104: ([5, 999, 6], SERVICE)})
    assert any("the file lacks" in line for line in report.repairs)
    assert not drives_near(report.map, 100.0, 100.0)


def test_what_is_cut_off_from_the_largest_loop_is_listed(tmp_path: Path) -> None:
    points: Points = {20: (-100, 300), 21: (-20, 300), 22: (20, 340)}
    report = imported(tmp_path, points=points, ways={110: ([20, 21, 22], {**SERVICE, "name": "Island"})})
    assert "Island" not in lane_names(report.map)
    assert any("Island" in line and "largest loop" in line for line in report.dropped)


def test_a_dead_end_without_room_to_turn_is_left_out_and_listed(tmp_path: Path) -> None:
    points: Points = {20: (100.0, -60.0)}
    points |= _block(30, 80.0, -110.0, 95.0, -50.0) | _block(40, 105.0, -110.0, 120.0, -50.0)
    ways: Ways = {
        110: ([5, 20], {**SERVICE, "name": "Stub"}),
        120: ([30, 31, 32, 33, 30], {"building": "yes"}),
        121: ([40, 41, 42, 43, 40], {"building": "yes"}),
    }
    report = imported(tmp_path, points=points, ways=ways)
    assert "Stub" not in lane_names(report.map)
    assert any("Stub" in line and "no room to turn" in line for line in report.dropped)


def test_an_assumed_turning_place_is_listed_and_a_tagged_one_is_not(tmp_path: Path) -> None:
    tagged = imported(tmp_path)
    assert not any("assumed turning place" in line for line in tagged.repairs)
    assumed = imported(tmp_path, node_tags={7: {}, 8: {}})
    assert sum("assumed turning place" in line for line in assumed.repairs) == 2


def test_corners_are_rounded_to_what_a_shuttle_can_drive(tmp_path: Path) -> None:
    points: Points = {9: (70, 80), 10: (130, 120)}
    report = imported(tmp_path, points=points, ways={104: ([5, 9, 10, 6], SERVICE)})
    for lane in report.map.lanes:
        assert np.abs(curvatures(np.array(lane.points))).max() <= 1.0 / 5.0
    assert any("way 104: bends rounded" in line for line in report.repairs)


def test_a_hairpin_that_no_shuttle_can_drive_is_dropped_by_name(tmp_path: Path) -> None:
    points: Points = {9: (100, 110), 10: (101, 60), 11: (103, 150)}
    report = imported(tmp_path, points=points, ways={104: ([5, 9, 10, 11, 6], SERVICE)})
    assert any("way 104" in line for line in report.dropped)


def test_tagged_stops_are_used_and_other_modes_are_not(tmp_path: Path) -> None:
    points: Points = {50: (100, 4), 51: (-4, 100), 52: (204, 100), 53: (100, -140)}
    tags = {
        50: {"highway": "bus_stop", "name": "Süd 南", "name:en": "South"},
        51: {"public_transport": "platform", "name": "West"},
        52: {"public_transport": "stop_position", "railway": "stop", "name": "Metro"},
        53: {"highway": "bus_stop", "name": "Nowhere"},
    }
    report = imported(tmp_path, points=points, node_tags=tags)
    assert [(s.name, s.name_en, s.placed_by) for s in report.map.stops] == [
        ("Süd 南", "South", "tag"),
        ("West", "West", "tag"),
    ]
    assert any("stop Nowhere: no lane within 30 m" in line for line in report.dropped)


def test_without_tagged_stops_some_are_placed_by_rule(tmp_path: Path) -> None:
    stops = imported(tmp_path).map.stops
    assert len(stops) >= 4
    assert {stop.placed_by for stop in stops} == {"rule"}
    assert len({stop.name for stop in stops}) == len(stops)


def test_buildings_keep_their_heights_and_give_way_to_lanes(tmp_path: Path) -> None:
    points = _block(30, 20.0, 60.0, 60.0, 90.0) | _block(40, 90.0, 90.0, 110.0, 110.0)
    ways: Ways = {
        120: ([30, 31, 32, 33, 30], {"building": "yes", "building:levels": "5"}),
        121: ([40, 41, 42, 43, 40], {"building": "yes", "name": "Gate House"}),
    }
    report = imported(tmp_path, points=points, ways=ways)
    assert sorted({building.height_m for building in report.map.buildings}) == [9.0, 16.0]
    assert sum(building.name == "Gate House" for building in report.map.buildings) == 2
    assert any("Gate House" in line and "cut back" in line for line in report.repairs)


@pytest.mark.parametrize(
    ("name", "content", "code"),
    [
        ("a.osm", b"", "osm_empty"),
        ("a.osm", b"this is no XML", "osm_broken"),
        ("a.osm", b"<html></html>", "osm_broken"),
        ("a.osm", b'<osm version="0.6"><node id="1" lat="1" lon="1"/>', "osm_broken"),
        ("a.osm", b'<osm version="0.6"></osm>', "osm_void"),
        ("a.osm.pbf", b"garbage garbage garbage", "osm_broken"),
        ("a.txt", b"<osm/>", "osm_format"),
    ],
)
def test_files_that_are_no_map_are_refused_by_name(
    tmp_path: Path, name: str, content: bytes, code: str
) -> None:
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(MapError) as caught:
        import_osm(path)
    assert caught.value.code == code
    assert str(path) in caught.value.detail or name in caught.value.detail


def test_a_pbf_cut_anywhere_is_refused(tmp_path: Path) -> None:
    data = CAMPUS_SOURCE.read_bytes()
    path = tmp_path / "cut.osm.pbf"
    for cut in (1, 50, 5000, len(data) // 2, len(data) - 1):
        path.write_bytes(data[:cut])
        with pytest.raises(MapError) as caught:
            import_osm(path)
        assert caught.value.code == "osm_broken"


def test_a_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(MapError, match="osm_missing"):
        import_osm(tmp_path / "none.osm")


@pytest.mark.parametrize(
    ("ways", "code"),
    [
        ({100: ([1, 5, 2], {"highway": "footway"})}, "no_roads"),
        ({100: ([1, 2], SERVICE)}, "no_stops"),
        ({100: ([1, 2], {**SERVICE, "oneway": "yes"})}, "no_loop"),
    ],
)
def test_a_file_without_a_circuit_is_refused(tmp_path: Path, ways: Ways, code: str) -> None:
    path = tmp_path / "a.osm"
    path.write_text(osm_text({1: (0, 0), 2: (20, 0), 5: (10, 0)}, ways), encoding="utf-8")
    with pytest.raises(MapError) as caught:
        import_osm(path)
    assert caught.value.code == code


def test_on_a_single_road_there_is_room_for_a_single_shuttle(tmp_path: Path) -> None:
    path = tmp_path / "line.osm"
    path.write_text(osm_text({1: (0, 0), 2: (250, 0)}, {100: ([1, 2], SERVICE)}), encoding="utf-8")
    report = import_osm(path)
    assert len(report.map.resting_places) == 1
    assert len(report.map.stops) >= 2


def test_roads_too_short_to_drive_do_not_stop_an_import(tmp_path: Path) -> None:
    points: Points = {20: (101.0, -1.0), 21: (200.5, 200.5)}
    report = imported(tmp_path, points=points, ways={110: ([5, 20], SERVICE), 111: ([4, 21], SERVICE)})
    assert any("way 110" in line for line in report.dropped)
    assert any("way 111" in line for line in report.dropped)


def test_every_stop_of_a_made_up_campus_can_be_reached_from_every_other(tmp_path: Path) -> None:
    path = tmp_path / "campus.osm"
    path.write_bytes(generated_osm(3))
    road_map = import_osm(path).map
    network = RoadNetwork(road_map)
    clear = network.kept_clear(())
    for one in road_map.stops:
        for other in road_map.stops:
            assert find_route(network, one.lane_id, one.s_m, other.lane_id, other.s_m, clear) is not None


@pytest.mark.long
def test_the_shipped_campus_is_rebuilt_to_the_same_version() -> None:
    rows = csv.DictReader((CAMPUS / "names.csv").open(encoding="utf-8"))
    options = ImportOptions(
        campus_id="shu-baoshan",
        name="Shanghai University, Baoshan",
        timezone="Asia/Shanghai",
        bounds=Bounds(31.3126, 121.3809, 31.3239, 121.3964),
        names_en={row["name"]: row["name_en"] for row in rows},
    )
    report = import_osm(CAMPUS_SOURCE, options)
    shipped = load_map(CAMPUS_MAP)
    assert report.map.map_version == shipped.map_version
    assert 10 <= len(shipped.stops) <= 16
    assert all(stop.name and stop.name_en for stop in shipped.stops)
    assert len(shipped.resting_places) >= 4
    assert "OpenStreetMap contributors" in shipped.attribution


def test_the_square_is_what_these_tests_take_it_for(tmp_path: Path) -> None:
    assert {"South", "North", "West", "East", "Middle"} <= lane_names(imported(tmp_path).map)
    assert len(SQUARE_WAYS) == 7
