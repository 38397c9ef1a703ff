"""Turnarounds: a loop at the dead end of a two-way road, where the ground is open."""

import math
from collections.abc import Iterator

from contract.geometry import Array
from contract.roads.design_vehicle import WIDTH_M
from server.feeds.roads.lanes.curves import end_poses, loop, peak_curvature
from server.feeds.roads.lanes.drafts import ImportLog, LaneDraft
from server.feeds.roads.lanes.junctions import RoadGraph
from server.feeds.roads.lanes.roads import Road, ends_by_junction
from server.feeds.roads.lanes.smoothing import smooth
from server.feeds.roads.osm.ground import Ground

_RADII_M = (7.0, 6.5, 6.0, 5.6)
_SMOOTH_CURVATURE_1PM = 1.0 / 5.2
# The loop's middle lies at most this far past the road's end.
_PAST_END_M = 4.0
_SIDE_ROOM_M = 0.5
_LOOP_SPEED_MPS = 10.0 / 3.6


def turnaround_lanes(
    graph: RoadGraph, roads: list[Road], circles: frozenset[int], ground: Ground, log: ImportLog
) -> list[LaneDraft]:
    """A loop for every dead end that has room for one, tagged as a turning place or on open ground."""
    drafts: list[LaneDraft] = []
    for _, ends in sorted(ends_by_junction(graph, roads).items()):
        if len(ends) != 1:
            continue
        road, end = ends[0]
        before, after = road.into(end), road.out_of(end)
        if before is None or after is None:
            continue
        tagged = road.key(end) in circles
        points = _loop(road, end, before, after, ground, tagged)
        x, y = before.points[-1]
        if points is None:
            log.dropped.append(f"{road.edge.label}: no room to turn at its end near ({x:.0f}, {y:.0f}) m")
            continue
        if not tagged:
            log.repairs.append(f"{road.edge.label}: assumed turning place near ({x:.0f}, {y:.0f}) m")
        draft = LaneDraft(
            f"{before.lane_id}@",
            "turnaround",
            points,
            before.width_m,
            min(before.speed_limit_mps, _LOOP_SPEED_MPS),
            False,
            [after.lane_id],
            "common_road",
            before.name,
            before.name_en,
        )
        before.successors.append(draft.lane_id)
        drafts.append(draft)
    return drafts


def _loop(
    road: Road, end: int, before: LaneDraft, after: LaneDraft, ground: Ground, tagged: bool
) -> Array | None:
    start, finish = end_poses(before.points)[1], end_poses(after.points)[0]
    longest_m = (_PAST_END_M + road.trims_m[end]) / math.sqrt(3.0)
    for points in drivable_loops(start, finish, longest_m):
        if tagged or not ground.hits(points, WIDTH_M / 2.0 + _SIDE_ROOM_M):
            return points
    return None


def drivable_loops(start: Array, finish: Array, radius_max_m: float = math.inf) -> Iterator[Array]:
    """Loops from pose to pose (x, y, yaw) that a shuttle can drive, the widest first; (n, 2) points each."""
    for radius_m in _RADII_M:
        if radius_m > radius_max_m:
            continue
        for left_first in (False, True):
            arcs = loop(start, finish, radius_m, left_first)
            points = None if arcs is None else smooth(arcs, _SMOOTH_CURVATURE_1PM, held_m=0.5)
            if points is not None and peak_curvature(points) <= 1.0 / 5.05:
                yield points
