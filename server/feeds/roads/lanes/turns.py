"""Turns: from the end of each lane at a junction to the start of each other one, where it can be driven."""

import math

import numpy as np
import shapely

from contract.geometry import Array, wrap_angle
from contract.roads.design_vehicle import WIDTH_M
from server.feeds.roads.lanes.curves import connect, end_poses, peak_curvature
from server.feeds.roads.lanes.drafts import ImportLog, LaneDraft
from server.feeds.roads.lanes.junctions import Junction, RoadGraph, inner_path
from server.feeds.roads.lanes.roads import SHARPEST_TURN_RAD, Road, ends_by_junction
from server.feeds.roads.lanes.smoothing import largest_deviation_m, smooth
from server.feeds.roads.osm.ground import Ground

_WANTED_CURVATURE_1PM = 1.0 / 6.2
_LAST_CURVATURE_1PM = 1.0 / 5.1
_CUT_CORNER_M = 4.0
_SIDE_ROOM_M = 0.3
# A junction this large can hold a turn back.
_LONG_WAY_ROUND_M = 45.0
_TURN_SPEED_MPS = 15.0 / 3.6


def turn_lanes(graph: RoadGraph, roads: list[Road], ground: Ground, log: ImportLog) -> list[LaneDraft]:
    """A lane for every movement that a shuttle can make; the others are listed as dropped."""
    drafts: list[LaneDraft] = []
    for number, ends in sorted(ends_by_junction(graph, roads).items()):
        for road, end in ends:
            for other, other_end in ends:
                before, after = road.into(end), other.out_of(other_end)
                if (road, end) == (other, other_end) or before is None or after is None:
                    continue
                draft = _turn(graph.junctions[number], (road, end), (other, other_end), ground, log)
                if draft is not None:
                    drafts.append(draft)
    return drafts


def _turn(
    junction: Junction, inward: tuple[Road, int], outward: tuple[Road, int], ground: Ground, log: ImportLog
) -> LaneDraft | None:
    (road, end), (other, other_end) = inward, outward
    before, after = road.into(end), other.out_of(other_end)
    assert before is not None
    assert after is not None
    inner = inner_path(junction, road.key(end), other.key(other_end))
    if inner is None:
        return None
    guide = _without_repeats(np.vstack((road.guide(end), inner, other.guide(other_end)[::-1])))
    found = _drivable(before, after, guide, max(road.aside_m, other.aside_m), ground)
    if isinstance(found, str):
        x, y = guide[len(guide) // 2]
        log.dropped.append(
            f"turn from {road.edge.label} to {other.edge.label} at ({x:.0f}, {y:.0f}) m: {found}"
        )
        return None
    draft = LaneDraft(
        f"{before.lane_id}>{after.lane_id}",
        "turn",
        found,
        min(before.width_m, after.width_m),
        min(before.speed_limit_mps, after.speed_limit_mps, _TURN_SPEED_MPS),
        before.can_pass and after.can_pass,
        [after.lane_id],
        "common_road" if len(junction.keys) == 1 and not junction.inner else "unprotected_intersection",
        after.name,
        after.name_en,
    )
    before.successors.append(draft.lane_id)
    return draft


def _without_repeats(points: Array) -> Array:
    steps = np.hypot(*np.diff(points, axis=0).T)
    kept: Array = points[np.concatenate(([True], steps > 1e-6))]
    return kept


def _drivable(
    before: LaneDraft, after: LaneDraft, guide: Array, aside_m: float, ground: Ground
) -> Array | str:
    """The turn's points, or why it cannot be made."""
    if len(guide) < 2:
        return "its roads are too short to turn between"
    start, end = end_poses(before.points)[1], end_poses(after.points)[0]
    turned = abs(wrap_angle(float(end[2] - start[2])))
    if turned > SHARPEST_TURN_RAD and shapely.LineString(guide).length < _LONG_WAY_ROUND_M:
        return f"{math.degrees(turned):.0f} degrees are too sharp"
    room_m = _CUT_CORNER_M + 2.0 * aside_m
    reason = "needs a smaller radius than 5 m"
    for limit_1pm in (_WANTED_CURVATURE_1PM, _LAST_CURVATURE_1PM):
        for draw in (_straight_across, _along):
            points = draw(guide, start, end, limit_1pm)
            if points is None or peak_curvature(points) > _LAST_CURVATURE_1PM:
                continue
            if largest_deviation_m(points, guide) > room_m:
                reason = "would leave the road"
            elif ground.hits(points, WIDTH_M / 2.0 + _SIDE_ROOM_M, beside=guide):
                reason = "a building is in the way"
            else:
                return points
    return reason


def _straight_across(_guide: Array, start: Array, end: Array, limit_1pm: float) -> Array | None:
    return connect(start, end, limit_1pm)


def _along(guide: Array, start: Array, end: Array, limit_1pm: float) -> Array | None:
    """The guide line made smooth, its ends moved onto the lanes' ends (they lie beside it on wide roads)."""
    if shapely.LineString(guide).length < 6.0:
        return None
    share = np.linspace(0.0, 1.0, len(guide))[:, None]
    moved = guide + (1.0 - share) * (start[:2] - guide[0]) + share * (end[:2] - guide[-1])
    lead = np.array([0.5, 1.0, 1.5])[:, None]
    ahead = start[:2] + lead * np.array([math.cos(start[2]), math.sin(start[2])])
    behind = end[:2] - lead[::-1] * np.array([math.cos(end[2]), math.sin(end[2])])
    s = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(moved, axis=0).T))))
    middle = moved[(s > 2.0) & (s < s[-1] - 2.0)]
    return smooth(np.vstack((start[:2], ahead, middle, behind, end[:2])), limit_1pm, held_m=1.5)
