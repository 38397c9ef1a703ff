"""Small OpenStreetMap files, written in metres."""

from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np

from contract.roads.model import Origin
from contract.roads.projection import wgs84_from_map

ORIGIN = Origin(31.0, 121.0)
Points = dict[int, tuple[float, float]]
Ways = dict[int, tuple[list[int], dict[str, str]]]

# A square of 200 m with a crossbar, all corners named by their place: 1 2 / 3 4 rows from the south.
SQUARE: Points = {1: (0, 0), 2: (200, 0), 3: (0, 200), 4: (200, 200), 5: (100, 0), 6: (100, 200)}
SQUARE_WAYS: Ways = {
    100: ([1, 5, 2], {"highway": "service", "name": "South"}),
    101: ([3, 6, 4], {"highway": "service", "name": "North"}),
    102: ([1, 3], {"highway": "service", "name": "West"}),
    103: ([2, 4], {"highway": "service", "name": "East"}),
    104: ([5, 6], {"highway": "service", "name": "Middle"}),
    # Where one turns round: a dead end on each side.
    105: ([1, 7], {"highway": "service"}),
    106: ([4, 8], {"highway": "service"}),
}
ENDS: Points = {7: (-70, -5), 8: (270, 205)}
END_TAGS = {7: {"highway": "turning_circle"}, 8: {"highway": "turning_circle"}}


def osm_text(
    points: Points,
    ways: Ways,
    node_tags: dict[int, dict[str, str]] | None = None,
    bounds: tuple[float, float, float, float] | None = (-150, -150, 350, 350),
    relations: str = "",
) -> str:
    """XML with nodes and ways as given; bounds (west, south, east, north) in metres, or none."""
    tags = node_tags or {}
    latitude, longitude = wgs84_from_map(ORIGIN, np.array(list(points.values()), dtype=float))
    lines = ['<?xml version="1.0"?>', '<osm version="0.6">']
    if bounds is not None:
        (south, north), (west, east) = wgs84_from_map(ORIGIN, np.array([bounds[:2], bounds[2:]], dtype=float))
        lines.append(
            f'<bounds minlat="{south:.9f}" minlon="{west:.9f}" maxlat="{north:.9f}" maxlon="{east:.9f}"/>'
        )
    for node_id, lat, lon in zip(points, latitude, longitude, strict=True):
        lines.append(
            f'<node id="{node_id}" version="1" lat="{lat:.9f}" lon="{lon:.9f}">'
            f"{_tags(tags.get(node_id, {}))}</node>"
        )
    for way_id, (refs, way_tags) in ways.items():
        nodes = "".join(f'<nd ref="{ref}"/>' for ref in refs)
        lines.append(f'<way id="{way_id}" version="1">{nodes}{_tags(way_tags)}</way>')
    return "\n".join([*lines, relations, "</osm>"])


def _tags(tags: dict[str, str]) -> str:
    return "".join(f"<tag k={quoteattr(k)} v={quoteattr(v)}/>" for k, v in tags.items())


def square_file(
    folder: Path,
    *,
    points: Points | None = None,
    ways: Ways | None = None,
    node_tags: dict[int, dict[str, str]] | None = None,
    bounds: tuple[float, float, float, float] | None = (-150, -150, 350, 350),
) -> Path:
    """The square with its dead ends, and whatever is added or replaced."""
    path = folder / "square.osm"
    path.write_text(
        osm_text(
            SQUARE | ENDS | (points or {}),
            SQUARE_WAYS | (ways or {}),
            END_TAGS | (node_tags or {}),
            bounds,
        ),
        encoding="utf-8",
    )
    return path
