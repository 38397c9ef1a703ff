"""The map frame of an import: its origin, its extent, and every node in metres."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from contract.geometry import Array
from contract.roads.load import MapError
from contract.roads.model import Origin
from contract.roads.projection import map_from_wgs84
from server.feeds.roads.lanes.drafts import ImportLog
from server.feeds.roads.osm.drivable import ROADS
from server.feeds.roads.osm.osm_file import Bounds, OsmData


@dataclass(frozen=True, slots=True)
class Frame:
    """positions: node id -> (x, y) in metres; low, high: corners of the box that is kept."""

    origin: Origin
    positions: Mapping[int, tuple[float, float]]
    low: tuple[float, float]
    high: tuple[float, float]
    declared: bool


def frame_of(data: OsmData, log: ImportLog) -> Frame:
    """The frame about the middle of the declared bounds, or of the roads where none are declared.

    Raises MapError no_roads where there is neither.
    """
    declared = data.bounds is not None
    bounds = data.bounds or _extent_of_roads(data)
    if not declared:
        log.repairs.append("the file declares no bounds: the extent of its roads is used")
    origin = Origin(
        round((bounds.south_deg + bounds.north_deg) / 2.0, 7),
        round((bounds.west_deg + bounds.east_deg) / 2.0, 7),
    )
    latitude = np.array([node.latitude_deg for node in data.nodes.values()])
    longitude = np.array([node.longitude_deg for node in data.nodes.values()])
    # Processors differ in the last bits of sines; rounded to a micrometre, equal files give equal maps.
    points = np.round(map_from_wgs84(origin, latitude, longitude), 6) + 0.0
    corners = _corners(origin, bounds)
    return Frame(
        origin,
        {node_id: (float(x), float(y)) for node_id, (x, y) in zip(data.nodes, points, strict=True)},
        (float(corners[:, 0].min()), float(corners[:, 1].min())),
        (float(corners[:, 0].max()), float(corners[:, 1].max())),
        declared,
    )


def _extent_of_roads(data: OsmData) -> Bounds:
    ids = {
        ref
        for way in data.ways.values()
        if way.tags.get("highway") in ROADS
        for ref in way.nodes
        if ref in data.nodes
    }
    if not ids:
        raise MapError("no_roads", "the file has no roads; export an area with roads a shuttle can use")
    nodes = [data.nodes[ref] for ref in ids]
    return Bounds(
        min(node.latitude_deg for node in nodes),
        min(node.longitude_deg for node in nodes),
        max(node.latitude_deg for node in nodes),
        max(node.longitude_deg for node in nodes),
    )


def _corners(origin: Origin, bounds: Bounds) -> Array:
    latitude = np.array([bounds.south_deg, bounds.south_deg, bounds.north_deg, bounds.north_deg])
    longitude = np.array([bounds.west_deg, bounds.east_deg, bounds.west_deg, bounds.east_deg])
    corners: Array = np.round(map_from_wgs84(origin, latitude, longitude), 6)
    return corners


def inside(frame: Frame, points: Iterable[tuple[float, float]]) -> list[bool]:
    """For each point, whether it is in the kept box."""
    (x0, y0), (x1, y1) = frame.low, frame.high
    return [x0 - 1e-6 <= x <= x1 + 1e-6 and y0 - 1e-6 <= y <= y1 + 1e-6 for x, y in points]
