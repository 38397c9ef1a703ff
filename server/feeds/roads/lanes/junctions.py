"""Junctions: places of choice, near ones taken together so that every turn has room."""

import heapq
import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from contract.geometry import Array
from server.feeds.roads.lanes.edges import Edge
from server.feeds.roads.osm.way_segments import Position

# An edge shorter than this leaves no straight between the turns at its two ends.
SHORT_EDGE_M = 16.0
_WIDEST_JUNCTION_M = 36.0


@dataclass(slots=True)
class Junction:
    """The keys that lie in it, and the short edges between them."""

    number: int
    keys: set[int]
    inner: list[Edge] = field(default_factory=list)


@dataclass(slots=True)
class RoadGraph:
    """edges between junctions; `at` tells a key's junction."""

    edges: list[Edge]
    junctions: dict[int, Junction]
    at: dict[int, int]


def gather(edges: Sequence[Edge], positions: dict[int, Position]) -> RoadGraph:
    """Junctions with the short edges inside them; what is left are the roads."""
    parent = {key: key for edge in edges for key in (edge.keys[0], edge.keys[-1])}
    degree: dict[int, int] = dict.fromkeys(parent, 0)
    for edge in edges:
        degree[edge.keys[0]] += 1
        degree[edge.keys[-1]] += 1
    members = {key: {key} for key in parent}

    def root(key: int) -> int:
        while parent[key] != key:
            key = parent[key]
        return key

    inner: list[Edge] = []
    for edge in sorted(edges, key=lambda e: (e.length_m, e.edge_id)):
        first, last = root(edge.keys[0]), root(edge.keys[-1])
        if edge.length_m > SHORT_EDGE_M or 1 in (degree[edge.keys[0]], degree[edge.keys[-1]]):
            continue
        if first == last:
            inner.append(edge)
            continue
        if _spread(members[first] | members[last], positions) > _WIDEST_JUNCTION_M:
            continue
        low, high = min(first, last), max(first, last)
        parent[high] = low
        members[low] |= members.pop(high)
        inner.append(edge)
    at = {key: root(key) for key in parent}
    junctions = {key: Junction(key, members[key]) for key in sorted(members)}
    for edge in sorted(inner, key=lambda e: e.edge_id):
        junctions[at[edge.keys[0]]].inner.append(edge)
    inside = {edge.edge_id for edge in inner}
    return RoadGraph([edge for edge in edges if edge.edge_id not in inside], junctions, at)


def _spread(keys: set[int], positions: dict[int, Position]) -> float:
    points = [positions[key] for key in sorted(keys)]
    return max(math.dist(a, b) for a in points for b in points)


def inner_path(junction: Junction, first: int, last: int) -> Array | None:
    """(n, 2) points of the shortest drive inside the junction from key to key; None where there is none."""
    ways: dict[int, list[tuple[float, int, Array]]] = {}
    for edge in junction.inner:
        begin, end = edge.keys[0], edge.keys[-1]
        ways.setdefault(begin, []).append((edge.length_m, end, edge.points))
        if edge.driving.direction == 0:
            ways.setdefault(end, []).append((edge.length_m, begin, edge.points[::-1]))
    queue: list[tuple[float, int, int]] = [(0.0, 0, first)]
    came: dict[int, tuple[int, Array]] = {}
    settled: set[int] = set()
    count = 0
    best = {first: 0.0}
    while queue:
        length, _, key = heapq.heappop(queue)
        if key in settled:
            continue
        settled.add(key)
        if key == last:
            return _unrolled(came, first, last)
        for step_m, follower, points in ways.get(key, ()):
            if length + step_m < best.get(follower, math.inf):
                best[follower] = length + step_m
                came[follower] = (key, points)
                count += 1
                heapq.heappush(queue, (length + step_m, count, follower))
    return None


def _unrolled(came: dict[int, tuple[int, Array]], first: int, last: int) -> Array:
    pieces: list[Array] = []
    key = last
    while key != first:
        key, points = came[key]
        pieces.append(points)
    if not pieces:
        return np.empty((0, 2))
    path: Array = np.vstack(pieces[::-1])
    return path
