"""Files that others wrote become sound maps, with a list of what was assumed."""

import json
import re
from pathlib import Path
from typing import Any

import pytest

from contract.roads.load import MapError
from contract.roads.validate import problems
from server.feeds.roads.exchange.formats import EXPORTS, import_map
from server.feeds.roads.generated import generated_osm
from server.feeds.roads.osm.osm_file import read_osm
from tests.contract.roads.generated_maps import generated_map, generated_report

SEED = 1


def without_our_tags(text: str) -> str:
    """A Lanelet2 file of ours as another program would have written it."""
    bare = re.sub(r'<tag k="campusloop:[^>]*/>', "", text)
    bare = re.sub(r'<relation id="\d+" version="1"><tag k="type" v="campusloop_map"/></relation>', "", bare)
    return re.sub(r'<member type="way" role="centerline" ref="\d+"/>', "", bare)


def foreign_geojson(folder: Path, *, tagged: bool = True) -> dict[str, Any]:
    source = folder / "made.osm"
    source.write_bytes(generated_osm(SEED))
    data = read_osm(source)
    features = []
    for way in data.ways.values():
        if not tagged and "highway" not in way.tags:
            continue
        line = [[data.nodes[k].longitude_deg, data.nodes[k].latitude_deg] for k in way.nodes]
        closed = way.nodes[0] == way.nodes[-1] and "building" in way.tags
        geometry = {"type": "Polygon" if closed else "LineString", "coordinates": [line] if closed else line}
        features.append(
            {"type": "Feature", "geometry": geometry, "properties": dict(way.tags) if tagged else {}}
        )
    features += [
        {
            "type": "Feature",
            "geometry": {"type": "Point", "coordinates": [node.longitude_deg, node.latitude_deg]},
            "properties": dict(node.tags),
        }
        for node in data.nodes.values()
        if node.tags and tagged
    ]
    return {"type": "FeatureCollection", "features": features}


def written(folder: Path, content: str | bytes | dict[str, Any]) -> Path:
    path = folder / "foreign.file"
    if isinstance(content, dict):
        content = json.dumps(content)
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


def test_tagged_geojson_gives_the_roads_of_the_osm_file(tmp_path: Path) -> None:
    report = import_map(written(tmp_path, foreign_geojson(tmp_path)))
    assert problems(report.map) == ()
    theirs = generated_report(SEED).map
    assert len(report.map.lanes) == pytest.approx(len(theirs.lanes), rel=0.1)
    assert report.map.attribution == ""


def test_plain_lines_are_taken_as_service_roads_and_said_so(tmp_path: Path) -> None:
    report = import_map(written(tmp_path, foreign_geojson(tmp_path, tagged=False)))
    assert problems(report.map) == ()
    assert any("taken as service roads" in line for line in report.repairs)


def test_a_line_that_ends_on_another_one_is_joined_to_it(tmp_path: Path) -> None:
    square = [[0.0, 0.0], [0.003, 0.0], [0.003, 0.003], [0.0, 0.003], [0.0, 0.0]]
    lines = [square, [[0.0015, 0.0000005], [0.0015, 0.0029999]]]
    features = [
        {"type": "Feature", "geometry": {"type": "LineString", "coordinates": line}, "properties": None}
        for line in lines
    ]
    report = import_map(written(tmp_path, {"type": "FeatureCollection", "features": features}))
    assert "2 lines end on another one without a node there: joined" in report.repairs
    assert any(lane.kind == "turn" for lane in report.map.lanes)


def test_lanelets_without_our_tags_become_a_sound_map(tmp_path: Path) -> None:
    source = generated_map(SEED)
    report = import_map(written(tmp_path, without_our_tags(EXPORTS["lanelet2"](source).decode())))
    assert problems(report.map) == ()
    # Its five loops are drawn in bounds that say little of their middle; the dead ends behind them are lost.
    assert len(report.map.lanes) >= 0.6 * len(source.lanes)
    assert len(report.map.stops) >= 2
    assert report.map.lanes[0].speed_limit_mps == pytest.approx(source.lanes[0].speed_limit_mps, abs=0.02)


def test_lanelets_with_local_places_only_are_put_about_their_middle(tmp_path: Path) -> None:
    text = without_our_tags(EXPORTS["lanelet2"](generated_map(SEED)).decode())
    local = re.sub(r'lat="[^"]*" lon="[^"]*"', 'lat="" lon=""', text)
    report = import_map(written(tmp_path, local))
    assert problems(report.map) == ()
    assert (report.map.origin.latitude_deg, report.map.origin.longitude_deg) == (0.0, 0.0)
    assert any("local places only" in line for line in report.repairs)


LANELETS = b'<osm><relation id="1"><tag k="type" v="lanelet"/></relation></osm>'
BAD: list[tuple[bytes, str]] = [
    (b"", "map_empty"),
    (b" \n ", "map_empty"),
    (b"{", "geojson_broken"),
    (b'{"type": "FeatureCollection"}', "geojson_void"),
    (b'{"type": "Feature", "features": [1]}', "geojson_broken"),
    (b'{"type": "FeatureCollection", "features": [1]}', "geojson_broken"),
    (b'{"type": "FeatureCollection", "features": [{"geometry": {"type": "Point"}}]}', "geojson_broken"),
    (
        b'{"type": "FeatureCollection", "features": [{"geometry": '
        b'{"type": "LineString", "coordinates": [[13497000.0, 3672000.0], [13497100.0, 3672000.0]]}}]}',
        "geojson_broken",
    ),
    (
        b'{"type": "FeatureCollection", "features": '
        b'[{"geometry": {"type": "Point", "coordinates": [1, 2]}}]}',
        "geojson_void",
    ),
    (b'{"type": "FeatureCollection", "campusloop": {"name": 3}, "features": [1]}', "geojson_broken"),
    (b'{"campus_id": "x"}', "map_broken"),
    (b'{"type": "FeatureCollection", "features": [\xff]}', "geojson_broken"),
    (LANELETS, "lanelet_broken"),
    (LANELETS[:-8], "lanelet_broken"),
    (LANELETS.replace(b'id="1"', b'id="one"'), "lanelet_broken"),
    (LANELETS.replace(b'k="type"', b'k="kind"'), "lanelet_void"),
    (b"<osm><node id='1' lat='x' lon='1'/><tag v='lanelet'/></osm>", "lanelet_broken"),
]


@pytest.mark.parametrize(("content", "code"), BAD)
def test_a_bad_file_is_refused_by_name(tmp_path: Path, content: bytes, code: str) -> None:
    with pytest.raises(MapError) as refused:
        import_map(written(tmp_path, content))
    assert refused.value.code == code
    assert len(refused.value.detail) > 20


@pytest.mark.parametrize("kind", ["geojson", "lanelet2"])
def test_a_file_that_is_cut_anywhere_is_refused_or_read(tmp_path: Path, kind: str) -> None:
    whole = EXPORTS[kind](generated_map(SEED))  # type: ignore[index]
    for share in (0.01, 0.2, 0.5, 0.9, 0.999):
        with pytest.raises(MapError):
            import_map(written(tmp_path, whole[: int(len(whole) * share)]))


def test_an_element_with_a_wrong_field_is_named(tmp_path: Path) -> None:
    document = json.loads(EXPORTS["geojson"](generated_map(SEED)))
    document["features"][0]["properties"]["campusloop:width_m"] = "wide"
    with pytest.raises(MapError, match=r"element_broken: lane .*width_m"):
        import_map(written(tmp_path, document))
