"""Observation areas: where others may cross, and where to stand clear of them.

An intersection is a junction of three ways or more without signals; a crossing is a place where people cross
a road that is driven (`crossings`).
"""

import math
from collections.abc import Iterable, Sequence

import numpy as np
import shapely

from contract.geometry import Array, arc_lengths, pose_at, project
from contract.roads.areas import crosses_itself
from contract.roads.design_vehicle import WIDTH_M
from contract.roads.model import AreaKind, ObservationArea, Point
from server.feeds.roads.lanes.drafts import LaneDraft
from server.feeds.roads.lanes.sections import ground_of, tails_of
from server.feeds.roads.osm.frame import Frame
from server.feeds.roads.osm.osm_file import OsmData
from server.feeds.roads.places.crossings import ON_ROAD_M, crossing_nodes

APPROACH_M = 20.0
CROSSING_DEPTH_M = 4.0
PAVEMENT_M = 2.0
STOP_BEFORE_M = 0.5
_FEWEST_ARMS = 3
_TOUCH_M = 0.5
_SIMPLIFY_M = 0.3
_SIGNAL_M = 12.0
_HALF_BODY_M = WIDTH_M / 2.0 + 0.15


class _Lanes:
    """The drafts by id, what leads into each, and the map's lines in a tree."""

    def __init__(self, drafts: Sequence[LaneDraft]) -> None:
        self.drafts = drafts
        self.by_id = {draft.lane_id: draft for draft in drafts}
        self.lines = [shapely.LineString(draft.points) for draft in drafts]
        self.tree = shapely.STRtree(self.lines)
        self.tails = tails_of(drafts)
        self.before: dict[str, list[LaneDraft]] = {draft.lane_id: [] for draft in drafts}
        for draft in drafts:
            for successor in draft.successors:
                self.before[successor].append(draft)

    def places_before(self, draft: LaneDraft, s_m: float) -> list[tuple[str, float]]:
        """The place on the lane, or for an s before its start those on the lanes that lead into it."""
        if s_m >= 0.0:
            return [(draft.lane_id, math.floor(s_m * 1000.0) / 1000.0)]
        places = []
        for earlier in self.before[draft.lane_id]:
            if earlier.length_m + s_m >= 0.0:
                places += self.places_before(earlier, earlier.length_m + s_m)
        return places


def observation_areas(
    data: OsmData, frame: Frame, drafts: Sequence[LaneDraft]
) -> tuple[ObservationArea, ...]:
    """All of them: intersections in the order of their lanes, then crossings by node."""
    lanes = _Lanes(drafts)
    signals = [
        frame.positions[n.node_id] for n in data.nodes.values() if n.tags.get("highway") == "traffic_signals"
    ]
    found: list[ObservationArea] = []
    for turns in _junctions(lanes):
        area = _intersection(lanes, turns, f"intersection-{len(found) + 1}", signals)
        if area is not None:
            found.append(area)
    for node_id in crossing_nodes(data, frame, drafts):
        area = _crossing(lanes, f"crossing-{node_id}", frame.positions[node_id])
        if area is not None:
            found.append(area)
    return tuple(found)


def crossing_areas(
    drafts: Sequence[LaneDraft], places: Iterable[tuple[str, Point]], width_m: float | None = None
) -> tuple[ObservationArea, ...]:
    """Crossings by id, each about the middle of a road of this width, by default of its nearest lane's."""
    lanes = _Lanes(drafts)
    found = (_crossing(lanes, area_id, place, width_m) for area_id, place in places)
    return tuple(area for area in found if area is not None)


def _junctions(lanes: _Lanes) -> list[list[LaneDraft]]:
    """Turns whose lines meet, taken together."""
    turns = [draft for draft in lanes.drafts if draft.kind == "turn"]
    if not turns:
        return []
    lines = [shapely.LineString(draft.points) for draft in turns]
    parent = list(range(len(turns)))

    def root(i: int) -> int:
        while parent[i] != i:
            i = parent[i]
        return i

    for a, b in shapely.STRtree(lines).query(lines, predicate="dwithin", distance=_TOUCH_M).T:
        one, other = root(int(a)), root(int(b))
        parent[max(one, other)] = min(one, other)
    groups: dict[int, list[LaneDraft]] = {}
    for i, draft in enumerate(turns):
        groups.setdefault(root(i), []).append(draft)
    return [groups[i] for i in sorted(groups)]


def _intersection(
    lanes: _Lanes, turns: list[LaneDraft], area_id: str, signals: Sequence[Point]
) -> ObservationArea | None:
    entries = {turn.lane_id: [d for d in lanes.before[turn.lane_id] if d.kind == "road"] for turn in turns}
    inward = {draft.lane_id: draft for into in entries.values() for draft in into}
    outward = {name for turn in turns for name in turn.successors}
    arms = {_arm(name, into=True) for name in inward} | {_arm(name, into=False) for name in outward}
    middle = shapely.union_all([shapely.LineString(turn.points) for turn in turns])
    if len(arms) < _FEWEST_ARMS or any(middle.distance(shapely.Point(p)) < _SIGNAL_M for p in signals):
        return None
    grounds = {turn.lane_id: ground_of(turn, 0.0, turn.length_m, lanes.tails[turn.lane_id]) for turn in turns}
    stop_lines: list[tuple[str, float]] = []
    for draft in inward.values():
        others = [
            grounds[turn.lane_id]
            for turn in turns
            if draft.lane_id not in {before.lane_id for before in entries[turn.lane_id]}
        ]
        if others:
            clear_m = _clear_m(draft, shapely.union_all(others))
            if clear_m > STOP_BEFORE_M:
                stop_lines += lanes.places_before(draft, clear_m - STOP_BEFORE_M)
    if not stop_lines:
        return None
    ways = [_strip(turn.points, 0.5 * turn.width_m) for turn in turns]
    ways += [
        _strip(piece, half_m) for name in sorted(inward) for piece, half_m in _approach(lanes, inward[name])
    ]
    return _area(area_id, "intersection", shapely.union_all(ways), stop_lines)


def _arm(lane_id: str, *, into: bool) -> tuple[str, bool]:
    """The end of a road that a lane leads to or from: forward lanes end where backward ones begin."""
    return lane_id[:-1], (lane_id[-1] == "f") == into


def _clear_m(draft: LaneDraft, ground: shapely.Geometry) -> float:
    """How far a body can drive on the lane without touching the ground, looked for in its last metres."""
    s = arc_lengths(draft.points)
    length_m = float(s[-1])
    tail = draft.points[s >= length_m - APPROACH_M]
    touched = shapely.intersection(_strip(tail, _HALF_BODY_M), ground)
    if touched.is_empty:
        return length_m
    first = max(0, len(s) - len(tail) - 1)
    corners = shapely.get_coordinates(touched)
    return min(float(project(draft.points, s, x, y, first, len(s))[0]) for x, y in corners)


def _approach(lanes: _Lanes, draft: LaneDraft) -> list[tuple[Array, float]]:
    """The last metres of every way that leads over this lane, each with half its width."""
    pieces = []
    queue, seen = [(draft, APPROACH_M)], {draft.lane_id}
    while queue:
        here, left_m = queue.pop(0)
        s = arc_lengths(here.points)
        length_m = float(s[-1])
        pieces.append((_between(here.points, s, max(0.0, length_m - left_m), length_m), 0.5 * here.width_m))
        for earlier in lanes.before[here.lane_id]:
            if left_m > length_m and earlier.lane_id not in seen:
                seen.add(earlier.lane_id)
                queue.append((earlier, left_m - length_m))
    return pieces


def _between(points: Array, s: Array, from_m: float, to_m: float) -> Array:
    ends = [pose_at(points, s, at_m)[:2] for at_m in (from_m, to_m)]
    piece: Array = np.vstack((ends[0], points[(s > from_m) & (s < to_m)], ends[1]))
    return piece


def _strip(points: Array, half_m: float) -> shapely.Geometry:
    return shapely.LineString(points).buffer(half_m, cap_style="flat", join_style="bevel")


def _crossing(
    lanes: _Lanes, area_id: str, place: Point, width_m: float | None = None
) -> ObservationArea | None:
    """A rectangle across the road, by default of its nearest lane's width; None where no lane is left."""
    point = shapely.Point(place)
    near = [int(i) for i in sorted(lanes.tree.query(point, predicate="dwithin", distance=ON_ROAD_M))]
    if not near:
        return None
    nearest = min(near, key=lambda i: (lanes.drafts[i].kind != "road", lanes.lines[i].distance(point), i))
    draft = lanes.drafts[nearest]
    s = arc_lengths(draft.points)
    at_m, _, _ = project(draft.points, s, place[0], place[1], 0, len(s))
    _, _, yaw = pose_at(draft.points, s, at_m)
    along = np.array([math.cos(yaw), math.sin(yaw)]) * 0.5 * CROSSING_DEPTH_M
    across = np.array([-math.sin(yaw), math.cos(yaw)]) * (0.5 * (width_m or draft.width_m) + PAVEMENT_M)
    corners = [np.array(place) + a * along + b * across for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    ground = shapely.Polygon(corners)
    stop_lines: list[tuple[str, float]] = []
    for i in sorted(int(k) for k in lanes.tree.query(ground, predicate="intersects")):
        enters_m = _first_inside_m(lanes.drafts[i], ground)
        if enters_m is not None:
            stop_lines += lanes.places_before(lanes.drafts[i], enters_m - STOP_BEFORE_M)
    return _area(area_id, "crossing", ground, stop_lines) if stop_lines else None


def _first_inside_m(draft: LaneDraft, ground: shapely.Geometry) -> float | None:
    """Where the lane goes into the ground; None when it begins inside: a lane before it goes in."""
    if ground.covers(shapely.Point(draft.points[0])):
        return None
    touched = shapely.get_coordinates(shapely.intersection(shapely.LineString(draft.points), ground))
    s = arc_lengths(draft.points)
    return min(float(project(draft.points, s, x, y, 0, len(s))[0]) for x, y in touched)


def _area(
    area_id: str, kind: AreaKind, ground: shapely.Geometry, stop_lines: Iterable[tuple[str, float]]
) -> ObservationArea:
    corners = _outline(ground)
    return ObservationArea(area_id, kind, corners, tuple(dict.fromkeys(stop_lines)))


def _outline(ground: shapely.Geometry) -> tuple[Point, ...]:
    """The outer edge of the largest part, in centimetres; slits that make it touch itself are closed."""
    for closed_m in (0.0, 0.3, 1.0):
        wider = shapely.buffer(ground, closed_m, join_style="mitre") if closed_m else ground
        parts = [part for part in shapely.get_parts(wider) if part.geom_type == "Polygon"]
        largest = max(parts, key=lambda part: part.area)
        outline = shapely.simplify(shapely.Polygon(largest.exterior), _SIMPLIFY_M)
        corners = np.round(shapely.get_coordinates(outline)[:-1], 2) + 0.0
        if not crosses_itself(corners):
            break
    # Where nothing else helps, what is watched may be a little too large.
    else:
        corners = np.round(shapely.get_coordinates(ground.convex_hull)[:-1], 2) + 0.0
    return tuple((float(x), float(y)) for x, y in corners)
