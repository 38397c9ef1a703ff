"""Foreign GeoJSON as OpenStreetMap data: lines become ways, and equal places one node.

Properties are taken as tags, as exports from OpenStreetMap have them. A line without `highway` counts as a
service road, and a line that ends on another one gets a node there.
"""

import itertools
import math
from collections.abc import Mapping
from typing import Any

import shapely

from contract.roads.load import MapError
from server.feeds.roads.exchange.geojson_reader import features_of
from server.feeds.roads.lanes.drafts import ImportLog
from server.feeds.roads.osm.osm_file import OsmData, OsmNode, OsmWay

_DEFAULT_CLASS = "service"
_PLACE_DECIMALS = 8
_END_REACH_M = 0.5
_JOINED_M = 0.1
_METRES_PER_DEGREE = 111_320.0
Pair = tuple[float, float]


class _Nodes:
    def __init__(self) -> None:
        self.found: dict[int, OsmNode] = {}
        self._ids: dict[Pair, int] = {}

    def at(self, place: Pair, tags: Mapping[str, str] | None = None) -> int:
        key = (round(place[0], _PLACE_DECIMALS), round(place[1], _PLACE_DECIMALS))
        node_id = self._ids.setdefault(key, len(self._ids) + 1)
        known = self.found.get(node_id)
        merged = dict(known.tags if known else {}) | dict(tags or {})
        self.found[node_id] = OsmNode(node_id, key[1], key[0], merged)
        return node_id


def osm_from_geojson(document: dict[str, Any], log: ImportLog) -> OsmData:
    """Nodes and ways of the features. Raises MapError geojson_broken, geojson_void (no lines)."""
    lines: list[tuple[list[Pair], dict[str, str]]] = []
    outlines: list[tuple[list[Pair], dict[str, str]]] = []
    nodes = _Nodes()
    unnamed = 0
    for _, kind, shape, pairs, properties in features_of(document):
        tags = _tags(properties)
        if shape == "point":
            nodes.at(pairs[0], tags)
        elif shape == "polygon":
            outlines.append(([*pairs, pairs[0]], tags))
        elif len(pairs) >= 2:
            if not tags.keys() & {"highway", "barrier", "waterway", "railway", "power", "building"}:
                tags["highway"] = _DEFAULT_CLASS
                unnamed += 1
            lines.append((pairs, tags))
        else:
            log.dropped.append(f"a {kind} of one place")
    if not lines:
        raise MapError("geojson_void", "the file has no lines; export the roads as LineString features")
    if unnamed:
        log.repairs.append(f"{unnamed} lines have no highway property: taken as {_DEFAULT_CLASS} roads")
    joined = _with_nodes_at_ends([pairs for pairs, _ in lines], log)
    drawn = [*zip(joined, (tags for _, tags in lines), strict=True), *outlines]
    ways = {
        number: OsmWay(number, tuple(nodes.at(place) for place in pairs), tags)
        for number, (pairs, tags) in enumerate(drawn, start=1)
    }
    return OsmData(dict(sorted(nodes.found.items())), ways, {}, None)


def _tags(properties: Mapping[str, Any]) -> dict[str, str]:
    """Plain values as text; osmtogeojson nests them under `tags`."""
    nested = properties.get("tags")
    own = nested if isinstance(nested, dict) else properties
    return {
        key: ("yes" if value is True else "no" if value is False else str(value))
        for key, value in own.items()
        if isinstance(value, str | int | float) and value != "" and not key.startswith("@")
    }


def _with_nodes_at_ends(lines: list[list[Pair]], log: ImportLog) -> list[list[Pair]]:
    """Lines with a node where another one ends on them: drawings often leave it out."""
    stretch = math.cos(math.radians(lines[0][0][1]))
    reach = _END_REACH_M / _METRES_PER_DEGREE
    flat = [shapely.LineString([(x * stretch, y) for x, y in pairs]) for pairs in lines]
    tree = shapely.STRtree(flat)
    joined = [list(pairs) for pairs in lines]
    count = 0
    for number, pairs in enumerate(lines):
        for which in (0, -1):
            end = shapely.Point(pairs[which][0] * stretch, pairs[which][1])
            for other in sorted(int(k) for k in tree.query(end, predicate="dwithin", distance=reach)):
                if other == number or pairs[which] in joined[other]:
                    continue
                near = min(lines[other], key=lambda place: math.dist(place, pairs[which]))
                # The importer joins nodes that are this near.
                if math.dist(near, pairs[which]) <= _JOINED_M / _METRES_PER_DEGREE:
                    continue
                _insert(joined[other], pairs[which], stretch)
                count += 1
    if count:
        log.repairs.append(f"{count} lines end on another one without a node there: joined")
    return joined


def _insert(line: list[Pair], place: Pair, stretch: float) -> None:
    point = shapely.Point(place[0] * stretch, place[1])
    sides = [
        shapely.LineString([(a[0] * stretch, a[1]), (b[0] * stretch, b[1])]).distance(point)
        for a, b in itertools.pairwise(line)
    ]
    line.insert(sides.index(min(sides)) + 1, place)
