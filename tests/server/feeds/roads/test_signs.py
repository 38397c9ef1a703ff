"""Signs that are tagged, and those that the import puts where a small road meets a bigger one."""

from pathlib import Path

import pytest

from contract.roads.load import load_map
from contract.roads.model import RoadMap
from server.feeds.roads.import_osm import import_osm
from server.feeds.roads.places.signs import STOP_FROM_RATIO, YIELD_FROM_RATIO
from tests.server.feeds.roads.osm_text import END_TAGS, SQUARE_WAYS, square_file
from tests.server.feeds.roads.shipped import CAMPUS_MAP

# A node of the square's west side, half way.
WEST = SQUARE_WAYS | {102: ([1, 9, 3], {"highway": "service", "name": "West", "width": "4"})}


def with_sign(folder: Path, **tags: str) -> RoadMap:
    path = square_file(folder, points={9: (0.0, 100.0)}, ways=WEST, node_tags=END_TAGS | {9: tags})
    return import_osm(path).map


@pytest.mark.parametrize(("value", "kind"), [("stop", "stop"), ("give_way", "yield")])
def test_a_tagged_sign_stands_at_its_node_on_one_lane(tmp_path: Path, value: str, kind: str) -> None:
    road_map = with_sign(tmp_path, highway=value, direction="forward")
    (sign,) = [one for one in road_map.signs if one.sign_id == "sign-9"]
    assert (sign.kind, sign.side) == (kind, "right")
    assert sign.lane_id.endswith("f")
    other = with_sign(tmp_path, highway=value, direction="backward")
    assert [one.lane_id[-1] for one in other.signs if one.sign_id == "sign-9"] == ["b"]


def test_roads_of_one_speed_limit_get_no_sign_by_rule(tmp_path: Path) -> None:
    assert with_sign(tmp_path).signs == ()


def test_the_shipped_campus_has_signs_where_a_small_road_meets_a_bigger_one() -> None:
    road_map = load_map(CAMPUS_MAP)
    limits = {lane.lane_id: lane.speed_limit_mps for lane in road_map.lanes}
    lines = {(lane_id, s_m): area for area in road_map.observation_areas for lane_id, s_m in area.stop_lines}
    assert {sign.kind for sign in road_map.signs} == {"stop", "yield"}
    for sign in road_map.signs:
        area = lines[sign.lane_id, sign.s_m]
        ratio = max(limits[lane_id] for lane_id, _ in area.stop_lines) / limits[sign.lane_id]
        assert ratio >= (STOP_FROM_RATIO if sign.kind == "stop" else YIELD_FROM_RATIO)
