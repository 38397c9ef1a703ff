"""A road map as drawn elements, each with a shape and its fields: what both formats carry.

Sections are left out: they are derived from the lanes (`server.feeds.roads.derived`). Ids, widths and all
else that a foreign format has no word for goes under the prefix `campusloop:`.
"""

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Literal, TypeVar

import msgspec
import numpy as np
import shapely

from contract.geometry import Array, arc_lengths, pose_at, project
from contract.roads.load import MapError, content_version
from contract.roads.model import (
    Building,
    Kerb,
    Lane,
    NoStoppingZone,
    ObservationArea,
    Origin,
    RestingPlace,
    RoadMap,
    RoadSign,
    Stop,
    TimetableTrip,
)
from server.feeds.roads.derived import derived
from server.feeds.roads.lanes.drafts import ImportLog

PREFIX = "campusloop:"
Shape = Literal["point", "line", "polygon"]
T = TypeVar("T", bound=msgspec.Struct)
# What two programs may differ by in a place before the drawn place wins over the written one.
SAME_PLACE_M = 0.05
_DECIMALS = 4
_HALF_LINE_M = 1.5


@dataclass(frozen=True, slots=True)
class Element:
    """One thing on the map: points (n, 2) in the map frame; an outline is closed implicitly."""

    kind: str
    shape: Shape
    points: Array
    fields: Mapping[str, Any]

    @property
    def label(self) -> str:
        name = next((str(value) for key, value in self.fields.items() if key.endswith("_id")), "")
        return f"{self.kind} {name}".strip()


class Header(msgspec.Struct, frozen=True):
    """What a map says of itself beside what is drawn."""

    campus_id: str
    name: str
    origin: Origin
    timezone: str = "UTC"
    schematic: bool = False
    attribution: str = ""
    repairs: tuple[str, ...] = ()
    timetable: tuple[TimetableTrip, ...] = ()
    map_version: str = ""


def header_of(road_map: RoadMap) -> Header:
    return Header(
        road_map.campus_id,
        road_map.name,
        road_map.origin,
        road_map.timezone,
        road_map.schematic,
        road_map.attribution,
        road_map.repairs,
        road_map.timetable,
        content_version(road_map),
    )


def elements_of(road_map: RoadMap) -> Iterator[Element]:
    """Everything that is drawn, in the order of the map."""
    lines = {lane.lane_id: np.array(lane.points, dtype=np.float64) for lane in road_map.lanes}
    for lane in road_map.lanes:
        yield Element("lane", "line", lines[lane.lane_id], _fields(lane, "points"))
    for stop in road_map.stops:
        yield Element("stop", "point", _place(lines, stop.lane_id, stop.s_m), _fields(stop))
    for place in road_map.resting_places:
        yield Element("resting_place", "point", _place(lines, place.lane_id, place.s_m), _fields(place))
    for area in road_map.observation_areas:
        outline = np.array(area.outline, dtype=np.float64)
        yield Element("observation_area", "polygon", outline, {"area_id": area.area_id, "kind": area.kind})
        for lane_id, s_m in area.stop_lines:
            fields = {"area_id": area.area_id, "lane_id": lane_id, "s_m": s_m}
            yield Element("stop_line", "line", _across(lines[lane_id], s_m), fields)
    for zone in road_map.no_stopping_zones:
        stretch = _stretch(lines[zone.lane_id], zone.s_from_m, zone.s_to_m)
        yield Element("no_stopping_zone", "line", stretch, _fields(zone))
    for kerb in road_map.kerbs:
        yield Element("kerb", "line", np.array(kerb.points, dtype=np.float64), _fields(kerb, "points"))
    for sign in road_map.signs:
        yield Element("sign", "point", _place(lines, sign.lane_id, sign.s_m), _fields(sign))
    for building in road_map.buildings:
        outline = np.array(building.outline, dtype=np.float64)
        yield Element("building", "polygon", outline, _fields(building, "outline"))


def map_of(header: Header, elements: Iterable[Element], log: ImportLog) -> RoadMap:
    """The map of its elements, derived parts included. Raises MapError element_broken.

    A place that was moved by another program wins over the lane and length that are written beside it.
    """
    by_kind: dict[str, list[Element]] = {}
    for element in elements:
        by_kind.setdefault(element.kind, []).append(element)
    lanes = tuple(_read(e, Lane, points=_pairs(e.points)) for e in by_kind.get("lane", ()))
    lines = {lane.lane_id: np.array(lane.points, dtype=np.float64) for lane in lanes}
    ground = _Ground(lines)
    stop_lines: dict[str, list[tuple[str, float]]] = {}
    for element in by_kind.get("stop_line", ()):
        lane_id, s_m = ground.settled(element, element.points.mean(axis=0), log)
        stop_lines.setdefault(str(element.fields.get("area_id", "")), []).append((lane_id, s_m))
    road_map = RoadMap(
        campus_id=header.campus_id,
        name=header.name,
        origin=header.origin,
        lanes=lanes,
        sections=(),
        stops=tuple(_placed(e, Stop, ground, log) for e in by_kind.get("stop", ())),
        resting_places=tuple(_placed(e, RestingPlace, ground, log) for e in by_kind.get("resting_place", ())),
        buildings=tuple(_read(e, Building, outline=_pairs(e.points)) for e in by_kind.get("building", ())),
        timetable=header.timetable,
        timezone=header.timezone,
        schematic=header.schematic,
        attribution=header.attribution,
        repairs=header.repairs,
        observation_areas=tuple(
            _read(
                e,
                ObservationArea,
                outline=_pairs(e.points),
                stop_lines=tuple(stop_lines.get(str(e.fields.get("area_id", "")), ())),
            )
            for e in by_kind.get("observation_area", ())
        ),
        no_stopping_zones=tuple(_zone(e, ground, log) for e in by_kind.get("no_stopping_zone", ())),
        kerbs=tuple(_read(e, Kerb, points=_pairs(e.points)) for e in by_kind.get("kerb", ())),
        signs=tuple(_placed(e, RoadSign, ground, log) for e in by_kind.get("sign", ())),
    )
    return derived(road_map, log)


def _fields(thing: msgspec.Struct, *drawn: str) -> dict[str, Any]:
    return {
        name: msgspec.to_builtins(value)
        for name, value in msgspec.structs.asdict(thing).items()
        if name not in drawn
    }


def _read(element: Element, kind: type[T], **drawn: Any) -> T:
    known = {field.encode_name for field in msgspec.structs.fields(kind)}
    fields = {key: value for key, value in element.fields.items() if key in known}
    try:
        return msgspec.convert(fields | drawn, kind, strict=False)
    except msgspec.ValidationError as error:
        raise MapError(
            "element_broken", f"{element.label}: {error}; mend or remove it in the file"
        ) from error


def _pairs(points: Array) -> tuple[tuple[float, float], ...]:
    rounded = np.round(points, _DECIMALS) + 0.0
    return tuple((float(x), float(y)) for x, y in rounded)


def _place(lines: Mapping[str, Array], lane_id: str, s_m: float) -> Array:
    line = lines[lane_id]
    x_m, y_m, _ = pose_at(line, arc_lengths(line), s_m)
    return np.array([[x_m, y_m]])


def _across(line: Array, s_m: float) -> Array:
    """A line of 3 m across the lane, whose middle is the place."""
    x_m, y_m, yaw = pose_at(line, arc_lengths(line), s_m)
    left = np.array([-math.sin(yaw), math.cos(yaw)]) * _HALF_LINE_M
    middle = np.array([x_m, y_m])
    return np.vstack((middle + left, middle - left))


def _stretch(line: Array, from_m: float, to_m: float) -> Array:
    s = arc_lengths(line)
    ends = [pose_at(line, s, at_m)[:2] for at_m in (from_m, to_m)]
    stretch: Array = np.vstack((ends[0], line[(s > from_m) & (s < to_m)], ends[1]))
    return stretch


class _Ground:
    """Lanes by the places on them."""

    def __init__(self, lines: Mapping[str, Array]) -> None:
        self._lines = lines
        self._names = list(lines)
        self._tree = shapely.STRtree([shapely.LineString(lines[name]) for name in self._names])

    def settled(self, element: Element, place: Array, log: ImportLog) -> tuple[str, float]:
        """(lane_id, s_m) of an element drawn at a place (2,): what is written, if it is still there."""
        lane_id, s_m = element.fields.get("lane_id"), element.fields.get("s_m")
        return self.at(element, place, lane_id, s_m, log)

    def at(self, element: Element, place: Array, lane_id: Any, s_m: Any, log: ImportLog) -> tuple[str, float]:
        line = self._lines.get(str(lane_id))
        if line is not None and _is_number(s_m):
            here = pose_at(line, arc_lengths(line), float(s_m))[:2]
            if math.dist(here, place) <= SAME_PLACE_M:
                return str(lane_id), float(s_m)
        if line is None:
            nearest = self._tree.nearest(shapely.Point(place)) if self._names else None
            if nearest is None:
                raise MapError("element_broken", f"{element.label}: the file has no lane that it could be on")
            lane_id = self._names[int(nearest)]
            line = self._lines[lane_id]
        at_m, aside_m, _ = project(line, arc_lengths(line), float(place[0]), float(place[1]), 0, len(line))
        moved = f"{abs(aside_m):.1f} m from where it is drawn"
        log.repairs.append(f"{element.label}: put on lane {lane_id} at {at_m:.1f} m, {moved}")
        return str(lane_id), round(float(at_m), 3)


def _is_number(value: Any) -> bool:
    try:
        return math.isfinite(float(value))
    except (TypeError, ValueError):
        return False


def _placed(element: Element, kind: type[T], ground: _Ground, log: ImportLog) -> T:
    lane_id, s_m = ground.settled(element, element.points[0], log)
    return _read(element, kind, lane_id=lane_id, s_m=s_m)


def _zone(element: Element, ground: _Ground, log: ImportLog) -> NoStoppingZone:
    fields = element.fields
    lane_id, from_m = ground.at(
        element, element.points[0], fields.get("lane_id"), fields.get("s_from_m"), log
    )
    _, to_m = ground.at(element, element.points[-1], lane_id, fields.get("s_to_m"), log)
    return _read(element, NoStoppingZone, lane_id=lane_id, s_from_m=from_m, s_to_m=to_m)
