"""The polyline that a screen draws ahead of a shuttle."""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import groupby

import numpy as np

from contract.geometry import Array
from contract.roads.model import Point
from contract.roads.network import LaneLine

TOLERANCE_M = 0.5


@dataclass(frozen=True, slots=True)
class _Shape:
    """A lane as it is drawn: points (n, 2) and s (n,), in metres; whole: all of it, rounded."""

    points: Array
    s: Array
    whole: tuple[Point, ...]


class RouteShapes:
    """One map's lanes as they are drawn; each is simplified once."""

    def __init__(self, lines: Mapping[str, LaneLine]) -> None:
        self.lines = lines
        self._shapes: dict[str, _Shape] = {}

    def ahead(self, route: tuple[str, ...], end_s_m: float, lane_id: str, s_m: float) -> tuple[Point, ...]:
        """From (lane_id, s_m) along the lanes of `route` to end_s_m on its last one; empty when it stands
        there.

        A vehicle that is not on its route gets the whole of it. Lanes unknown to this map are left out.
        """
        start_m = 0.0
        if lane_id in route:
            route, start_m = route[route.index(lane_id) :], s_m
        points: list[Point] = []
        last = len(route) - 1
        for place, lane in enumerate(route):
            if lane not in self.lines:
                continue
            if 0 < place < last:
                points += self._shape(lane).whole
            else:
                to_m = end_s_m if place == last else self.lines[lane].length_m
                points += self._between(lane, start_m if place == 0 else 0.0, to_m)
        return tuple(point for point, _ in groupby(points))

    def _between(self, lane_id: str, from_m: float, to_m: float) -> list[Point]:
        if to_m - from_m <= 0.01:
            return []
        line, shape = self.lines[lane_id], self._shape(lane_id)
        inside = shape.points[(shape.s > from_m) & (shape.s < to_m)]
        ends = [np.interp((from_m, to_m), line.s, line.points[:, axis]) for axis in (0, 1)]
        first, last = np.column_stack(ends)
        return list(_rounded(np.vstack((first, inside, last))))

    def _shape(self, lane_id: str) -> _Shape:
        if lane_id not in self._shapes:
            line = self.lines[lane_id]
            keep = simplified(line.points, TOLERANCE_M)
            points = line.points[keep]
            self._shapes[lane_id] = _Shape(points, line.s[keep], _rounded(points))
        return self._shapes[lane_id]


def _rounded(points: Array) -> tuple[Point, ...]:
    return tuple((round(x, 2), round(y, 2)) for x, y in points.tolist())


def simplified(points: Array, tolerance_m: float) -> Array:
    """A mask of the (n, 2) polyline's points to keep: both ends, and a deviation of at most tolerance_m.

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
    return keep


def _distances(points: Array, start: Array, end: Array) -> Array:
    along = end - start
    length2 = float(along @ along)
    offset = points - start
    t = np.clip(offset @ along / length2, 0.0, 1.0) if length2 > 0.0 else np.zeros(len(points))
    distances: Array = np.hypot(*(offset - t[:, None] * along).T)
    return distances
