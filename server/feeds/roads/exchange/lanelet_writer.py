"""A road map as a Lanelet2 file: OpenStreetMap XML with lanelet relations.

Each lane is a lanelet with left and right bound and its exact centre line. Places have lat and lon, and
local_x and local_y in the map frame. What Lanelet2 has no word for is in tags under `campusloop:`.
"""

import json
from collections.abc import Iterable, Mapping
from typing import Any
from xml.sax.saxutils import quoteattr

import msgspec
import numpy as np

from contract.geometry import Array
from contract.roads.model import Lane, RoadMap
from contract.roads.projection import wgs84_from_map
from server.feeds.roads.exchange.elements import PREFIX, Element, elements_of, header_of
from server.feeds.roads.exchange.lanelet_bounds import Bounds, bounds_of, joints_of, unsaid_by_joints

HEADER_TYPE = "campusloop_map"
# OpenStreetMap's programs take values of at most 255 characters.
VALUE_CHARACTERS_MAX = 250
_KMH = 3.6
_WAY_TAGS: Mapping[str, Mapping[str, str]] = {
    "stop_line": {"type": "stop_line"},
    "no_stopping_zone": {"type": "no_stopping_area"},
    "kerb": {"type": "curbstone", "subtype": "high"},
    "building": {"type": "building", "building": "yes", "area": "yes"},
}
_NODE_TAGS: Mapping[str, Mapping[str, str]] = {
    "stop": {"highway": "bus_stop"},
    "resting_place": {"amenity": "parking_space"},
    "sign": {"type": "traffic_sign"},
}
_AREA_TYPES = {"crossing": "crosswalk_polygon", "intersection": "intersection_area"}


class _File:
    """Nodes, ways and relations with ids from 1 on; nodes in the map frame until the file is written."""

    def __init__(self) -> None:
        self.points: list[Array] = []
        self.node_tags: dict[int, Mapping[str, str]] = {}
        self.ways: list[tuple[int, list[int], Mapping[str, str]]] = []
        self.relations: list[tuple[int, list[tuple[str, str, int]], Mapping[str, str]]] = []
        self._last_id = 0
        self._count = 0

    def nodes(self, points: Array) -> list[int]:
        first = self._count + 1
        self._count += len(points)
        self.points.append(points)
        return list(range(first, self._count + 1))

    def way(self, nodes: list[int], tags: Mapping[str, str]) -> int:
        self._last_id += 1
        self.ways.append((self._last_id, nodes, tags))
        return self._last_id

    def relation(self, members: list[tuple[str, str, int]], tags: Mapping[str, str]) -> None:
        self._last_id += 1
        self.relations.append((self._last_id, members, tags))


def lanelet2_of(road_map: RoadMap) -> bytes:
    """The map as OSM XML, UTF-8."""
    file = _File()
    joints = joints_of(road_map.lanes)
    bounds = bounds_of(road_map.lanes, joints)
    unsaid = unsaid_by_joints(road_map.lanes, joints)
    corners: dict[tuple[int, int], int] = {}
    for lane in road_map.lanes:
        _write_lane(file, lane, bounds[lane.lane_id], corners, lane.lane_id in unsaid)
    for element in elements_of(road_map):
        if element.kind != "lane":
            _write_element(file, element)
    header = msgspec.json.encode(header_of(road_map)).decode()
    file.relation([], {"type": HEADER_TYPE} | chunked("header", header))
    return _xml(file, road_map)


def chunked(key: str, text: str) -> dict[str, str]:
    """A long text in numbered tags, each short enough for OpenStreetMap's programs."""
    pieces = [text[i : i + VALUE_CHARACTERS_MAX] for i in range(0, len(text), VALUE_CHARACTERS_MAX)] or [""]
    return {f"{PREFIX}{key}:{number:05d}": piece for number, piece in enumerate(pieces)}


def _write_lane(
    file: _File, lane: Lane, bounds: Bounds, corners: dict[tuple[int, int], int], names_successors: bool
) -> None:
    is_turn = lane.kind != "road"
    bound_tags = {"type": "virtual"} if is_turn else {"type": "line_thin", "subtype": "solid"}
    sides = []
    for number, points in enumerate((bounds.left, bounds.right)):
        ends = [
            corners.get((joint, number)) or corners.setdefault((joint, number), file.nodes(place[None, :])[0])
            for joint, place in zip(bounds.joints, (points[0], points[-1]), strict=True)
        ]
        sides.append(file.way([ends[0], *file.nodes(points[1:-1]), ends[1]], bound_tags))
    centre = file.way(file.nodes(np.array(lane.points)), {"type": "virtual", "subtype": "centerline"})
    fields: dict[str, Any] = msgspec.structs.asdict(lane)
    del fields["points"], fields["successors"]
    tags = {
        "type": "lanelet",
        "subtype": "road",
        "location": "urban",
        "one_way": "yes",
        "participant:vehicle": "yes",
        "speed_limit": f"{lane.speed_limit_mps * _KMH:.1f} km/h",
    }
    if names_successors:
        tags |= chunked("successors", json.dumps(lane.successors, ensure_ascii=False))
    members = [("way", "left", sides[0]), ("way", "right", sides[1]), ("way", "centerline", centre)]
    file.relation(members, tags | own_tags("lane", fields))


def _write_element(file: _File, element: Element) -> None:
    own = own_tags(element.kind, element.fields)
    if element.shape == "point":
        (node,) = file.nodes(element.points)
        file.node_tags[node] = {**_NODE_TAGS[element.kind], **_names(element), **own}
        return
    nodes = file.nodes(element.points)
    if element.kind == "observation_area":
        tags = {"type": _AREA_TYPES[str(element.fields["kind"])], "area": "yes"}
    else:
        tags = dict(_WAY_TAGS[element.kind])
    if element.shape == "polygon":
        nodes.append(nodes[0])
    file.way(nodes, tags | _names(element) | own)


def own_tags(kind: str, fields: Mapping[str, Any]) -> dict[str, str]:
    """Fields as tags; what is no text is written as JSON."""
    texts = {key: value if isinstance(value, str) else json.dumps(value) for key, value in fields.items()}
    return {f"{PREFIX}type": kind} | {PREFIX + key: text for key, text in texts.items()}


def _names(element: Element) -> dict[str, str]:
    labels = {"name": element.fields.get("name", ""), "name:en": element.fields.get("name_en", "")}
    return {key: str(value) for key, value in labels.items() if value}


def _xml(file: _File, road_map: RoadMap) -> bytes:
    points = np.concatenate(file.points) if file.points else np.zeros((0, 2))
    latitude, longitude = wgs84_from_map(road_map.origin, points)
    lines = ['<?xml version="1.0" encoding="UTF-8"?>', '<osm version="0.6" generator="campusloop">']
    rows = zip(points.tolist(), latitude.tolist(), longitude.tolist(), strict=True)
    for number, ((x_m, y_m), lat, lon) in enumerate(rows, start=1):
        local = f'<tag k="local_x" v="{x_m:.4f}"/><tag k="local_y" v="{y_m:.4f}"/><tag k="ele" v="0"/>'
        own = _tag_text(file.node_tags.get(number, {}))
        lines.append(f'<node id="{number}" version="1" lat="{lat:.10f}" lon="{lon:.10f}">{local}{own}</node>')
    # Ids of ways and relations follow those of nodes: Lanelet2 wants all of them different.
    shift = len(points)
    for way_id, nodes, tags in file.ways:
        refs = "".join(f'<nd ref="{node}"/>' for node in nodes)
        lines.append(f'<way id="{way_id + shift}" version="1">{refs}{_tag_text(tags)}</way>')
    for relation_id, members, tags in file.relations:
        content = _members(members, shift) + _tag_text(tags)
        lines.append(f'<relation id="{relation_id + shift}" version="1">{content}</relation>')
    return "\n".join([*lines, "</osm>", ""]).encode()


def _members(members: Iterable[tuple[str, str, int]], shift: int) -> str:
    return "".join(
        f'<member type="{kind}" role="{role}" ref="{number + shift}"/>' for kind, role, number in members
    )


def _tag_text(tags: Mapping[str, str]) -> str:
    return "".join(f"<tag k={quoteattr(key)} v={quoteattr(value)}/>" for key, value in tags.items())
