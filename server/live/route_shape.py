"""The polyline that a screen draws ahead of a shuttle."""

from collections.abc import Mapping

import numpy as np

from contract.geometry import Array
from contract.roads.model import Point
from contract.roads.network import LaneLine

TOLERANCE_M = 0.5


def route_ahead(
    lines: Mapping[str, LaneLine], route: tuple[str, ...], end_s_m: float, lane_id: str, s_m: float
) -> tuple[Point, ...]:
    """From (lane_id, s_m) along the lanes of `route` to end_s_m on its last one; empty when it stands there.

    A vehicle that is not on its route gets the whole of it. Lanes unknown to this map are left out.
    """
    start_m = 0.0
    if lane_id in route:
        route, start_m = route[route.index(lane_id) :], s_m
    pieces = _pieces(lines, route, start_m, end_s_m)
    if not pieces:
        return ()
    points = simplified(np.concatenate(pieces), TOLERANCE_M)
    return tuple((round(float(x), 2), round(float(y), 2)) for x, y in points)


def _pieces(
    lines: Mapping[str, LaneLine], route: tuple[str, ...], s_from_m: float, s_to_m: float
) -> list[Array]:
    pieces: list[Array] = []
    last = len(route) - 1
    for place, lane_id in enumerate(route):
        line = lines.get(lane_id)
        if line is None:
            continue
        start_m = s_from_m if place == 0 else 0.0
        end_m = s_to_m if place == last else line.length_m
        if end_m - start_m > 0.01:
            pieces.append(_between(line, start_m, end_m))
    return pieces


def _between(line: LaneLine, s_from_m: float, s_to_m: float) -> Array:
    inside = line.s[(line.s > s_from_m) & (line.s < s_to_m)]
    s = np.concatenate(([s_from_m], inside, [s_to_m]))
    points: Array = np.column_stack(
        (np.interp(s, line.s, line.points[:, 0]), np.interp(s, line.s, line.points[:, 1]))
    )
    return points


def simplified(points: Array, tolerance_m: float) -> Array:
    """A subset of the (n, 2) polyline, both ends kept, never farther than tolerance_m from it.

    Douglas and Peucker (1973), with a stack instead of recursion.
    """
    keep = np.zeros(len(points), dtype=bool)
    keep[[0, -1]] = True
    spans = [(0, len(points) - 1)]
    while spans:
        first, last = spans.pop()
        if last - first < 2:
            continue
        distances = _distances(points[first + 1 : last], points[first], points[last])
        worst = int(np.argmax(distances))
        if distances[worst] > tolerance_m:
            middle = first + 1 + worst
            keep[middle] = True
            spans += [(first, middle), (middle, last)]
    kept: Array = points[keep]
    return kept


def _distances(points: Array, start: Array, end: Array) -> Array:
    along = end - start
    length2 = float(along @ along)
    offset = points - start
    t = np.clip(offset @ along / length2, 0.0, 1.0) if length2 > 0.0 else np.zeros(len(points))
    distances: Array = np.hypot(*(offset - t[:, None] * along).T)
    return distances
