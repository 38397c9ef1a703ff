"""The fastest way over the lanes, and the line a vehicle follows along it."""

import heapq
import math
from dataclasses import dataclass

import msgspec
import numpy as np
from numpy.typing import NDArray

from contract.geometry import Array, arc_lengths, curvatures, pose_at
from contract.roads.network import SAME_PLACE_M, RoadNetwork

_DISTINCT_M = 0.02


class Route(msgspec.Struct, frozen=True):
    """A drive from start_s_m on the first lane to end_s_m on the last."""

    lane_ids: tuple[str, ...]
    start_s_m: float
    end_s_m: float
    length_m: float
    time_s: float


@dataclass(frozen=True, slots=True)
class ReferenceLine:
    """A route as one line to follow.

    points (n, 2) at most 1 m apart, map frame; s (n,) from 0; curvature_1pm (n,) signed, left positive;
    speed_limit_mps (n,) of the lane that begins or runs there; lane_number (n,) into `lane_ids`;
    sections: (section_id, s_from_m, s_to_m) along the line, in order, without gaps.
    """

    points: Array
    s: Array
    curvature_1pm: Array
    speed_limit_mps: Array
    lane_number: NDArray[np.int64]
    lane_ids: tuple[str, ...]
    sections: tuple[tuple[str, float, float], ...]


def find_route(
    network: RoadNetwork,
    from_lane: str,
    from_s_m: float,
    to_lane: str,
    to_s_m: float,
    blocked: frozenset[str] = frozenset(),
    *,
    speed_cap_mps: float = math.inf,
) -> Route | None:
    """The fastest drive between two places on lanes, or None where there is none.

    blocked  ids of sections that may not be entered; the one the drive starts in is exempt.
    A destination behind the start on the same lane means going around. Equal times are decided by the
    order of lanes in the map. KeyError for a lane that the map does not have.

    A* (Hart, Nilsson, Raphael 1968); the estimate is the straight distance at the highest speed that any
    lane allows, which is never too long.
    """
    start_section = network.section_at(from_lane, from_s_m).section_id
    closed = blocked - {start_section}
    from_s_m = min(max(from_s_m, 0.0), network.lines[from_lane].length_m)
    to_s_m = min(max(to_s_m, 0.0), network.lines[to_lane].length_m)
    if (
        from_lane == to_lane
        and to_s_m >= from_s_m - SAME_PLACE_M
        and network.is_open(from_lane, from_s_m, to_s_m, closed)
    ):
        time_s = network.time_between(from_lane, from_s_m, max(from_s_m, to_s_m), speed_cap_mps)
        return Route((from_lane,), from_s_m, max(from_s_m, to_s_m), max(0.0, to_s_m - from_s_m), time_s)
    if not network.is_open(from_lane, from_s_m, math.inf, closed):
        return None
    chain = _search(network, from_lane, from_s_m, to_lane, to_s_m, closed, speed_cap_mps)
    if chain is None:
        return None
    lane_ids, time_s = chain
    length_m = (
        network.lines[from_lane].length_m
        - from_s_m
        + sum(network.lines[lane_id].length_m for lane_id in lane_ids[1:-1])
        + to_s_m
    )
    return Route(lane_ids, from_s_m, to_s_m, length_m, time_s)


def _search(
    network: RoadNetwork,
    from_lane: str,
    from_s_m: float,
    to_lane: str,
    to_s_m: float,
    closed: frozenset[str],
    speed_cap_mps: float,
) -> tuple[tuple[str, ...], float] | None:
    numbers = network.lane_numbers
    closed_lanes = {network.sections[section_id].lane_id for section_id in closed}
    goal_x, goal_y, _ = network.pose(to_lane, to_s_m)
    top_speed_mps = min(speed_cap_mps, max(lane.speed_limit_mps for lane in network.road_map.lanes))
    goal_open = network.is_open(to_lane, 0.0, to_s_m, closed)
    last_leg_s = network.time_between(to_lane, 0.0, to_s_m, speed_cap_mps)

    def estimate_s(lane_id: str) -> float:
        x_m, y_m = network.lines[lane_id].points[-1]
        return math.hypot(goal_x - x_m, goal_y - y_m) / top_speed_mps

    def entry(time_s: float, lane_id: str) -> tuple[float, int, float, str]:
        return time_s + estimate_s(lane_id), numbers[lane_id], time_s, lane_id

    first_s = network.time_between(from_lane, from_s_m, network.lines[from_lane].length_m, speed_cap_mps)
    best = {from_lane: first_s}
    came: dict[str, str] = {}
    settled: set[str] = set()
    # The goal is its own node (number -1), so that the start's lane can be its last one too.
    queue: list[tuple[float, int, float, str]] = [entry(first_s, from_lane)]
    while queue:
        _, number, time_s, lane_id = heapq.heappop(queue)
        if number == -1:
            return (*_chain(came, from_lane, lane_id), to_lane), time_s
        if lane_id in settled:
            continue
        settled.add(lane_id)
        for successor in network.successors(lane_id):
            if successor == to_lane and goal_open:
                arrival_s = time_s + last_leg_s
                heapq.heappush(queue, (arrival_s, -1, arrival_s, lane_id))
            if successor in closed_lanes or successor in settled:
                continue
            reached_s = time_s + network.travel_time_s(successor, speed_cap_mps)
            if reached_s < best.get(successor, math.inf):
                best[successor] = reached_s
                came[successor] = lane_id
                heapq.heappush(queue, entry(reached_s, successor))
    return None


def _chain(came: dict[str, str], first: str, last: str) -> tuple[str, ...]:
    chain = [last]
    while chain[-1] != first:
        chain.append(came[chain[-1]])
    return tuple(reversed(chain))


def route_spans(network: RoadNetwork, route: Route) -> tuple[tuple[str, float, float], ...]:
    """(section_id, s_from_m, s_to_m) along the route, in order, without gaps, starting at 0."""
    spans: list[tuple[str, float, float]] = []
    travelled_m = 0.0
    for lane_id, s_from_m, s_to_m in _legs(network, route):
        for section in network.sections_of(lane_id):
            begin_m, end_m = max(section.s_from_m, s_from_m), min(section.s_to_m, s_to_m)
            if end_m > begin_m or (s_to_m == s_from_m and section.s_from_m <= s_from_m <= section.s_to_m):
                spans.append(
                    (section.section_id, travelled_m + begin_m - s_from_m, travelled_m + end_m - s_from_m)
                )
                if s_to_m == s_from_m:
                    break
        travelled_m += s_to_m - s_from_m
    return tuple(spans)


def route_sections(network: RoadNetwork, *routes: Route) -> tuple[str, ...]:
    """The sections of a drive over one or more routes, each beginning where the one before ends."""
    sections: list[str] = []
    for route in routes:
        leg = [section_id for section_id, _, _ in route_spans(network, route)]
        sections += leg[1:] if sections and leg[0] == sections[-1] else leg
    return tuple(sections)


def route_line(network: RoadNetwork, route: Route) -> ReferenceLine:
    """The route's lanes joined to one line, cut at its start and end; one point for a route of no length."""
    pieces = [_cut(network, *leg) for leg in _legs(network, route)]
    sizes = [len(piece) for piece in pieces]
    limits = [network.lanes[lane_id].speed_limit_mps for lane_id in route.lane_ids]
    joined: Array = np.concatenate(pieces)
    kept = _distinct(joined)
    points = joined[kept]
    return ReferenceLine(
        points,
        arc_lengths(points),
        curvatures(points),
        np.repeat(limits, sizes)[kept],
        np.repeat(np.arange(len(pieces), dtype=np.int64), sizes)[kept],
        route.lane_ids,
        route_spans(network, route),
    )


def _distinct(points: Array) -> NDArray[np.int64]:
    """Which points to keep so that no two neighbours all but coincide; the first and the last stay."""
    # Lists, because reading an array number by number takes several times as long.
    places = points.tolist()
    kept = [0]
    for i, place in enumerate(places):
        if math.dist(place, places[kept[-1]]) >= _DISTINCT_M:
            kept.append(i)
    last = len(places) - 1
    if math.dist(places[0], places[last]) > 0.0:
        kept = [*(kept[:-1] if len(kept) > 1 else kept), last]
    return np.array(kept, dtype=np.int64)


def _legs(network: RoadNetwork, route: Route) -> list[tuple[str, float, float]]:
    last = len(route.lane_ids) - 1
    return [
        (
            lane_id,
            route.start_s_m if i == 0 else 0.0,
            route.end_s_m if i == last else network.lines[lane_id].length_m,
        )
        for i, lane_id in enumerate(route.lane_ids)
    ]


def _cut(network: RoadNetwork, lane_id: str, s_from_m: float, s_to_m: float) -> Array:
    """The lane's points from s_from_m to s_to_m, both ends included."""
    line = network.lines[lane_id]
    inside = line.points[(line.s > s_from_m) & (line.s < s_to_m)]
    ends = [pose_at(line.points, line.s, s_m)[:2] for s_m in (s_from_m, s_to_m)]
    cut: Array = np.vstack((ends[0], inside, ends[1]))
    return cut
