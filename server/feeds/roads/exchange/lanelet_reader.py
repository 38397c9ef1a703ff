"""Our own Lanelet2 files back as road maps: centre lines, tags under `campusloop:`, and shared end points."""

from collections.abc import Mapping

import msgspec
import numpy as np

from contract.roads.load import MapError
from contract.roads.model import RoadMap
from server.feeds.roads.exchange.elements import Element, Header, Shape, map_of
from server.feeds.roads.exchange.lanelet_file import (
    LaneletFile,
    Relation,
    fields_of,
    joined,
    line_of,
    places_of,
)
from server.feeds.roads.exchange.lanelet_writer import HEADER_TYPE
from server.feeds.roads.lanes.drafts import ImportLog

_CLOSED_KINDS = ("observation_area", "building")


def header_in(file: LaneletFile) -> Header | None:
    """What the file says of the map, None for one that we did not write. Raises MapError lanelet_broken."""
    for relation in file.relations.values():
        if relation.tags.get("type") == HEADER_TYPE:
            try:
                return msgspec.json.decode(joined(relation.tags, "header"), type=Header)
            except (msgspec.DecodeError, msgspec.ValidationError) as error:
                raise MapError(
                    "lanelet_broken", f"relation of type {HEADER_TYPE}: {error}; export the map again"
                ) from error
    return None


def map_from_lanelets(file: LaneletFile, header: Header, log: ImportLog) -> RoadMap:
    """The map that `lanelet2_of` wrote, with what was changed since. Raises MapError."""
    places = places_of(file, header.origin)
    elements = [*_lanes(file, places, log)]
    for way in file.ways.values():
        fields = fields_of(way.tags)
        kind = fields.get("type")
        if kind is not None:
            nodes = way.nodes[:-1] if kind in _CLOSED_KINDS else way.nodes
            points = np.array([places[node] for node in nodes if node in places], dtype=np.float64)
            shape: Shape = "polygon" if kind in _CLOSED_KINDS else "line"
            elements.append(Element(kind, shape, points.reshape(-1, 2), fields))
    for node, tags in file.node_tags.items():
        fields = fields_of(tags)
        if "type" in fields:
            elements.append(Element(fields["type"], "point", np.array([places[node]]), fields))
    return map_of(header, elements, log)


def _lanes(file: LaneletFile, places: Mapping[int, tuple[float, float]], log: ImportLog) -> list[Element]:
    lanelets = {
        relation_id: relation
        for relation_id, relation in file.relations.items()
        if relation.tags.get("type") == "lanelet"
    }
    names: dict[int, str] = {}
    for relation_id, relation in lanelets.items():
        name = fields_of(relation.tags).get("lane_id")
        if name is None:
            log.dropped.append(f"lanelet {relation_id}: it has no lane_id; draw it in the map editor instead")
        else:
            names[relation_id] = name
    after = successors_in(file, {number: lanelets[number] for number in names})
    found = []
    for relation_id, name in names.items():
        relation = lanelets[relation_id]
        centre = relation.of_role("centerline")
        if not centre:
            raise MapError(
                "lanelet_broken", f"lanelet {relation_id} ({name}) has no centerline; export it again"
            )
        written = joined(relation.tags, "successors")
        successors = msgspec.json.decode(written) if written else [names[k] for k in after[relation_id]]
        fields = fields_of(relation.tags) | {"successors": successors}
        found.append(Element("lane", "line", line_of(file, places, centre[0], name), fields))
    return found


def successors_in(file: LaneletFile, lanelets: Mapping[int, Relation]) -> dict[int, list[int]]:
    """The lanelets that follow each: they begin with the points that both bounds of this one end with."""
    ends = {number: _ends(file, relation) for number, relation in lanelets.items()}
    begins: dict[tuple[int, int], list[int]] = {}
    for number, (first, _) in ends.items():
        begins.setdefault(first, []).append(number)
    return {number: begins.get(last, []) for number, (_, last) in ends.items()}


def _ends(file: LaneletFile, relation: Relation) -> tuple[tuple[int, int], tuple[int, int]]:
    """((first left, first right), (last left, last right)) nodes. Raises MapError lanelet_broken."""
    nodes = []
    for role in ("left", "right"):
        ways = [file.ways[ref].nodes for ref in relation.of_role(role) if ref in file.ways]
        if not ways or not ways[0]:
            raise MapError("lanelet_broken", f"a lanelet has no {role} bound; export it again")
        nodes.append(ways[0])
    return (nodes[0][0], nodes[1][0]), (nodes[0][-1], nodes[1][-1])
