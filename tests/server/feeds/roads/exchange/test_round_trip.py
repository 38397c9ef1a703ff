"""A map that goes out as GeoJSON or Lanelet2 comes back within 5 cm, with the same topology."""

import itertools
import json
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from contract.roads.load import load_map, with_version
from contract.roads.validate import problems
from server.feeds.roads.exchange.formats import EXPORTS, ExportFormat, format_of, import_map
from server.feeds.roads.lanes.curves import peak_curvature
from tests.contract.roads.generated_maps import generated_map
from tests.contract.roads.ring_map import ring_map
from tests.server.feeds.roads.exchange.drawn import farthest_m, topology, with_drawn
from tests.server.feeds.roads.osm_text import END_TAGS, ENDS, SQUARE, SQUARE_WAYS, osm_text
from tests.server.feeds.roads.shipped import CAMPUS_MAP, SNOW_LION_MAP

WITHIN_M = 0.05
FORMATS: tuple[ExportFormat, ...] = ("geojson", "lanelet2")
SHARE = st.floats(0.0, 1.0)
NAME = st.text(st.characters(codec="utf-8", exclude_categories=("C",)), min_size=1, max_size=40)


@pytest.mark.parametrize("kind", FORMATS)
@given(seed=st.integers(0, 3), zone=st.tuples(SHARE, SHARE), name=NAME, campus=NAME)
@settings(max_examples=8, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_a_map_comes_back(
    tmp_path: Path, kind: ExportFormat, seed: int, zone: tuple[float, float], name: str, campus: str
) -> None:
    drawn = with_version(replace(with_drawn(generated_map(seed), zone, name), name=campus))
    path = tmp_path / "map.file"
    path.write_bytes(EXPORTS[kind](drawn))
    assert format_of(path) == kind
    report = import_map(path)
    assert farthest_m(drawn, report.map) <= WITHIN_M
    assert topology(drawn) == topology(report.map)
    assert problems(report.map) == problems(drawn)
    assert (report.map.name, report.map.sections) == (campus, drawn.sections)


@pytest.mark.parametrize("kind", [*FORMATS, "map"])
@pytest.mark.parametrize("shipped", [pytest.param(CAMPUS_MAP, marks=pytest.mark.long), SNOW_LION_MAP])
def test_a_shipped_map_keeps_its_version(tmp_path: Path, kind: ExportFormat, shipped: Path) -> None:
    road_map = load_map(shipped)
    path = tmp_path / "map.file"
    path.write_bytes(EXPORTS[kind](road_map))
    report = import_map(path)
    assert report.map.map_version == road_map.map_version
    assert report.repairs == ()


@pytest.mark.parametrize("kind", FORMATS)
def test_successors_that_shared_ends_cannot_say_come_back(tmp_path: Path, kind: ExportFormat) -> None:
    """Two lanes end where two begin, and only one of the four ways between them is allowed."""
    ring = ring_map()
    first = ring.lanes[0]
    twin = replace(first, lane_id="twin", successors=())
    lanes = (replace(first, successors=("corner-0",)), twin, *ring.lanes[1:])
    lanes = tuple(
        replace(lane, successors=("side-0", "twin")) if lane.lane_id == "corner-3" else lane for lane in lanes
    )
    lanes = tuple(replace(lane, successors=("corner-0b",)) if lane is twin else lane for lane in lanes)
    corner = next(lane for lane in lanes if lane.lane_id == "corner-0")
    road_map = replace(ring, lanes=(*lanes, replace(corner, lane_id="corner-0b")))
    path = tmp_path / "map.file"
    path.write_bytes(EXPORTS[kind](road_map))
    assert topology(import_map(path).map) == topology(road_map)


def test_geojson_is_wgs84_with_outlines_counter_clockwise() -> None:
    road_map = generated_map(1)
    document = json.loads(EXPORTS["geojson"](road_map))
    rings = [
        feature["geometry"]["coordinates"][0]
        for feature in document["features"]
        if feature["geometry"]["type"] == "Polygon"
    ]
    assert rings
    for ring in rings:
        assert ring[0] == ring[-1]
        area = sum(a[0] * b[1] - b[0] * a[1] for a, b in itertools.pairwise(ring))
        assert area > 0.0
        assert all(abs(x - road_map.origin.longitude_deg) < 0.1 for x, _ in ring)


def test_a_stop_that_another_program_moved_is_put_where_it_is_drawn(tmp_path: Path) -> None:
    road_map = ring_map()
    document = json.loads(EXPORTS["geojson"](road_map))
    stop, other = (
        next(f for f in document["features"] if f["properties"].get("campusloop:stop_id") == name)
        for name in ("stop-0", "stop-1")
    )
    stop["geometry"]["coordinates"][0] += 0.0001
    path = tmp_path / "moved.geojson"
    path.write_text(json.dumps(document), encoding="utf-8")
    report = import_map(path)
    moved, kept = report.map.stops[0], report.map.stops[1]
    assert (moved.lane_id, kept) == ("side-0", road_map.stops[1])
    assert other["properties"]["name"] == "Side 1"
    # A ten-thousandth of a degree of longitude at 31 degrees north.
    assert moved.s_m == pytest.approx(60.0 + 9.55, abs=0.1)
    assert any("stop stop-0" in line for line in report.repairs)


def test_a_bound_never_folds_in_the_sharpest_bend() -> None:
    from server.feeds.roads.exchange.lanelet_bounds import bounds_of, joints_of

    lanes = generated_map(2).lanes
    for lane_id, bounds in bounds_of(lanes, joints_of(lanes)).items():
        for side in (bounds.left, bounds.right):
            assert peak_curvature(side) < 4.0, lane_id


@pytest.mark.parametrize("way", list(itertools.permutations(FORMATS)))
def test_a_map_of_openstreetmap_goes_through_both_formats_and_comes_back(
    tmp_path: Path, way: tuple[ExportFormat, ...]
) -> None:
    """OpenStreetMap to GeoJSON to Lanelet2, and the other way round: lanes, stops and tags are the same."""
    path = tmp_path / "square.osm"
    path.write_text(osm_text(SQUARE | ENDS, SQUARE_WAYS, END_TAGS))
    first = import_map(path).map
    drawn = first
    for kind in way:
        path = tmp_path / f"map.{kind}"
        path.write_bytes(EXPORTS[kind](drawn))
        drawn = import_map(path).map
    assert farthest_m(first, drawn) <= WITHIN_M
    assert topology(first) == topology(drawn)
    assert drawn.stops == first.stops
    assert [lane.scenario for lane in drawn.lanes] == [lane.scenario for lane in first.lanes]
    assert problems(drawn) == problems(first)
    assert drawn.map_version == first.map_version
