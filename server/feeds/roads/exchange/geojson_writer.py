"""A road map as GeoJSON (RFC 7946): one feature for each element, in WGS 84."""

import itertools
from collections.abc import Mapping
from typing import Any

import msgspec
import numpy as np

from contract.roads.model import RoadMap
from contract.roads.projection import wgs84_from_map
from server.feeds.roads.exchange.elements import PREFIX, Element, elements_of, header_of

MEMBER = "campusloop"
TURNED = f"{PREFIX}turned"
# 0.01 mm: a place comes back to the map's tenth of a millimetre.
DEGREE_DECIMALS = 10


def geojson_of(road_map: RoadMap) -> bytes:
    """A FeatureCollection; the foreign member `campusloop` has what is not drawn."""
    elements = tuple(elements_of(road_map))
    places = _degrees(road_map, elements)
    document = {
        "type": "FeatureCollection",
        MEMBER: msgspec.to_builtins(header_of(road_map)),
        "features": [_feature(element, place) for element, place in zip(elements, places, strict=True)],
    }
    return msgspec.json.encode(document) + b"\n"


def _degrees(road_map: RoadMap, elements: tuple[Element, ...]) -> list[list[list[float]]]:
    """For each element its [longitude, latitude] pairs."""
    points = np.concatenate([element.points for element in elements]) if elements else np.zeros((0, 2))
    latitude, longitude = wgs84_from_map(road_map.origin, points)
    pairs = np.round(np.column_stack((longitude, latitude)), DEGREE_DECIMALS)
    ends = np.cumsum([len(element.points) for element in elements])[:-1]
    return [part.tolist() for part in np.split(pairs, ends)] if elements else []


def _feature(element: Element, pairs: list[list[float]]) -> dict[str, Any]:
    properties = _labels(element.fields) | {f"{PREFIX}type": element.kind}
    properties |= {f"{PREFIX}{key}": value for key, value in element.fields.items()}
    if element.shape == "polygon" and _runs_clockwise(pairs):
        # RFC 7946, 3.1.6: outer rings run counter-clockwise. A reader turns these round again.
        properties[TURNED] = True
        return _written(properties, "Polygon", [[pairs[0], *pairs[:0:-1], pairs[0]]])
    if element.shape == "polygon":
        return _written(properties, "Polygon", [[*pairs, pairs[0]]])
    if element.shape == "line":
        return _written(properties, "LineString", pairs)
    return _written(properties, "Point", pairs[0])


def _written(properties: dict[str, Any], kind: str, coordinates: Any) -> dict[str, Any]:
    geometry = {"type": kind, "coordinates": coordinates}
    return {"type": "Feature", "geometry": geometry, "properties": properties}


def _runs_clockwise(pairs: list[list[float]]) -> bool:
    ring = [*pairs, pairs[0]]
    return sum(a[0] * b[1] - b[0] * a[1] for a, b in itertools.pairwise(ring)) < 0.0


def _labels(fields: Mapping[str, Any]) -> dict[str, Any]:
    """Names as other programs show them."""
    labels = {}
    if fields.get("name"):
        labels["name"] = fields["name"]
    if fields.get("name_en"):
        labels["name:en"] = fields["name_en"]
    return labels
