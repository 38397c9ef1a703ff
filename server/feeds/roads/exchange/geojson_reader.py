"""GeoJSON as it comes: our own maps, and the drawings of others as if they were OpenStreetMap data."""

import math
from collections.abc import Iterator
from typing import Any

import msgspec
import numpy as np

from contract.roads.load import MapError
from contract.roads.model import RoadMap
from contract.roads.projection import map_from_wgs84
from server.feeds.roads.exchange.elements import PREFIX, Element, Header, Shape, map_of
from server.feeds.roads.exchange.geojson_writer import MEMBER, TURNED
from server.feeds.roads.lanes.drafts import ImportLog

_SHAPES: dict[str, Shape] = {"Point": "point", "LineString": "line", "Polygon": "polygon"}


def decode_geojson(data: bytes) -> dict[str, Any]:
    """A FeatureCollection with a list of features. Raises MapError geojson_broken, geojson_void."""
    try:
        document = msgspec.json.decode(data)
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise MapError(
            "geojson_broken", f"the file is cut or is not JSON: {error}; export it again"
        ) from error
    if not isinstance(document, dict) or document.get("type") != "FeatureCollection":
        raise MapError("geojson_broken", "the file is JSON but no GeoJSON FeatureCollection; export it again")
    if not isinstance(document.get("features"), list) or not document["features"]:
        raise MapError("geojson_void", "the file has no features; export an area that has roads")
    return document


def is_ours(document: dict[str, Any]) -> bool:
    """The collection says what map it is of."""
    return isinstance(document.get(MEMBER), dict)


def map_from_geojson(document: dict[str, Any], log: ImportLog) -> RoadMap:
    """The map that `geojson_of` wrote, with what was changed since. Raises MapError."""
    try:
        header = msgspec.convert(document[MEMBER], Header)
    except msgspec.ValidationError as error:
        raise MapError("geojson_broken", f"the member {MEMBER}: {error}; export the map again") from error
    elements = []
    for number, kind, shape, pairs, properties in features_of(document):
        own = properties.get(f"{PREFIX}type")
        if not isinstance(own, str):
            log.dropped.append(f"feature {number}: a {kind} without {PREFIX}type")
            continue
        if properties.get(TURNED) is True:
            pairs = [pairs[0], *pairs[:0:-1]]
        longitude, latitude = np.array(pairs, dtype=np.float64).T
        fields = {
            key.removeprefix(PREFIX): value for key, value in properties.items() if key.startswith(PREFIX)
        }
        elements.append(Element(own, shape, map_from_wgs84(header.origin, latitude, longitude), fields))
    return map_of(header, elements, log)


def features_of(
    document: dict[str, Any],
) -> Iterator[tuple[int, str, Shape, list[tuple[float, float]], dict[str, Any]]]:
    """(number, geometry, shape, (longitude, latitude) pairs, properties) of every point, line and outer ring.

    Multi-geometries are taken apart. Raises MapError geojson_broken for coordinates that are none.
    """
    for number, feature in enumerate(document["features"], start=1):
        if not isinstance(feature, dict):
            raise MapError("geojson_broken", f"feature {number} is no object; export the file again")
        geometry, properties = feature.get("geometry"), feature.get("properties")
        if geometry is None:
            continue
        named = properties if isinstance(properties, dict) else {}
        try:
            for kind, coordinates in _parts(geometry):
                yield number, kind, _SHAPES[kind], _pairs(kind, coordinates), named
        except (TypeError, ValueError, KeyError, IndexError) as error:
            raise MapError(
                "geojson_broken",
                f"feature {number}: its coordinates are no longitudes and latitudes in degrees (WGS 84); "
                "export the file again in EPSG:4326",
            ) from error


def _parts(geometry: Any) -> Iterator[tuple[str, Any]]:
    kind = geometry["type"]
    if kind == "GeometryCollection":
        for part in geometry["geometries"]:
            yield from _parts(part)
    elif kind.startswith("Multi"):
        for part in geometry["coordinates"]:
            yield kind.removeprefix("Multi"), part
    else:
        yield kind, geometry["coordinates"]


def _pairs(kind: str, coordinates: Any) -> list[tuple[float, float]]:
    """Raises ValueError for what lies on no globe."""
    drawn = [coordinates] if kind == "Point" else coordinates
    if kind == "Polygon":
        drawn = drawn[0][:-1]
    pairs = [(float(place[0]), float(place[1])) for place in drawn]
    if not pairs or not all(abs(x) <= 180.0 and abs(y) <= 90.0 and math.isfinite(x + y) for x, y in pairs):
        raise ValueError(kind)
    return pairs
