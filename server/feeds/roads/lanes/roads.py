"""Roads: edges made smooth enough to drive, and cut back from their junctions."""

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from contract.geometry import Array, arc_lengths, pose_at, resample, wrap_angle
from server.feeds.roads.lanes.curves import offset, peak_curvature
from server.feeds.roads.lanes.drafts import ImportLog, LaneDraft
from server.feeds.roads.lanes.edges import Edge
from server.feeds.roads.lanes.junctions import RoadGraph
from server.feeds.roads.lanes.smoothing import largest_deviation_m, smooth

WANTED_RADIUS_M = 6.5
LAST_RADIUS_M = 5.3
# Gentle enough that a road drawn with few vertices does not slow a shuttle down at each of them.
_REACH_M = 3.0
_FARTHEST_SHIFT_M = 4.0
_TOLD_SHIFT_M = 1.0
_LEAST_OFFSET_M, _MOST_OFFSET_M = 1.22, 1.75
_TURN_RADIUS_M = 7.0
_STRAIGHT_TRIM_M = 3.0
_MOST_TRIM_M = 20.0
_LOOP_TRIM_M = 11.0
_LEAST_LANE_M = 1.6
_LEAST_EDGE_M = 3.0
_HEADING_BASE_M = 7.0
SHARPEST_TURN_RAD = math.radians(150.0)


@dataclass(slots=True)
class Road:
    """A drivable edge: its smooth centre line, and its lanes once they are cut.

    aside_m  how far each direction's lane lies from the centre line; 0 where both share it
    trims_m  how much is cut off at the first and the last key
    """

    edge: Edge
    centre: Array
    aside_m: float
    trims_m: tuple[float, float] = (0.0, 0.0)
    forward: LaneDraft | None = None
    backward: LaneDraft | None = None

    def into(self, end: int) -> LaneDraft | None:
        """The lane that leads to the first (0) or last (1) key."""
        return self.forward if end == 1 else self.backward

    def out_of(self, end: int) -> LaneDraft | None:
        """The lane that leads away from the first (0) or last (1) key."""
        return self.forward if end == 0 else self.backward

    def key(self, end: int) -> int:
        return self.edge.keys[-1 if end else 0]

    def outward(self, end: int) -> float:
        """The heading in which one leaves the road at an end."""
        s = arc_lengths(self.centre)
        base = min(_HEADING_BASE_M, float(s[-1]) / 2.0)
        near = self.centre[-1 if end else 0]
        x, y, _ = pose_at(self.centre, s, float(s[-1]) - base if end else base)
        return math.atan2(near[1] - y, near[0] - x)

    def guide(self, end: int) -> Array:
        """What was cut off at an end, from the cut outward; (n, 2)."""
        s = arc_lengths(self.centre)
        cut = float(s[-1]) - self.trims_m[1] if end else self.trims_m[0]
        x, y, _ = pose_at(self.centre, s, cut)
        beyond = self.centre[s > cut] if end else self.centre[s < cut][::-1]
        piece: Array = np.vstack(([x, y], beyond))
        return piece


def smooth_roads(edges: Iterable[Edge], log: ImportLog) -> list[Road]:
    """The edges that can be made drivable without leaving their roads."""
    roads = []
    for edge in edges:
        if edge.length_m < _LEAST_EDGE_M:
            log.dropped.append(f"{edge.label}: only {edge.length_m:.1f} m long")
            continue
        aside = _aside(edge) if edge.driving.can_pass else 0.0
        centre = _smooth(edge, aside)
        if centre is None:
            log.dropped.append(f"{edge.label}: bends too sharply for a shuttle, {edge.length_m:.0f} m")
            continue
        shift = largest_deviation_m(centre, edge.points)
        if shift > _FARTHEST_SHIFT_M:
            log.dropped.append(
                f"{edge.label}: a drivable line would leave the road by {shift:.1f} m, {edge.length_m:.0f} m"
            )
            continue
        if shift > _TOLD_SHIFT_M:
            log.repairs.append(f"{edge.label}: bends rounded, up to {shift:.1f} m off the drawn line")
        roads.append(Road(edge, centre, aside))
    return roads


def _aside(edge: Edge) -> float:
    return min(max(edge.driving.width_m / 4.0, _LEAST_OFFSET_M), _MOST_OFFSET_M)


def _smooth(edge: Edge, aside_m: float) -> Array | None:
    for radius_m in (WANTED_RADIUS_M, LAST_RADIUS_M):
        line = smooth(edge.points, 1.0 / (radius_m + aside_m), reach_m=_REACH_M)
        if line is not None:
            return line
    return None


def ends_by_junction(graph: RoadGraph, roads: list[Road]) -> dict[int, list[tuple[Road, int]]]:
    """Which road ends meet at each junction."""
    meeting: dict[int, list[tuple[Road, int]]] = {}
    for road in roads:
        for end in (0, 1):
            meeting.setdefault(graph.at[road.key(end)], []).append((road, end))
    return meeting


def trim(graph: RoadGraph, roads: list[Road]) -> None:
    """Cut every road back from its junctions by what its turns need, as far as its length allows."""
    needs = {(road.edge.edge_id, end): _STRAIGHT_TRIM_M for road in roads for end in (0, 1)}
    for ends in ends_by_junction(graph, roads).values():
        if len(ends) == 1:
            road, end = ends[0]
            needs[road.edge.edge_id, end] = _LOOP_TRIM_M
        for road, end in ends:
            for other, other_end in ends:
                if (road, end) != (other, other_end):
                    turn = abs(wrap_angle(other.outward(other_end) + math.pi - road.outward(end)))
                    key = (road.edge.edge_id, end)
                    needs[key] = max(needs[key], _tangent_m(turn, max(road.aside_m, other.aside_m)))
    for road in roads:
        first, last = (needs[road.edge.edge_id, end] for end in (0, 1))
        room = float(arc_lengths(road.centre)[-1]) - _LEAST_LANE_M
        scale = min(1.0, room / (first + last))
        road.trims_m = (max(0.0, first * scale), max(0.0, last * scale))


def _tangent_m(turn_rad: float, aside_m: float) -> float:
    if turn_rad > SHARPEST_TURN_RAD:
        return _STRAIGHT_TRIM_M
    reach = (_TURN_RADIUS_M + aside_m) * math.tan(turn_rad / 2.0) * 1.25
    return min(max(reach, _STRAIGHT_TRIM_M), _MOST_TRIM_M)


def cut_lanes(roads: list[Road], *, left_hand: bool) -> list[LaneDraft]:
    """Both directions' lanes, or one where the road is one-way."""
    drafts: list[LaneDraft] = []
    for road in roads:
        s = arc_lengths(road.centre)
        first, last = road.trims_m[0], float(s[-1]) - road.trims_m[1]
        inside = road.centre[(s > first + 0.05) & (s < last - 0.05)]
        ends = [pose_at(road.centre, s, q)[:2] for q in (first, last)]
        line = resample(np.vstack((ends[0], inside, ends[1])), 0.95)
        side = road.aside_m if left_hand else -road.aside_m
        road.forward = _lane(road, "f", offset(line, side) if side else line)
        drafts.append(road.forward)
        if road.edge.driving.direction == 0:
            road.backward = _lane(road, "b", offset(line[::-1], side) if side else line[::-1])
            drafts.append(road.backward)
    return drafts


def _lane(road: Road, way: str, points: Array) -> LaneDraft:
    edge = road.edge
    return LaneDraft(
        f"{edge.edge_id}{way}",
        "road",
        resample(points, 0.95),
        edge.driving.width_m,
        edge.driving.speed_mps,
        edge.driving.can_pass,
        [],
        edge.driving.scenario,
        edge.name,
        edge.name_en,
    )


def is_gentle(draft: LaneDraft) -> bool:
    """The cut lane still keeps the least radius."""
    return peak_curvature(draft.points) <= 1.0 / 5.05
