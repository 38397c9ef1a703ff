"""An OpenStreetMap file, XML or PBF, read whole; the order of its contents does not matter."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import osmium

from contract.roads.load import MapError

Tags = Mapping[str, str]
_SUFFIXES = (".osm", ".osm.xml", ".xml", ".osm.gz", ".osm.bz2", ".osm.pbf", ".pbf")
_FORMATS = {".xml": "osm", ".pbf": "pbf"}


@dataclass(frozen=True, slots=True)
class OsmNode:
    node_id: int
    latitude_deg: float
    longitude_deg: float
    tags: Tags


@dataclass(frozen=True, slots=True)
class OsmWay:
    way_id: int
    nodes: tuple[int, ...]
    tags: Tags


@dataclass(frozen=True, slots=True)
class OsmArea:
    """A multipolygon relation: the ways of its outer rings."""

    relation_id: int
    outer_ways: tuple[int, ...]
    tags: Tags


@dataclass(frozen=True, slots=True)
class Bounds:
    """A box in degrees."""

    south_deg: float
    west_deg: float
    north_deg: float
    east_deg: float


@dataclass(frozen=True, slots=True)
class OsmData:
    """Everything by id, in ascending order of ids, and the box that the file declares, if it does."""

    nodes: Mapping[int, OsmNode]
    ways: Mapping[int, OsmWay]
    areas: Mapping[int, OsmArea]
    bounds: Bounds | None


def read_osm(path: Path) -> OsmData:
    """The file's nodes, ways and multipolygons.

    Raises MapError: osm_missing, osm_empty, osm_format (an unknown ending), osm_broken (cut or not
    OpenStreetMap data), osm_void (no nodes or no ways).
    """
    try:
        size = path.stat().st_size
    except OSError as error:
        raise MapError(
            "osm_missing", f"cannot read {path}: {error.strerror}; check the file's name"
        ) from error
    if not path.is_file():
        raise MapError("osm_missing", f"{path} is not a file; give an .osm or .osm.pbf file")
    if size == 0:
        raise MapError("osm_empty", f"{path} is empty; download or export it again")
    if not path.name.lower().endswith(_SUFFIXES):
        raise MapError("osm_format", f"{path.name}: give a file that ends in .osm, .osm.pbf or .osm.gz")
    try:
        data = _read(path)
    except RuntimeError as error:
        raise MapError(
            "osm_broken",
            f"{path} is cut or is not OpenStreetMap data ({error}); download or export it again",
        ) from error
    if not data.nodes or not data.ways:
        raise MapError("osm_void", f"{path} has no nodes or no ways; export an area that has roads")
    return data


def _read(path: Path) -> OsmData:
    source = osmium.io.File(str(path), _FORMATS.get(path.suffix.lower(), ""))
    nodes: dict[int, OsmNode] = {}
    ways: dict[int, OsmWay] = {}
    areas: dict[int, OsmArea] = {}
    reader = osmium.io.Reader(source)
    try:
        box = reader.header().box()
    finally:
        reader.close()
    for item in osmium.FileProcessor(source):
        if isinstance(item, osmium.osm.Changeset) or item.deleted:
            continue
        tags = {tag.k: tag.v for tag in item.tags}
        if isinstance(item, osmium.osm.Node) and item.location.valid():
            nodes[item.id] = OsmNode(item.id, item.location.lat, item.location.lon, tags)
        elif isinstance(item, osmium.osm.Way):
            ways[item.id] = OsmWay(item.id, tuple(node.ref for node in item.nodes), tags)
        elif isinstance(item, osmium.osm.Relation) and tags.get("type") == "multipolygon":
            outer = tuple(m.ref for m in item.members if m.type == "w" and m.role in ("outer", ""))
            areas[item.id] = OsmArea(item.id, outer, tags)
    return OsmData(
        dict(sorted(nodes.items())), dict(sorted(ways.items())), dict(sorted(areas.items())), _bounds(box)
    )


def _bounds(box: osmium.osm.Box) -> Bounds | None:
    if not box.valid() or box.size() <= 0.0:
        return None
    low, high = box.bottom_left, box.top_right
    return Bounds(low.lat, low.lon, high.lat, high.lon)
