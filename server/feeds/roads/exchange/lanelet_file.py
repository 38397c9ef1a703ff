"""A Lanelet2 file as it is written: nodes, ways and relations of OSM XML, with tags of any length."""

import math
import xml.etree.ElementTree as ET
from collections.abc import Mapping
from dataclasses import dataclass, field
from io import BytesIO
from typing import Any

import numpy as np

from contract.geometry import Array
from contract.roads.load import MapError
from contract.roads.model import Origin
from contract.roads.projection import map_from_wgs84
from server.feeds.roads.exchange.elements import PREFIX
from server.feeds.roads.lanes.drafts import ImportLog

Tags = Mapping[str, str]


@dataclass(frozen=True, slots=True)
class Way:
    nodes: tuple[int, ...]
    tags: Tags


@dataclass(frozen=True, slots=True)
class Relation:
    """members: (type, role, ref)."""

    members: tuple[tuple[str, str, int], ...]
    tags: Tags

    def of_role(self, role: str) -> list[int]:
        return [ref for kind, name, ref in self.members if kind == "way" and name == role]


@dataclass(slots=True)
class LaneletFile:
    """degrees: node -> (latitude, longitude), NaN where the file has none; local: node -> (x, y) in m."""

    degrees: dict[int, tuple[float, float]] = field(default_factory=dict)
    local: dict[int, tuple[float, float]] = field(default_factory=dict)
    node_tags: dict[int, Tags] = field(default_factory=dict)
    ways: dict[int, Way] = field(default_factory=dict)
    relations: dict[int, Relation] = field(default_factory=dict)


def read_lanelet_file(data: bytes) -> LaneletFile:
    """Raises MapError lanelet_broken (cut, no XML, numbers that are none), lanelet_void (no lanelet)."""
    file = LaneletFile()
    try:
        for _, item in ET.iterparse(BytesIO(data)):
            if item.tag in ("node", "way", "relation"):
                _enter(file, item)
                item.clear()
    except ET.ParseError as error:
        raise MapError(
            "lanelet_broken", f"the file is cut or is not XML: {error}; export it again"
        ) from error
    except (KeyError, ValueError) as error:
        raise MapError(
            "lanelet_broken", f"the file has an id or a place that is none ({error}); export it again"
        ) from error
    if not any(relation.tags.get("type") == "lanelet" for relation in file.relations.values()):
        raise MapError("lanelet_void", "the file has no lanelet relation; export the lanes too")
    return file


def _enter(file: LaneletFile, item: ET.Element) -> None:
    number = int(item.attrib["id"])
    tags = {tag.attrib["k"]: tag.attrib["v"] for tag in item.iter("tag")}
    if item.attrib.get("action") == "delete":
        return
    if item.tag == "way":
        file.ways[number] = Way(tuple(int(nd.attrib["ref"]) for nd in item.iter("nd")), tags)
    elif item.tag == "relation":
        members = (
            (m.attrib["type"], m.attrib.get("role", ""), int(m.attrib["ref"])) for m in item.iter("member")
        )
        file.relations[number] = Relation(tuple(members), tags)
    else:
        file.degrees[number] = (_degrees(item, "lat"), _degrees(item, "lon"))
        if "local_x" in tags and "local_y" in tags:
            file.local[number] = (float(tags["local_x"]), float(tags["local_y"]))
        file.node_tags[number] = {k: v for k, v in tags.items() if k not in ("local_x", "local_y", "ele")}


def _degrees(item: ET.Element, name: str) -> float:
    """NaN where the attribute is missing or empty, as maps with local places only have it."""
    text = item.attrib.get(name, "")
    return float(text) if text else math.nan


def joined(tags: Tags, key: str) -> str:
    """The text of numbered tags, empty if there are none."""
    pieces = sorted((name, value) for name, value in tags.items() if name.startswith(f"{PREFIX}{key}:"))
    return "".join(value for _, value in pieces)


def places_of(file: LaneletFile, origin: Origin) -> dict[int, tuple[float, float]]:
    """Every node in metres about the origin, by its degrees."""
    latitude, longitude = np.array(list(file.degrees.values()), dtype=np.float64).reshape(-1, 2).T
    points = np.round(map_from_wgs84(origin, latitude, longitude), 6) + 0.0
    return dict(zip(file.degrees, ((float(x), float(y)) for x, y in points), strict=True))


def foreign_places(file: LaneletFile, log: ImportLog) -> tuple[Origin, dict[int, tuple[float, float]]]:
    """(origin, places) of a file that names no origin: the middle of its extent. Raises MapError."""
    degrees = np.array(list(file.degrees.values()), dtype=np.float64).reshape(-1, 2)
    if len(degrees) and np.all(np.isfinite(degrees)) and float(np.abs(degrees).max()) > 0.0:
        if np.abs(degrees[:, 0]).max() > 90.0 or np.abs(degrees[:, 1]).max() > 180.0:
            raise MapError("lanelet_broken", "lat or lon is out of range; export the file again in degrees")
        low, high = degrees.min(axis=0), degrees.max(axis=0)
        origin = Origin(round(float(low[0] + high[0]) / 2.0, 7), round(float(low[1] + high[1]) / 2.0, 7))
        return origin, places_of(file, origin)
    if len(file.local) < len(file.degrees) or not file.local:
        raise MapError("lanelet_broken", "some nodes have neither lat and lon nor local_x and local_y")
    points = np.array(list(file.local.values()), dtype=np.float64)
    middle = (points.min(axis=0) + points.max(axis=0)) / 2.0
    log.repairs.append(
        "the file has local places only: its middle lies at 0 degrees north and east until an origin is given"
    )
    shifted = np.round(points - middle, 6) + 0.0
    return Origin(0.0, 0.0), dict(zip(file.local, ((float(x), float(y)) for x, y in shifted), strict=True))


def line_of(file: LaneletFile, places: Mapping[int, tuple[float, float]], way_id: int, what: str) -> Array:
    """(n, 2) points of a way. Raises MapError lanelet_broken where it or one of its nodes is missing."""
    way = file.ways.get(way_id)
    if way is None or not all(node in places for node in way.nodes) or len(way.nodes) < 2:
        raise MapError("lanelet_broken", f"{what}: way {way_id} or a node of it is missing; export it again")
    return np.array([places[node] for node in way.nodes], dtype=np.float64)


def fields_of(tags: Tags) -> dict[str, Any]:
    """The fields under our prefix, as text."""
    return {
        key.removeprefix(PREFIX): value
        for key, value in tags.items()
        if key.startswith(PREFIX) and ":" not in key.removeprefix(PREFIX)
    }
