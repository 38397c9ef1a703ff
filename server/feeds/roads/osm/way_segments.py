"""Way segments: the drivable pieces of ways, clipped to the map's box and cut at barriers."""

import itertools
import math
from collections import Counter
from dataclasses import dataclass, replace

from server.feeds.roads.lanes.drafts import ImportLog
from server.feeds.roads.osm.drivable import Driving, driving, is_closed_barrier
from server.feeds.roads.osm.frame import Frame
from server.feeds.roads.osm.osm_file import OsmData, OsmWay

_SAME_PLACE_M = 0.1
Position = tuple[float, float]


@dataclass(frozen=True, slots=True)
class WaySegment:
    """Nodes along which one can drive. Keys are OSM node ids, or negative for places made here."""

    way_id: int
    keys: tuple[int, ...]
    driving: Driving
    name: str
    name_en: str


@dataclass(slots=True)
class RoadPlan:
    """All way segments, the positions of their keys, and the keys of dead ends tagged as turning places."""

    segments: list[WaySegment]
    positions: dict[int, Position]
    turning_circles: frozenset[int]
    last_new_key: int

    def new_key(self, position: Position) -> int:
        """A key for a place that is not an OSM node."""
        self.last_new_key -= 1
        self.positions[self.last_new_key] = position
        return self.last_new_key


def drivable_segments(data: OsmData, frame: Frame, log: ImportLog) -> RoadPlan:
    """Every piece of road that a shuttle can drive on, inside the box."""
    circles = frozenset(
        node.node_id
        for node in data.nodes.values()
        if node.tags.get("highway") in ("turning_circle", "turning_loop")
    )
    plan = RoadPlan([], dict(frame.positions), circles, min(0, *frame.positions))
    twins = _joined_places(data, frame, log)
    for way in data.ways.values():
        how = driving(way.tags)
        if how is None:
            continue
        if isinstance(how, str):
            log.dropped.append(f"{_named(way)}: {how}")
            continue
        for keys in _known_pieces(data, way, twins, log):
            for piece in _cut_at_barriers(data, plan, way, keys, log):
                for inside in _clip(frame, plan, way, piece, log):
                    plan.segments.append(
                        WaySegment(
                            way.way_id, inside, how, way.tags.get("name", ""), way.tags.get("name:en", "")
                        )
                    )
    _drop_repeats(plan, log)
    _part_layers(plan, log)
    return plan


def _named(way: OsmWay) -> str:
    name = way.tags.get("name")
    return f"way {way.way_id} ({name})" if name else f"way {way.way_id}"


def _joined_places(data: OsmData, frame: Frame, log: ImportLog) -> dict[int, int]:
    """Road nodes that lie in the same place on the same layer, joined to the one of the lowest id."""
    layers: dict[int, int] = {}
    for way in data.ways.values():
        how = driving(way.tags)
        if isinstance(how, Driving):
            for ref in way.nodes:
                layers.setdefault(ref, how.layer)
    twins: dict[int, int] = {}
    cells: dict[tuple[int, int, int], list[int]] = {}
    for ref in sorted(layers):
        if ref not in frame.positions:
            continue
        x, y = frame.positions[ref]
        column, row = math.floor(x / _SAME_PLACE_M), math.floor(y / _SAME_PLACE_M)
        near = (
            other
            for i in (column - 1, column, column + 1)
            for j in (row - 1, row, row + 1)
            for other in cells.get((i, j, layers[ref]), ())
        )
        twin = next((o for o in near if math.dist(frame.positions[o], (x, y)) <= _SAME_PLACE_M), None)
        if twin is None:
            cells.setdefault((column, row, layers[ref]), []).append(ref)
        else:
            twins[ref] = twin
            log.repairs.append(f"nodes {twin} and {ref} lie in the same place: joined")
    return twins


def _known_pieces(data: OsmData, way: OsmWay, twins: dict[int, int], log: ImportLog) -> list[tuple[int, ...]]:
    """The way cut where the file lacks a node, without repeated nodes."""
    pieces: list[list[int]] = [[]]
    lacking = 0
    repeated = 0
    for ref in way.nodes:
        if ref not in data.nodes:
            lacking += 1
            pieces.append([])
            continue
        key = twins.get(ref, ref)
        if pieces[-1] and pieces[-1][-1] == key:
            repeated += 1
            continue
        pieces[-1].append(key)
    if lacking:
        log.repairs.append(f"{_named(way)}: cut at {lacking} nodes that the file lacks")
    if repeated:
        log.repairs.append(f"{_named(way)}: {repeated} steps of no length removed")
    return [tuple(piece) for piece in pieces if len(piece) >= 2]


def _cut_at_barriers(
    data: OsmData, plan: RoadPlan, way: OsmWay, keys: tuple[int, ...], log: ImportLog
) -> list[tuple[int, ...]]:
    """Pieces between closed barriers; each gets an end of its own there, so that nothing connects."""
    pieces: list[list[int]] = [[]]
    for k, key in enumerate(keys):
        if not is_closed_barrier(data.nodes[key].tags):
            pieces[-1].append(key)
            continue
        log.repairs.append(f"{_named(way)}: cut at {data.nodes[key].tags['barrier']} {key}")
        if k > 0:
            pieces[-1].append(plan.new_key(plan.positions[key]))
        pieces.append([plan.new_key(plan.positions[key])] if k < len(keys) - 1 else [])
    return [tuple(piece) for piece in pieces if len(piece) >= 2]


def _clip(
    frame: Frame, plan: RoadPlan, way: OsmWay, keys: tuple[int, ...], log: ImportLog
) -> list[tuple[int, ...]]:
    """The parts of the way inside the box, with new ends on its border (Liang and Barsky 1984)."""
    pieces: list[list[int]] = []
    lost_m = 0.0
    for first, second in itertools.pairwise(keys):
        a, b = plan.positions[first], plan.positions[second]
        span = _inside_span(frame, a, b)
        length = math.dist(a, b)
        if span is None:
            lost_m += length
            continue
        lost_m += length * (1.0 - (span[1] - span[0]))
        begin = first if span[0] <= 0.0 else plan.new_key(_between(a, b, span[0]))
        end = second if span[1] >= 1.0 else plan.new_key(_between(a, b, span[1]))
        if pieces and pieces[-1][-1] == begin:
            pieces[-1].append(end)
        else:
            pieces.append([begin, end])
    if lost_m > 0.5:
        log.dropped.append(f"{_named(way)}: {lost_m:.0f} m outside the bounds")
    return [tuple(piece) for piece in pieces]


def _between(a: Position, b: Position, t: float) -> Position:
    return a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])


def _inside_span(frame: Frame, a: Position, b: Position) -> tuple[float, float] | None:
    t0, t1 = 0.0, 1.0
    for axis in (0, 1):
        step = b[axis] - a[axis]
        low, high = frame.low[axis] - 1e-6 - a[axis], frame.high[axis] + 1e-6 - a[axis]
        if abs(step) < 1e-12:
            if low > 0.0 or high < 0.0:
                return None
            continue
        near, far = sorted((low / step, high / step))
        t0, t1 = max(t0, near), min(t1, far)
    return (t0, t1) if t1 - t0 > 1e-9 else None


def _drop_repeats(plan: RoadPlan, log: ImportLog) -> None:
    """A stretch drawn twice over the same nodes is kept once."""
    seen: set[tuple[int, int, int]] = set()
    kept: list[WaySegment] = []
    for segment in plan.segments:
        pieces: list[list[int]] = []
        for first, second in zip(segment.keys, segment.keys[1:], strict=False):
            step = (min(first, second), max(first, second), segment.driving.layer)
            if step in seen:
                log.repairs.append(f"way {segment.way_id}: a stretch that another way draws too is kept once")
                continue
            seen.add(step)
            if pieces and pieces[-1][-1] == first:
                pieces[-1].append(second)
            else:
                pieces.append([first, second])
        kept += [replace(segment, keys=tuple(piece)) for piece in pieces]
    plan.segments = kept


def _part_layers(plan: RoadPlan, log: ImportLog) -> None:
    """Where ways of different layers run through one node and none ends there, they do not meet."""
    through: dict[int, set[int]] = {}
    ends: Counter[int] = Counter()
    for segment in plan.segments:
        ends.update((segment.keys[0], segment.keys[-1]))
        for key in segment.keys[1:-1]:
            through.setdefault(key, set()).add(segment.driving.layer)
    parted: dict[tuple[int, int], int] = {}
    for key, layers in sorted(through.items()):
        if len(layers) > 1 and not ends[key]:
            log.repairs.append(f"node {key}: roads on layers {sorted(layers)} cross there and do not meet")
            for layer in sorted(layers)[1:]:
                parted[key, layer] = plan.new_key(plan.positions[key])
    plan.segments = [
        replace(segment, keys=tuple(parted.get((key, segment.driving.layer), key) for key in segment.keys))
        for segment in plan.segments
    ]
