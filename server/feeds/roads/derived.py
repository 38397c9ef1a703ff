"""What a map derives from its lanes: points close enough, sections, and places to rest."""

import itertools
import math
from collections.abc import Iterable

import numpy as np
from msgspec.structs import replace

from contract.geometry import Array, resample
from contract.roads.model import Lane, RoadMap
from contract.roads.section_graph import SectionGraph, broken_promises
from server.feeds.roads.lanes.drafts import ImportLog, LaneDraft
from server.feeds.roads.lanes.sections import tile
from server.feeds.roads.places.resting import resting_places

_SPACING_M = 0.95
_GAP_MAX_M = 1.001


def drafts_of(lanes: Iterable[Lane]) -> list[LaneDraft]:
    """Finished lanes as drafts again."""
    return [
        LaneDraft(
            lane.lane_id,
            lane.kind,
            np.array(lane.points, dtype=np.float64),
            lane.width_m,
            lane.speed_limit_mps,
            lane.can_pass,
            list(lane.successors),
            lane.scenario,
            lane.name,
            lane.name_en,
        )
        for lane in lanes
    ]


def derived(road_map: RoadMap, log: ImportLog) -> RoadMap:
    """The map with its sections tiled, and with resting places that keep the promise where that is possible.

    Lanes are given points at most 1 m apart. A map whose lanes cannot be tiled (an unknown successor, fewer
    than two points, a place that is no number) is given back without sections; `problems` says why.
    """
    if not _can_be_tiled(road_map):
        return replace(road_map, sections=())
    lanes = tuple(_with_close_points(lane) for lane in road_map.lanes)
    road_map = replace(road_map, lanes=lanes, sections=tile(drafts_of(lanes)))
    if not _all_on_lanes(road_map):
        return road_map
    if road_map.resting_places and not _broken(road_map):
        return road_map
    if not road_map.stops:
        return road_map
    places = resting_places(replace(road_map, resting_places=()))
    if road_map.resting_places:
        log.repairs.append("resting places were chosen anew: with the former ones a stop could be cut off")
    elif places:
        log.repairs.append(f"{len(places)} resting places were chosen: the file names none")
    return replace(road_map, resting_places=places)


def _can_be_tiled(road_map: RoadMap) -> bool:
    names = {lane.lane_id for lane in road_map.lanes}
    return (
        bool(road_map.lanes)
        and len(names) == len(road_map.lanes)
        and all(set(lane.successors) <= names and _is_a_line(lane) for lane in road_map.lanes)
    )


def _is_a_line(lane: Lane) -> bool:
    finite = all(math.isfinite(x) and math.isfinite(y) for x, y in lane.points)
    return finite and len(set(lane.points)) >= 2


def _with_close_points(lane: Lane) -> Lane:
    gaps = [math.dist(a, b) for a, b in itertools.pairwise(lane.points)]
    if min(gaps) > 0.0 and max(gaps) <= _GAP_MAX_M:
        return lane
    distinct = [
        lane.points[0],
        *(b for (_, b), gap in zip(itertools.pairwise(lane.points), gaps, strict=True) if gap),
    ]
    fine: Array = np.round(resample(np.array(distinct, dtype=np.float64), _SPACING_M), 4) + 0.0
    return replace(lane, points=tuple((float(x), float(y)) for x, y in fine))


def _all_on_lanes(road_map: RoadMap) -> bool:
    """Every stop and resting place lies on its lane, so that the graph of sections can be asked for it."""
    ends: dict[str, float] = {}
    for section in road_map.sections:
        ends[section.lane_id] = max(ends.get(section.lane_id, 0.0), section.s_to_m)
    placed = [(stop.lane_id, stop.s_m) for stop in road_map.stops]
    placed += [(place.lane_id, place.s_m) for place in road_map.resting_places]
    return all(0.0 <= s_m <= ends.get(lane_id, -1.0) for lane_id, s_m in placed)


def _broken(road_map: RoadMap) -> bool:
    graph = SectionGraph(road_map.sections, [(lane.lane_id, lane.successors) for lane in road_map.lanes])
    return any(broken_promises(graph, road_map.resting_places, road_map.stops))
