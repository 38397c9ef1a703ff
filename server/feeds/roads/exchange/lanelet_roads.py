"""A foreign Lanelet2 file as a road map: lanelets become lanes that a shuttle can drive."""

import numpy as np

from contract.geometry import Array, arc_lengths, pose_at, resample
from contract.roads.load import MapError
from contract.roads.model import LaneKind, RoadMap
from server.feeds.roads.derived import derived
from server.feeds.roads.exchange.lanelet_file import LaneletFile, foreign_places
from server.feeds.roads.exchange.lanelet_strips import (
    Strip,
    joined_strips,
    passing_strips,
    strips_of,
    turns_round,
)
from server.feeds.roads.import_osm import ImportOptions
from server.feeds.roads.lanes.connectivity import largest_loop
from server.feeds.roads.lanes.curves import connect, peak_curvature
from server.feeds.roads.lanes.drafts import ImportLog, LaneDraft, finished_lane
from server.feeds.roads.lanes.smoothing import largest_deviation_m, smooth
from server.feeds.roads.lanes.turnarounds import drivable_loops
from server.feeds.roads.osm.drivable import LEAST_WIDTH_M
from server.feeds.roads.osm.frame import Frame
from server.feeds.roads.osm.osm_file import OsmData, OsmNode
from server.feeds.roads.places.areas import crossing_areas
from server.feeds.roads.places.stops import place_stops

_CURVATURE_MAX_1PM = 1.0 / 5.05
_SMOOTH_1PM = 1.0 / 5.3
_BLEND_M = 6.0
_LEAST_MIDDLE_M = 2.0
_TOLD_SHIFT_M = 0.5
_FARTHEST_SHIFT_M = 4.0
_LOOP_SHIFT_M = 8.0
_FEWEST_STOPS = 2


def map_from_foreign_lanelets(file: LaneletFile, options: ImportOptions, log: ImportLog) -> RoadMap:
    """Raises MapError: lanelet_broken, no_roads, no_loop, no_stops, no_resting_places."""
    origin, places = foreign_places(file, log)
    strips, crosswalks = strips_of(file, places, log)
    drafts = largest_loop(_lanes(strips, log))
    if not drafts:
        raise MapError("no_loop", "no circuit that a shuttle can drive (radius 5 m); export a larger area")
    kept = {draft.lane_id for draft in drafts}
    outside = [strip.name for strip in strips if strip.name not in kept]
    if outside:
        log.dropped.append(
            f"{len(outside)} lanelets: not part of the largest loop ({', '.join(outside[:8])})"
        )
    nodes = {
        number: OsmNode(number, *file.degrees[number], tags)
        for number, tags in sorted(file.node_tags.items())
        if tags
    }
    extent = np.array(list(places.values()))
    low, high = extent.min(axis=0), extent.max(axis=0)
    frame = Frame(origin, places, (float(low[0]), float(low[1])), (float(high[0]), float(high[1])), True)
    stops = place_stops(
        OsmData(nodes, {}, {}, None), frame, [], drafts, options.names_en, log, left_hand=options.left_hand
    )
    if len(stops) < _FEWEST_STOPS:
        raise MapError("no_stops", "no room for two stops on the lanes that are left; export a larger area")
    road_map = derived(
        RoadMap(
            campus_id=options.campus_id,
            name=options.name,
            origin=origin,
            lanes=tuple(finished_lane(draft) for draft in drafts),
            sections=(),
            stops=stops,
            resting_places=(),
            timezone=options.timezone,
            observation_areas=crossing_areas(drafts, crosswalks),
        ),
        log,
    )
    if not road_map.resting_places:
        raise MapError(
            "no_resting_places", "nowhere to stand without cutting a stop off; export a larger area"
        )
    return road_map


def _lanes(strips: list[Strip], log: ImportLog) -> list[LaneDraft]:
    """Drivable lanes with their successors; a strip that bends too sharply is left out."""
    successors, poses = joined_strips(strips)
    beside = passing_strips(strips)
    drafts = []
    for strip, after, (start, end) in zip(strips, successors, poses, strict=True):
        points = _drivable(strip.points, start, end)
        if points is None:
            log.dropped.append(f"lanelet {strip.name}: bends too sharply for a shuttle")
            continue
        shift_m = largest_deviation_m(points, strip.points)
        if shift_m > _TOLD_SHIFT_M:
            log.repairs.append(f"lanelet {strip.name}: bends rounded, up to {shift_m:.1f} m off its middle")
        can_pass = strip.name in beside and strip.width_m >= LEAST_WIDTH_M
        drafts.append(
            LaneDraft(
                strip.name,
                _kind(strip, (start, end)),
                points,
                round(beside[strip.name] if can_pass else strip.width_m, 2),
                strip.speed_limit_mps,
                can_pass,
                [strips[k].name for k in after],
            )
        )
    names = {draft.lane_id for draft in drafts}
    for draft in drafts:
        draft.successors = [name for name in draft.successors if name in names]
    return drafts


def _kind(strip: Strip, poses: tuple[Array, Array]) -> LaneKind:
    if turns_round(poses):
        return "turnaround"
    return "turn" if strip.is_turn else "road"


def _drivable(points: Array, start: Array, end: Array) -> Array | None:
    """The line from pose to pose, smooth enough for a shuttle; None where that is not possible."""
    line = smooth(points, _SMOOTH_1PM)
    if line is not None and float(arc_lengths(line)[-1]) > 2.0 * _BLEND_M + _LEAST_MIDDLE_M:
        blended = _blended(line, start, end)
        if blended is not None:
            return blended
    loops = turns_round((start, end))
    drawn = [*drivable_loops(start, end)] if loops else [connect(start, end, _CURVATURE_MAX_1PM)]
    near = [(largest_deviation_m(one, points), k, one) for k, one in enumerate(drawn) if one is not None]
    if not near:
        return None
    shift_m, _, nearest = min(near, key=lambda one: one[:2])
    # Of a loop, the middle of the bounds is only roughly where one drives.
    return nearest if shift_m <= (_LOOP_SHIFT_M if loops else _FARTHEST_SHIFT_M) else None


def _blended(line: Array, start: Array, end: Array) -> Array | None:
    """The line with its first and last metres drawn anew, so that they keep the poses of the joints."""
    s = arc_lengths(line)
    last_m = float(s[-1]) - _BLEND_M
    head = connect(start, np.array(pose_at(line, s, _BLEND_M)), _CURVATURE_MAX_1PM)
    tail = connect(np.array(pose_at(line, s, last_m)), end, _CURVATURE_MAX_1PM)
    if head is None or tail is None:
        return None
    whole: Array = resample(np.vstack((head, line[(s > _BLEND_M + 0.2) & (s < last_m - 0.2)], tail)), 0.95)
    whole[0], whole[-1] = start[:2], end[:2]
    return whole if peak_curvature(whole) <= _CURVATURE_MAX_1PM else None
