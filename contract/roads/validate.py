"""What is wrong with a road map: everything that another room takes for granted, checked."""

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence

import msgspec
import numpy as np

from contract.geometry import Array, arc_lengths, curvatures, project, resample, wrap_angle
from contract.roads.areas import crosses_itself, ground_m2, outline_array
from contract.roads.design_vehicle import (
    CURVATURE_MAX_1PM,
    CURVATURE_TOLERANCE_1PM,
    FRONT_REACH_M,
    REAR_OVERHANG_M,
    WIDTH_M,
)
from contract.roads.model import NAME_CHARACTERS_MAX, Lane, RoadMap
from contract.roads.section_graph import SectionGraph, broken_promises

_POINT_GAP_MAX_M = 1.0
_JOINT_GAP_MAX_M = 0.02
_JOINT_BEND_MAX_RAD = 0.06
_TILE_GAP_MAX_M = 0.001
_KERB_STEP_M = 0.25


class Problem(msgspec.Struct, frozen=True):
    """One defect: a stable code, the id it is found at, and what is wrong in words."""

    code: str
    where: str
    detail: str


def problems(road_map: RoadMap) -> tuple[Problem, ...]:
    """Everything that makes the map unfit for driving, empty for a good map.

    What depends on sound references (tiling, reachability, promises) is only looked at once they are sound.
    """
    first = (
        *_emptiness(road_map),
        *_doubled_ids(road_map),
        *_long_names(road_map),
        *_dangling(road_map),
        *_bad_points(road_map),
    )
    if first:
        return first
    lines = {lane.lane_id: np.array(lane.points, dtype=np.float64) for lane in road_map.lanes}
    second = (
        *_shapes(lines),
        *_joints(road_map.lanes, lines),
        *_tiling(road_map, lines),
        *_lopsided(road_map),
        *_off_lane(road_map, lines),
        *_bad_outlines(road_map),
        *_bad_zones(road_map, lines),
        *_kerbs_in_the_way(road_map, lines),
    )
    if any(problem.code in {"untiled", "off_lane"} for problem in second):
        return second
    return (*second, *_cut_off(road_map), *_promises(road_map), *_tight_places(road_map))


def _emptiness(road_map: RoadMap) -> Iterator[Problem]:
    for noun in ("lanes", "sections", "stops", "resting_places"):
        if not getattr(road_map, noun):
            yield Problem("empty", noun, f"the map has no {noun.replace('_', ' ')}")


def _doubled_ids(road_map: RoadMap) -> Iterator[Problem]:
    for ids in (
        [lane.lane_id for lane in road_map.lanes],
        [section.section_id for section in road_map.sections],
        [stop.stop_id for stop in road_map.stops],
        [place.place_id for place in road_map.resting_places],
        [trip.trip_id for trip in road_map.timetable],
        [area.area_id for area in road_map.observation_areas],
        [zone.zone_id for zone in road_map.no_stopping_zones],
        [kerb.kerb_id for kerb in road_map.kerbs],
        [sign.sign_id for sign in road_map.signs],
    ):
        for doubled, count in Counter(ids).items():
            if count > 1:
                yield Problem("doubled_id", doubled, f"used {count} times")


def _long_names(road_map: RoadMap) -> Iterator[Problem]:
    """Orders carry these over the wire, which bounds them."""
    named = (
        *((lane.lane_id,) for lane in road_map.lanes),
        *((section.section_id,) for section in road_map.sections),
        *((place.place_id,) for place in road_map.resting_places),
        *((area.area_id,) for area in road_map.observation_areas),
        *((zone.zone_id,) for zone in road_map.no_stopping_zones),
        *((kerb.kerb_id,) for kerb in road_map.kerbs),
        *((sign.sign_id,) for sign in road_map.signs),
        *((stop.stop_id, stop.name, stop.name_en) for stop in road_map.stops),
    )
    for names in named:
        longest = max(len(name) for name in names)
        if longest > NAME_CHARACTERS_MAX:
            detail = f"an id or name has {longest} characters; at most {NAME_CHARACTERS_MAX} are allowed"
            yield Problem("long_name", names[0][:NAME_CHARACTERS_MAX], detail)


def _dangling(road_map: RoadMap) -> Iterator[Problem]:
    lanes = {lane.lane_id for lane in road_map.lanes}
    sections = {section.section_id for section in road_map.sections}
    stops = {stop.stop_id for stop in road_map.stops}
    references: list[tuple[str, str, Iterable[str], set[str]]] = []
    references += [(lane.lane_id, "successor", lane.successors, lanes) for lane in road_map.lanes]
    references += [(s.section_id, "lane", (s.lane_id,), lanes) for s in road_map.sections]
    references += [(s.section_id, "conflict", s.conflicts, sections) for s in road_map.sections]
    references += [(stop.stop_id, "lane", (stop.lane_id,), lanes) for stop in road_map.stops]
    references += [(place.place_id, "lane", (place.lane_id,), lanes) for place in road_map.resting_places]
    references += [
        (area.area_id, "stop line's lane", [lane_id for lane_id, _ in area.stop_lines], lanes)
        for area in road_map.observation_areas
    ]
    references += [(zone.zone_id, "lane", (zone.lane_id,), lanes) for zone in road_map.no_stopping_zones]
    references += [(sign.sign_id, "lane", (sign.lane_id,), lanes) for sign in road_map.signs]
    references += [
        (trip.trip_id, "stop", [stop_id for stop_id, _ in trip.calls], stops) for trip in road_map.timetable
    ]
    for where, noun, ids, known in references:
        for missing in (name for name in ids if name not in known):
            yield Problem("dangling_id", where, f"{noun} {missing} is not in the map")


def _bad_points(road_map: RoadMap) -> Iterator[Problem]:
    for lane in road_map.lanes:
        if len(lane.points) < 2:
            yield Problem("too_few_points", lane.lane_id, "a lane needs two points at least")
        elif not all(math.isfinite(x) and math.isfinite(y) for x, y in lane.points):
            yield Problem("not_finite", lane.lane_id, "a point is not a finite number")
        if not (lane.speed_limit_mps > 0.0 and math.isfinite(lane.speed_limit_mps)):
            yield Problem("bad_speed", lane.lane_id, f"speed limit {lane.speed_limit_mps} m/s")
        if not (lane.width_m > 0.0 and math.isfinite(lane.width_m)):
            yield Problem("bad_width", lane.lane_id, f"width {lane.width_m} m")
    for kerb in road_map.kerbs:
        if len(kerb.points) < 2 or not all(math.isfinite(x) and math.isfinite(y) for x, y in kerb.points):
            yield Problem("bad_kerb", kerb.kerb_id, "a kerb needs two points with finite places")


def _shapes(lines: dict[str, Array]) -> Iterator[Problem]:
    for lane_id, points in lines.items():
        gaps = np.hypot(*np.diff(points, axis=0).T)
        if gaps.max() > _POINT_GAP_MAX_M + 1e-3:
            yield Problem("points_apart", lane_id, f"points {gaps.max():.2f} m apart, 1 m at most")
        if gaps.min() <= 0.0:
            yield Problem("points_doubled", lane_id, "two neighbouring points are the same")
            continue
        peak = float(np.abs(curvatures(points)).max())
        if peak > CURVATURE_MAX_1PM + CURVATURE_TOLERANCE_1PM:
            yield Problem("too_sharp", lane_id, f"radius {1.0 / peak:.2f} m, 5 m at least")


def _joints(lanes: Sequence[Lane], lines: dict[str, Array]) -> Iterator[Problem]:
    for lane in lanes:
        end = lines[lane.lane_id]
        for successor in lane.successors:
            start = lines[successor]
            gap = math.hypot(*(start[0] - end[-1]))
            if gap > _JOINT_GAP_MAX_M:
                yield Problem("gap", lane.lane_id, f"{successor} begins {gap:.2f} m from this lane's end")
                continue
            bend = abs(wrap_angle(_heading(start) - wrap_angle(_heading(end[::-1]) + math.pi)))
            if bend > _JOINT_BEND_MAX_RAD:
                yield Problem("kink", lane.lane_id, f"{successor} begins {math.degrees(bend):.1f} deg askew")


def _heading(points: Array) -> float:
    """The heading at the first point, half a step's bend before the first step's."""
    step = points[1] - points[0]
    yaw = math.atan2(step[1], step[0])
    if len(points) > 2:
        after = points[2] - points[1]
        first_m, second_m = math.hypot(*step), math.hypot(*after)
        yaw -= wrap_angle(math.atan2(after[1], after[0]) - yaw) * first_m / (first_m + second_m)
    return yaw


def _tiling(road_map: RoadMap, lines: dict[str, Array]) -> Iterator[Problem]:
    spans: dict[str, list[tuple[float, float]]] = {lane_id: [] for lane_id in lines}
    for section in road_map.sections:
        spans[section.lane_id].append((section.s_from_m, section.s_to_m))
    for lane_id, pieces in spans.items():
        pieces.sort()
        length = float(arc_lengths(lines[lane_id])[-1])
        cuts = [0.0, *(end for _, end in pieces)]
        starts = [*(start for start, _ in pieces), length]
        if any(not abs(a - b) <= _TILE_GAP_MAX_M for a, b in zip(cuts, starts, strict=True)):
            yield Problem("untiled", lane_id, "its sections leave gaps, overlap or end beside its end")
        elif any(end <= start for start, end in pieces):
            yield Problem("untiled", lane_id, "a section has no length")


def _lopsided(road_map: RoadMap) -> Iterator[Problem]:
    conflicts = {section.section_id: set(section.conflicts) for section in road_map.sections}
    for section_id, others in conflicts.items():
        if section_id in others:
            yield Problem("lopsided_conflict", section_id, "conflicts with itself")
        for other in sorted(others):
            if section_id not in conflicts[other]:
                yield Problem("lopsided_conflict", section_id, f"{other} does not name it in return")


def _off_lane(road_map: RoadMap, lines: dict[str, Array]) -> Iterator[Problem]:
    placed = [(stop.stop_id, stop.lane_id, stop.s_m) for stop in road_map.stops]
    placed += [(place.place_id, place.lane_id, place.s_m) for place in road_map.resting_places]
    placed += [(sign.sign_id, sign.lane_id, sign.s_m) for sign in road_map.signs]
    placed += [
        (area.area_id, lane_id, s_m)
        for area in road_map.observation_areas
        for lane_id, s_m in area.stop_lines
    ]
    for where, lane_id, s_m in placed:
        length = float(arc_lengths(lines[lane_id])[-1])
        if not 0.0 <= s_m <= length:
            yield Problem("off_lane", where, f"s = {s_m:.1f} m on a lane of {length:.1f} m")


def _bad_outlines(road_map: RoadMap) -> Iterator[Problem]:
    for area in road_map.observation_areas:
        outline = outline_array(area)
        if len(outline) < 3 or not np.all(np.isfinite(outline)):
            yield Problem("bad_outline", area.area_id, "an outline needs three corners with finite places")
        elif crosses_itself(outline) or ground_m2(outline) <= 0.0:
            yield Problem("bad_outline", area.area_id, "the outline crosses itself or encloses nothing")


def _bad_zones(road_map: RoadMap, lines: dict[str, Array]) -> Iterator[Problem]:
    for zone in road_map.no_stopping_zones:
        length = float(arc_lengths(lines[zone.lane_id])[-1])
        if not 0.0 <= zone.s_from_m < zone.s_to_m <= length + _TILE_GAP_MAX_M:
            detail = f"{zone.s_from_m:.1f} to {zone.s_to_m:.1f} m on a lane of {length:.1f} m"
            yield Problem("bad_zone", zone.zone_id, detail)
            continue
        standing = [(stop.stop_id, stop.lane_id, stop.s_m) for stop in road_map.stops]
        standing += [(place.place_id, place.lane_id, place.s_m) for place in road_map.resting_places]
        for where, lane_id, s_m in standing:
            rear_m, front_m = s_m - REAR_OVERHANG_M, s_m + FRONT_REACH_M
            if lane_id == zone.lane_id and rear_m < zone.s_to_m and front_m > zone.s_from_m:
                yield Problem("in_no_stopping_zone", where, f"a shuttle here stands in {zone.zone_id}")


def _kerbs_in_the_way(road_map: RoadMap, lines: dict[str, Array]) -> Iterator[Problem]:
    for kerb in road_map.kerbs:
        edge = resample(np.array(kerb.points, dtype=np.float64), _KERB_STEP_M)
        low, high = edge.min(axis=0) - WIDTH_M, edge.max(axis=0) + WIDTH_M
        for lane_id, points in lines.items():
            near = np.flatnonzero(np.all((points >= low) & (points <= high), axis=1))
            if len(near) == 0:
                continue
            s = arc_lengths(points)
            first, last = int(near[0]) - 1, int(near[-1]) + 1
            apart_m = min(abs(float(project(points, s, x, y, first, last)[1])) for x, y in edge)
            if apart_m < WIDTH_M / 2.0:
                detail = f"{kerb.kerb_id} is {apart_m:.2f} m from this lane's line: a shuttle would touch it"
                yield Problem("kerb_in_the_way", lane_id, detail)


def _cut_off(road_map: RoadMap) -> Iterator[Problem]:
    graph = _graph(road_map)
    onward, back = graph.reach(0, ()), graph.reach(0, (), backwards=True)
    for i, section in enumerate(road_map.sections):
        if i not in onward or i not in back:
            yield Problem("cut_off", section.section_id, "not in one loop with the map's first section")


def _promises(road_map: RoadMap) -> Iterator[Problem]:
    broken = broken_promises(_graph(road_map), road_map.resting_places, road_map.stops)
    for place_id, detail in broken:
        yield Problem("broken_promise", place_id, detail)


def _tight_places(road_map: RoadMap) -> Iterator[Problem]:
    graph = _graph(road_map)
    for place in road_map.resting_places:
        section = road_map.sections[graph.at(place.lane_id, place.s_m)]
        inside = place.s_m - REAR_OVERHANG_M >= section.s_from_m and (
            place.s_m + FRONT_REACH_M <= section.s_to_m
        )
        if not inside:
            yield Problem(
                "tight_place", place.place_id, f"a shuttle sticks out of section {section.section_id}"
            )


def _graph(road_map: RoadMap) -> SectionGraph:
    return SectionGraph(road_map.sections, [(lane.lane_id, lane.successors) for lane in road_map.lanes])
