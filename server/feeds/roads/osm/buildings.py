"""Buildings and water as polygons, and buildings as the simulator's obstacles."""

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from contract.geometry import Array, Pose2, arc_lengths, pose_at, transform_points
from contract.roads.design_vehicle import FRONT_REACH_M, REAR_OVERHANG_M, WIDTH_M
from contract.roads.model import Building
from server.feeds.roads.lanes.drafts import ImportLog, LaneDraft
from server.feeds.roads.osm.drivable import metres
from server.feeds.roads.osm.frame import Frame
from server.feeds.roads.osm.osm_file import OsmData, Tags

LEVEL_M = 3.2
ASSUMED_HEIGHT_M = 9.0
_SIMPLIFY_M = 0.3
_LEAST_AREA_M2 = 4.0
# What a shuttle keeps to its sides while it drives (0.4 m), and room for its sensors' and its steering's
# errors: nothing that stands nearer may be left, or every shuttle waits for a wall to step aside.
_BODY_ROOM_M = 0.9
_POSE_STEP_M = 0.5
_REACH_M = FRONT_REACH_M + WIDTH_M + 2.0 * _BODY_ROOM_M
_OVERHEAD = ("no", "roof", "canopy", "carport")


@dataclass(frozen=True, slots=True)
class Feature:
    """A closed outline of the file, in the map frame."""

    feature_id: int
    outline: shapely.Polygon
    tags: Tags


def features(data: OsmData, frame: Frame) -> list[Feature]:
    """Every closed way and multipolygon that has tags and whose middle is inside the box, by id.

    Inner rings are left out: a courtyard is part of its building's ground.
    """
    found: list[Feature] = []
    for way in data.ways.values():
        if way.tags and len(way.nodes) >= 4 and way.nodes[0] == way.nodes[-1]:
            ring = [frame.positions[ref] for ref in way.nodes if ref in frame.positions]
            found += _features(way.way_id, [shapely.Polygon(ring)] if len(ring) >= 4 else [], way.tags)
    for area in data.areas.values():
        lines = [
            shapely.LineString([frame.positions[ref] for ref in data.ways[way_id].nodes])
            for way_id in area.outer_ways
            if way_id in data.ways and _is_line(data, frame, way_id)
        ]
        rings = shapely.get_parts(shapely.polygonize(lines)) if lines else []
        found += _features(area.relation_id, rings, area.tags)
    box = shapely.box(*frame.low, *frame.high)
    return [feature for feature in found if box.contains(feature.outline.representative_point())]


def _is_line(data: OsmData, frame: Frame, way_id: int) -> bool:
    nodes = data.ways[way_id].nodes
    return len(nodes) >= 2 and all(ref in frame.positions for ref in nodes)


def _features(feature_id: int, rings: Iterable[shapely.Geometry], tags: Tags) -> list[Feature]:
    return [
        Feature(feature_id, polygon, tags)
        for ring in rings
        for polygon in _polygons(shapely.make_valid(ring))
    ]


def _polygons(shape: shapely.Geometry) -> list[shapely.Polygon]:
    return [
        part
        for part in shapely.get_parts(shape)
        if part.geom_type == "Polygon" and part.area >= _LEAST_AREA_M2
    ]


def is_building(feature: Feature) -> bool:
    return feature.tags.get("building", "no") not in _OVERHEAD


def is_water(feature: Feature) -> bool:
    return feature.tags.get("natural") == "water" or feature.tags.get("waterway") == "riverbank"


def obstacles(found: Sequence[Feature], drafts: Sequence[LaneDraft], log: ImportLog) -> tuple[Building, ...]:
    """The buildings, simplified, cut back where a lane passes under or close beside them."""
    lanes = [shapely.LineString(draft.points) for draft in drafts]
    tree = shapely.STRtree(lanes)
    kept: list[Building] = []
    for feature in found:
        if not is_building(feature):
            continue
        shape = shapely.simplify(feature.outline, _SIMPLIFY_M)
        near = tree.query(shape, predicate="dwithin", distance=_REACH_M)
        bodies = [_bodies(drafts[int(i)].points) for i in sorted(near)]
        in_the_way = [body for along in bodies for body in along[shapely.intersects(along, shape)]]
        if in_the_way:
            corridor = shapely.union_all(in_the_way)
            shape = shapely.simplify(shapely.difference(shape, corridor), _SIMPLIFY_M / 3.0)
            log.repairs.append(f"building {_label(feature)}: cut back where a lane passes")
        for polygon in _polygons(shape):
            ring = polygon.exterior.coords[:-1]
            outline = tuple((round(float(x), 2), round(float(y), 2)) for x, y in ring)
            kept.append(Building(outline, height_m(feature.tags), feature.tags.get("name", "")))
    return tuple(kept)


def _bodies(points: Array) -> Array:
    """Shuttles with room on each side, as polygons, along the (n, 2) way of their rear axle."""
    s = arc_lengths(points)
    axles = np.linspace(0.0, float(s[-1]), max(2, math.ceil(float(s[-1]) / _POSE_STEP_M) + 1))
    back, front = -REAR_OVERHANG_M, FRONT_REACH_M + _BODY_ROOM_M
    half = WIDTH_M / 2.0 + _BODY_ROOM_M
    outline = np.array([(back, -half), (front, -half), (front, half), (back, half)])
    placed = [transform_points(Pose2(*pose_at(points, s, axle)), outline) for axle in axles]
    polygons: Array = shapely.polygons(np.array(placed))
    return polygons


def _label(feature: Feature) -> str:
    name = feature.tags.get("name")
    return f"{feature.feature_id} ({name})" if name else str(feature.feature_id)


def height_m(tags: Tags) -> float:
    """The tagged height, else 3.2 m a level, else 9 m."""
    tagged = metres(tags.get("height", ""))
    if tagged:
        return round(tagged, 2)
    levels = re.fullmatch(r"\s*(\d+(?:\.\d+)?)\s*", tags.get("building:levels", ""))
    if levels and float(levels[1]) > 0.0:
        return round(float(levels[1]) * LEVEL_M, 2)
    return ASSUMED_HEIGHT_M
