"""Observation areas: which points are inside, and where a line passes through."""

import math

import msgspec
import numpy as np
from numba import njit

from contract.geometry import Array, BoolArray, project
from contract.roads.model import ObservationArea
from contract.roads.network import RoadNetwork
from contract.roads.routing import ReferenceLine

# A stop line lies on the line that is driven when it is this near to it.
_ON_LINE_M = 0.5


class AreaAhead(msgspec.Struct, frozen=True):
    """Where one pass through an area lies along a line.

    stop_s_m    where the front bumper stands clear of crossing people
    enter_s_m, leave_s_m  where the line enters and leaves the area's outline; the end of the line when
                it ends inside
    """

    area_id: str
    kind: str
    stop_s_m: float
    enter_s_m: float
    leave_s_m: float


def outline_array(area: ObservationArea) -> Array:
    """(n, 2) corners, map frame."""
    outline: Array = np.array(area.outline, dtype=np.float64).reshape(-1, 2)
    return outline


@njit(cache=True)
def inside(outline: Array, points: Array) -> BoolArray:
    """(m,) which of the (m, 2) points lie in the polygon of (n, 2) corners; even-odd rule."""
    n = outline.shape[0]
    found = np.zeros(points.shape[0], dtype=np.bool_)
    for p in range(points.shape[0]):
        x, y = points[p, 0], points[p, 1]
        odd = False
        for i in range(n):
            ax, ay = outline[i - 1, 0], outline[i - 1, 1]
            bx, by = outline[i, 0], outline[i, 1]
            if (ay > y) != (by > y) and x < ax + (y - ay) / (by - ay) * (bx - ax):
                odd = not odd
        found[p] = odd
    return found


@njit(cache=True)
def _side(ax: float, ay: float, bx: float, by: float, x: float, y: float) -> float:
    return (bx - ax) * (y - ay) - (by - ay) * (x - ax)


@njit(cache=True)
def _boxes_apart(a: float, b: float, c: float, d: float) -> bool:
    """The span from a to b does not reach that from c to d: sides on one straight line are told apart so."""
    return max(a, b) < min(c, d) or max(c, d) < min(a, b)


@njit(cache=True)
def crosses_itself(outline: Array) -> bool:
    """Two sides of the (n, 2) polygon that are not neighbours meet."""
    n = outline.shape[0]
    for i in range(n):
        ax, ay = outline[i, 0], outline[i, 1]
        bx, by = outline[(i + 1) % n, 0], outline[(i + 1) % n, 1]
        for k in range(i + 2, n):
            if (k + 1) % n == i:
                continue
            cx, cy = outline[k, 0], outline[k, 1]
            dx, dy = outline[(k + 1) % n, 0], outline[(k + 1) % n, 1]
            if _boxes_apart(ax, bx, cx, dx) or _boxes_apart(ay, by, cy, dy):
                continue
            apart = _side(ax, ay, bx, by, cx, cy) * _side(ax, ay, bx, by, dx, dy) > 0.0
            if not apart and _side(cx, cy, dx, dy, ax, ay) * _side(cx, cy, dx, dy, bx, by) <= 0.0:
                return True
    return False


def ground_m2(outline: Array) -> float:
    """What the (n, 2) polygon covers (the shoelace formula)."""
    x, y = outline[:, 0], outline[:, 1]
    return 0.5 * abs(float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))))


def areas_ahead(network: RoadNetwork, line: ReferenceLine) -> tuple[AreaAhead, ...]:
    """Each pass of the line through an area that it has a stop line before, in driving order.

    A line that begins beyond the stop line but before or in the area stops where it begins (s = 0). An area
    whose lanes the line drives without touching the outline is left out.
    """
    lanes = set(line.lane_ids)
    found: list[AreaAhead] = []
    for area in network.road_map.observation_areas:
        stops = [place for place in area.stop_lines if place[0] in lanes]
        if not stops and not _may_touch(area, line):
            continue
        spans = _spans(inside(outline_array(area), line.points), line.s)
        stops_s_m = sorted(s_m for place in stops for s_m in _places_on(network, line, *place))
        found += _passes(area, spans, stops_s_m)
    return tuple(sorted(found, key=lambda ahead: (ahead.stop_s_m, ahead.enter_s_m, ahead.area_id)))


def _may_touch(area: ObservationArea, line: ReferenceLine) -> bool:
    outline = outline_array(area)
    low, high = outline.min(axis=0), outline.max(axis=0)
    first = line.points[0]
    return bool(np.all(first >= low - 1.0) and np.all(first <= high + 1.0))


def _passes(
    area: ObservationArea, spans: list[tuple[float, float]], stops_s_m: list[float]
) -> list[AreaAhead]:
    passes = []
    for k, (enter_m, leave_m) in enumerate(spans):
        from_m = spans[k - 1][1] if k else -math.inf
        before = [s_m for s_m in stops_s_m if from_m <= s_m <= leave_m]
        if before:
            passes.append(AreaAhead(area.area_id, area.kind, before[-1], enter_m, leave_m))
        elif enter_m == 0.0:
            passes.append(AreaAhead(area.area_id, area.kind, 0.0, 0.0, leave_m))
    return passes


def _spans(held: BoolArray, s: Array) -> list[tuple[float, float]]:
    """Runs of points inside, as (first, last) along the line."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], held, [False])).astype(np.int8)))
    return [(float(s[i]), float(s[j - 1])) for i, j in zip(edges[::2], edges[1::2], strict=True)]


def _places_on(network: RoadNetwork, line: ReferenceLine, lane_id: str, s_m: float) -> list[float]:
    """Where the line passes a place on a lane; more than once when it drives the lane again."""
    x_m, y_m, _ = network.pose(lane_id, s_m)
    places = []
    for number in (i for i, name in enumerate(line.lane_ids) if name == lane_id):
        on_lane = np.flatnonzero(line.lane_number == number)
        if len(on_lane) == 0:
            continue
        first, last = int(on_lane[0]), min(int(on_lane[-1]) + 1, len(line.s) - 1)
        if last <= first:
            continue
        along_m, aside_m, _ = project(line.points, line.s, x_m, y_m, first, last)
        if abs(aside_m) <= _ON_LINE_M:
            places.append(float(along_m))
    return places
