"""Sections: every lane tiled, and which sections exclude each other because bodies would touch.

A road that passes over another one excludes it too: perception and localization are planar.
"""

import math
from collections.abc import Sequence

import numpy as np
import shapely

from contract.geometry import Array, arc_lengths, pose_at
from contract.roads.design_vehicle import CLEARANCE_M, FRONT_REACH_M, REAR_OVERHANG_M, WIDTH_M
from contract.roads.model import Section
from server.feeds.roads.lanes.drafts import LaneDraft

SECTION_M = 24.0
LONGEST_TURN_M = 60.0
_POSE_STEP_M = 0.8
_END_GAP_M = 0.05
_TOUCH_M2 = 0.05
# Two sections that follow each other share the ground around their joint; only an overlap away from it
# is a conflict, such as a turning loop that comes back to where it began.
_JOINT_M = 4.0
_JOINT_OVERLAP_M2 = 0.3


def tile(drafts: Sequence[LaneDraft]) -> tuple[Section, ...]:
    """The sections of all lanes with their conflicts, in the order of the lanes."""
    spans = [span for draft in drafts for span in _spans(draft)]
    by_id = {draft.lane_id: draft for draft in drafts}
    before = tails_of(drafts)
    regions = [ground_of(by_id[lane_id], s0, s1, before[lane_id]) for _, lane_id, s0, s1 in spans]
    conflicts = _conflicts(spans, regions, by_id)
    return tuple(
        Section(section_id, lane_id, s0, s1, tuple(spans[k][0] for k in sorted(conflicts[i])))
        for i, (section_id, lane_id, s0, s1) in enumerate(spans)
    )


def _spans(draft: LaneDraft) -> list[tuple[str, str, float, float]]:
    """Equal pieces, so that the pieces of the opposite lane on the same line meet them end to end."""
    length = draft.length_m
    if draft.kind == "road":
        count = max(1, round(length / SECTION_M))
    else:
        count = max(1, math.ceil(length / LONGEST_TURN_M))
    cuts = [round(length * k / count, 4) for k in range(count)] + [length]
    return [(f"{draft.lane_id}/{k}", draft.lane_id, cuts[k], cuts[k + 1]) for k in range(count)]


def tails_of(drafts: Sequence[LaneDraft]) -> dict[str, list[Array]]:
    """For each lane, the last metres of every lane that leads into it: a body enters from there."""
    tails: dict[str, list[Array]] = {draft.lane_id: [] for draft in drafts}
    for draft in drafts:
        s = arc_lengths(draft.points)
        tail = draft.points[s >= s[-1] - FRONT_REACH_M - 1.0]
        for successor in draft.successors:
            tails[successor].append(tail)
    return tails


def ground_of(draft: LaneDraft, s0: float, s1: float, tails: list[Array]) -> shapely.Geometry:
    """The ground that bodies cover between s0 and s1, half the clearance added to each side."""
    paths = [(draft.points, 0.0)]
    if s0 < FRONT_REACH_M:
        paths = [
            (np.vstack((tail[:-1], draft.points)), float(arc_lengths(tail)[-1])) for tail in tails
        ] or paths
    slices = [_slices(points, s0 + lead, s1 + lead) for points, lead in paths]
    return shapely.union_all(np.concatenate(slices))


def _slices(points: Array, s0: float, s1: float) -> "np.ndarray[tuple[int], np.dtype[np.object_]]":
    """The part of the body that lies between s0 and s1, for rear axles all along the way there."""
    s = arc_lengths(points)
    half = WIDTH_M / 2.0 + CLEARANCE_M / 2.0
    first, last = s0 - FRONT_REACH_M, s1 + REAR_OVERHANG_M
    boxes = []
    for axle in np.linspace(first, last, max(2, math.ceil((last - first) / _POSE_STEP_M) + 1)):
        back = max(-REAR_OVERHANG_M, s0 - axle) + _END_GAP_M
        front = min(FRONT_REACH_M, s1 - axle) - _END_GAP_M
        if front <= back:
            continue
        x, y, yaw = _pose_beyond(points, s, axle)
        cos, sin = math.cos(yaw), math.sin(yaw)
        corners = ((back, -half), (front, -half), (front, half), (back, half))
        boxes.append([(x + cos * a - sin * b, y + sin * a + cos * b) for a, b in corners])
    polygons: np.ndarray[tuple[int], np.dtype[np.object_]] = shapely.polygons(np.array(boxes))
    return polygons


def _pose_beyond(points: Array, s: Array, query_m: float) -> tuple[float, float, float]:
    """The pose at query_m, straight on past the ends."""
    x, y, yaw = pose_at(points, s, query_m)
    over = query_m - min(max(query_m, 0.0), float(s[-1]))
    return x + over * math.cos(yaw), y + over * math.sin(yaw), yaw


def _conflicts(
    spans: list[tuple[str, str, float, float]],
    regions: list[shapely.Geometry],
    by_id: dict[str, LaneDraft],
) -> list[set[int]]:
    found: list[set[int]] = [set() for _ in spans]
    joints = _joints(spans, by_id)
    pairs = shapely.STRtree(regions).query(regions, predicate="intersects").T
    for i, k in ((int(a), int(b)) for a, b in pairs if a < b):
        shared = shapely.intersection(regions[i], regions[k])
        at_joints = [joints[pair] for pair in ((i, k), (k, i)) if pair in joints]
        for joint in at_joints:
            shared = shapely.difference(shared, shapely.Point(joint).buffer(_JOINT_M))
        if shared.area > (_JOINT_OVERLAP_M2 if at_joints else _TOUCH_M2):
            found[i].add(k)
            found[k].add(i)
    return found


def _joints(
    spans: list[tuple[str, str, float, float]], by_id: dict[str, LaneDraft]
) -> dict[tuple[int, int], tuple[float, float]]:
    """Where each section hands over to a next one: {(section, next): point}."""
    first: dict[str, int] = {}
    last: dict[str, int] = {}
    joints: dict[tuple[int, int], tuple[float, float]] = {}
    for i, (_, lane_id, s0, _s1) in enumerate(spans):
        if lane_id in first:
            points = by_id[lane_id].points
            x, y, _ = pose_at(points, arc_lengths(points), s0)
            joints[last[lane_id], i] = (x, y)
        first.setdefault(lane_id, i)
        last[lane_id] = i
    for lane_id, i in last.items():
        end = by_id[lane_id].points[-1]
        for successor in by_id[lane_id].successors:
            joints[i, first[successor]] = (float(end[0]), float(end[1]))
    return joints
