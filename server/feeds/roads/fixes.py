"""Problems of a drawn map that can be mended without a person: one function for each code."""

from collections.abc import Callable, Mapping

import numpy as np
import shapely
from msgspec.structs import replace

from contract.geometry import Array, arc_lengths, pose_at, resample
from contract.roads.design_vehicle import FRONT_REACH_M, REAR_OVERHANG_M
from contract.roads.model import Lane, NoStoppingZone, ObservationArea, Point, RoadMap
from server.domain.errors import NoSuchFix
from server.feeds.roads.derived import drafts_of
from server.feeds.roads.lanes.connectivity import largest_loop
from server.feeds.roads.lanes.curves import connect, end_poses
from server.feeds.roads.lanes.smoothing import smooth

_SMOOTH_1PM = 1.0 / 5.3
_CURVATURE_MAX_1PM = 1.0 / 5.05
_BLEND_M = 8.0
_CLEAR_M = 0.5
_SPEED_MPS = 15.0 / 3.6
_WIDTH_M = 4.0
Fix = Callable[[RoadMap, str], RoadMap]


def mended(road_map: RoadMap, code: str, where: str) -> RoadMap:
    """The map without the problem. Raises NoSuchFix where it has no fix, or the fix finds no way."""
    fix = FIXES.get(code)
    if fix is None:
        raise NoSuchFix(f"{code} cannot be mended automatically; draw it differently")
    changed = fix(road_map, where)
    if changed == road_map:
        raise NoSuchFix(f"{code} at {where} was not mended: nothing could be changed; draw it differently")
    return changed


def _smoothed(road_map: RoadMap, where: str) -> RoadMap:
    lane = _lane(road_map, where)
    points = smooth(_line(lane), _SMOOTH_1PM, held_m=0.5)
    if points is None:
        raise NoSuchFix(f"{where} cannot be made gentle enough between its ends; move its points apart")
    return _with_lane(road_map, _drawn(lane, points))


def _joined(road_map: RoadMap, where: str) -> RoadMap:
    """The lane's end and its successors' starts meet in the first successor's place and heading."""
    lane = _lane(road_map, where)
    lanes = {one.lane_id: one for one in road_map.lanes}
    followers = [lanes[name] for name in lane.successors if name in lanes]
    if not followers:
        raise NoSuchFix(f"{where} has no successor to be joined to")
    start = end_poses(_line(followers[0]))[0]
    line = _line(lane)
    s = arc_lengths(line)
    keep_m = max(0.0, float(s[-1]) - _BLEND_M)
    if keep_m <= 1.0:
        head, first = np.zeros((0, 2)), end_poses(line)[0]
    else:
        head, first = line[s < keep_m - 0.2], np.array(pose_at(line, s, keep_m))
    curve = connect(first, start, _CURVATURE_MAX_1PM)
    if curve is None:
        raise NoSuchFix(f"{where} cannot be bent to where {followers[0].lane_id} begins; move its end nearer")
    return _with_lane(road_map, _drawn(lane, np.vstack((head, curve))))


def _without_dangling(road_map: RoadMap, _: str) -> RoadMap:
    """References to lanes and stops that are gone, and what stood on those lanes."""
    lanes = {lane.lane_id for lane in road_map.lanes}
    stops = tuple(stop for stop in road_map.stops if stop.lane_id in lanes)
    stop_ids = {stop.stop_id for stop in stops}
    return replace(
        road_map,
        lanes=tuple(
            replace(lane, successors=tuple(name for name in lane.successors if name in lanes))
            for lane in road_map.lanes
        ),
        stops=stops,
        resting_places=tuple(place for place in road_map.resting_places if place.lane_id in lanes),
        observation_areas=tuple(
            replace(area, stop_lines=tuple(line for line in area.stop_lines if line[0] in lanes))
            for area in road_map.observation_areas
        ),
        no_stopping_zones=tuple(zone for zone in road_map.no_stopping_zones if zone.lane_id in lanes),
        signs=tuple(sign for sign in road_map.signs if sign.lane_id in lanes),
        timetable=tuple(
            trip for trip in road_map.timetable if all(stop_id in stop_ids for stop_id, _ in trip.calls)
        ),
    )


def _largest_loop(road_map: RoadMap, _: str) -> RoadMap:
    kept = {draft.lane_id for draft in largest_loop(drafts_of(road_map.lanes))}
    if not kept:
        raise NoSuchFix("no circuit is left that a shuttle can drive; join the lanes' ends first")
    lanes = tuple(lane for lane in road_map.lanes if lane.lane_id in kept)
    return _without_dangling(replace(road_map, lanes=lanes, resting_places=()), "")


def _on_the_lane(road_map: RoadMap, where: str) -> RoadMap:
    """Places beyond a lane's end are moved onto it, with the whole body."""
    lengths = {lane.lane_id: float(arc_lengths(_line(lane))[-1]) for lane in road_map.lanes}

    def within(lane_id: str, s_m: float, back_m: float, front_m: float) -> float:
        last_m = lengths[lane_id] - front_m
        return round(min(max(s_m, back_m), max(last_m, 0.0)), 3)

    return replace(
        road_map,
        stops=tuple(
            replace(one, s_m=within(one.lane_id, one.s_m, REAR_OVERHANG_M, FRONT_REACH_M))
            if one.stop_id == where
            else one
            for one in road_map.stops
        ),
        resting_places=tuple(
            replace(one, s_m=within(one.lane_id, one.s_m, REAR_OVERHANG_M, FRONT_REACH_M))
            if one.place_id == where
            else one
            for one in road_map.resting_places
        ),
        observation_areas=tuple(
            replace(
                area, stop_lines=tuple((lane, within(lane, s_m, 0.0, 0.0)) for lane, s_m in area.stop_lines)
            )
            if area.area_id == where
            else area
            for area in road_map.observation_areas
        ),
        signs=tuple(
            replace(one, s_m=within(one.lane_id, one.s_m, 0.0, 0.0)) if one.sign_id == where else one
            for one in road_map.signs
        ),
    )


def _rested_anew(road_map: RoadMap, _: str) -> RoadMap:
    """`derived` chooses places for a map that has none."""
    return replace(road_map, resting_places=())


def _out_of_the_zone(road_map: RoadMap, where: str) -> RoadMap:
    """The stop moves ahead of the zone, else behind it; a resting place is chosen anew."""
    if any(place.place_id == where for place in road_map.resting_places):
        return _rested_anew(road_map, where)
    stop = next((one for one in road_map.stops if one.stop_id == where), None)
    if stop is None:
        raise NoSuchFix(f"{where} is there no longer")
    length_m = float(arc_lengths(_line(_lane(road_map, stop.lane_id)))[-1])
    zones = [zone for zone in road_map.no_stopping_zones if zone.lane_id == stop.lane_id]
    tries = [zone.s_to_m + REAR_OVERHANG_M + _CLEAR_M for zone in zones]
    tries += [zone.s_from_m - FRONT_REACH_M - _CLEAR_M for zone in zones]
    for s_m in sorted(tries, key=lambda at_m: abs(at_m - stop.s_m)):
        on_lane = REAR_OVERHANG_M <= s_m <= length_m - FRONT_REACH_M
        if on_lane and not any(_covers(zone, s_m) for zone in zones):
            moved = replace(stop, s_m=round(s_m, 3))
            return replace(
                road_map, stops=tuple(moved if one.stop_id == where else one for one in road_map.stops)
            )
    raise NoSuchFix(f"{where} has no room beside the zone on its lane; move it to another lane")


def _covers(zone: NoStoppingZone, s_m: float) -> bool:
    return s_m - REAR_OVERHANG_M < zone.s_to_m and s_m + FRONT_REACH_M > zone.s_from_m


def _with_speed(road_map: RoadMap, where: str) -> RoadMap:
    return _with_lane(road_map, replace(_lane(road_map, where), speed_limit_mps=_SPEED_MPS))


def _with_width(road_map: RoadMap, where: str) -> RoadMap:
    return _with_lane(road_map, replace(_lane(road_map, where), width_m=_WIDTH_M))


def _zone_within(road_map: RoadMap, where: str) -> RoadMap:
    """Cut to its lane; a zone of which nothing is left is removed."""
    zones = []
    for zone in road_map.no_stopping_zones:
        if zone.zone_id == where:
            length_m = float(arc_lengths(_line(_lane(road_map, zone.lane_id)))[-1])
            begin, end = sorted((zone.s_from_m, zone.s_to_m))
            zone = replace(zone, s_from_m=max(0.0, begin), s_to_m=min(length_m, end))
        if zone.s_from_m < zone.s_to_m:
            zones.append(zone)
    return replace(road_map, no_stopping_zones=tuple(zones))


def _plain_outline(road_map: RoadMap, where: str) -> RoadMap:
    """An outline that crosses itself becomes the ground around all of its corners."""

    def plain(area: ObservationArea) -> ObservationArea:
        around = shapely.convex_hull(shapely.MultiPoint(area.outline))
        if around.geom_type != "Polygon":
            raise NoSuchFix(f"{where} encloses no ground; draw it again")
        return replace(area, outline=_pairs(shapely.get_coordinates(around)[:-1]))

    areas = tuple(plain(area) if area.area_id == where else area for area in road_map.observation_areas)
    return replace(road_map, observation_areas=areas)


def _lane(road_map: RoadMap, where: str) -> Lane:
    lane = next((one for one in road_map.lanes if one.lane_id == where), None)
    if lane is None:
        raise NoSuchFix(f"lane {where} is there no longer")
    return lane


def _line(lane: Lane) -> Array:
    return np.array(lane.points, dtype=np.float64)


def _drawn(lane: Lane, points: Array) -> Lane:
    return replace(lane, points=_pairs(resample(points, 0.95)))


def _pairs(points: Array) -> tuple[Point, ...]:
    return tuple((float(x), float(y)) for x, y in np.round(points, 4) + 0.0)


def _with_lane(road_map: RoadMap, lane: Lane) -> RoadMap:
    lanes = tuple(lane if one.lane_id == lane.lane_id else one for one in road_map.lanes)
    return replace(road_map, lanes=lanes)


FIXES: Mapping[str, Fix] = {
    "too_sharp": _smoothed,
    "gap": _joined,
    "kink": _joined,
    "dangling_id": _without_dangling,
    "cut_off": _largest_loop,
    "off_lane": _on_the_lane,
    "broken_promise": _rested_anew,
    "tight_place": _rested_anew,
    "in_no_stopping_zone": _out_of_the_zone,
    "bad_speed": _with_speed,
    "bad_width": _with_width,
    "bad_zone": _zone_within,
    "bad_outline": _plain_outline,
}
