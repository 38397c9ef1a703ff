"""Resting places: a greedy set that keeps the promise of `contract.roads.model.RestingPlace`."""

import math
from collections.abc import Callable, Collection, Iterable, Sequence

from contract.roads.design_vehicle import FRONT_REACH_M, REAR_OVERHANG_M, STANDING_MARGIN_M
from contract.roads.model import RestingPlace, RoadMap, Stop
from contract.roads.network import RoadNetwork
from contract.roads.routing import find_route, route_sections
from contract.roads.section_graph import SectionGraph

# With this many places, further ones on busy roads, which cause detours, are not worth having.
ENOUGH_PLACES = 6
MOST_PLACES = 24
SPACING_M = 50.0
_SPEED_CAP_MPS = 15.0 / 3.6
_SHORTEST_SECTION_M = REAR_OVERHANG_M + FRONT_REACH_M + 2.0 * STANDING_MARGIN_M


def resting_places(road_map: RoadMap) -> tuple[RestingPlace, ...]:
    """Resting places for a map that has none yet: dead ends first, then parking, then near stops."""
    graph = SectionGraph(road_map.sections, [(lane.lane_id, lane.successors) for lane in road_map.lanes])
    network = RoadNetwork(road_map)

    def apart(one: int, other: int) -> float:
        here, there = (graph.sections[number] for number in (one, other))
        return math.dist(
            network.pose(here.lane_id, here.s_to_m)[:2], network.pose(there.lane_id, there.s_to_m)[:2]
        )

    return rest(graph, road_map.stops, _by_merit(network, graph), _busy(network, graph), apart)


def _by_merit(network: RoadNetwork, graph: SectionGraph) -> list[int]:
    stops = [network.pose(stop.lane_id, stop.s_m)[:2] for stop in network.road_map.stops]

    def merit(number: int) -> tuple[int, float, int]:
        section = graph.sections[number]
        lane = network.lanes[section.lane_id]
        if lane.kind == "turnaround":
            rank = 0
        elif lane.scenario == "parking_lot":
            rank = 1
        else:
            rank = 2 if lane.kind == "road" else 3
        here = network.pose(section.lane_id, section.s_to_m)[:2]
        return rank, min(math.dist(here, stop) for stop in stops), number

    return sorted(range(len(graph.sections)), key=merit)


def _busy(network: RoadNetwork, graph: SectionGraph) -> set[int]:
    """The sections of the fastest drives between all stops."""
    busy: set[int] = set()
    stops = network.road_map.stops
    for one in stops:
        for other in stops:
            route = find_route(
                network, one.lane_id, one.s_m, other.lane_id, other.s_m, speed_cap_mps=_SPEED_CAP_MPS
            )
            if route is not None:
                busy.update(graph.numbers[section_id] for section_id in route_sections(network, route))
    return busy


def rest(
    graph: SectionGraph,
    stops: Sequence[Stop],
    order: Iterable[int],
    busy: Collection[int],
    apart: Callable[[int, int], float],
) -> tuple[RestingPlace, ...]:
    """Resting places chosen greedily: all that the promise allows on quiet sections, on busy ones up to six.

    order  section numbers to try, the most wanted first
    busy   sections that the fastest drives between stops use
    At most 24, and no two crowded: each is one more thing for every route to keep clear of.
    """
    candidates = [i for i in order if standing_s_m(graph, i) is not None]
    quiet = [i for i in candidates if not graph.shadows[i] & frozenset(busy)]
    wanted = frozenset(graph.at(stop.lane_id, stop.s_m) for stop in stops)
    chosen: list[int] = []
    for i in quiet:
        if len(chosen) == MOST_PLACES:
            break
        if any(apart(i, other) < SPACING_M for other in chosen):
            continue
        if _holds(graph, [*chosen, i], wanted):
            chosen.append(i)
    for i in candidates:
        if len(chosen) >= ENOUGH_PLACES:
            break
        if i not in chosen and _holds(graph, [*chosen, i], wanted):
            chosen.append(i)
    if not chosen:
        # Alone on a strongly connected map, a shuttle gets everywhere from wherever it stands.
        chosen = candidates[:1]
    return tuple(_place(graph, i, number) for number, i in enumerate(chosen, start=1))


def standing_s_m(graph: SectionGraph, number: int) -> float | None:
    """Where the rear axle stands so that the body is inside the section; None where it is too short."""
    section = graph.sections[number]
    if section.s_to_m - section.s_from_m < _SHORTEST_SECTION_M:
        return None
    return math.floor((section.s_to_m - FRONT_REACH_M - STANDING_MARGIN_M) * 1000.0) / 1000.0


def _holds(graph: SectionGraph, standing: list[int], wanted: frozenset[int]) -> bool:
    """Sufficient for the promise: one part of the map, free of all shadows, has every stop and every place
    finds its way into it and out of it when only the others are taken."""
    closed = graph.shadow_of(standing)
    if wanted & closed or not wanted:
        return False
    anchor = min(wanted)
    core = graph.reach(anchor, closed) & graph.reach(anchor, closed, backwards=True)
    if not wanted <= core:
        return False
    for k, here in enumerate(standing):
        others = graph.shadow_of(standing[:k] + standing[k + 1 :])
        if here in others:
            return False
        if not (_touches(graph, here, others, core, False) and _touches(graph, here, others, core, True)):
            return False
    return True


def _touches(
    graph: SectionGraph, start: int, closed: Collection[int], core: set[int], backwards: bool
) -> bool:
    ways = graph.before if backwards else graph.after
    seen, stack = {start}, [start]
    while stack:
        for follower in ways[stack.pop()]:
            if follower in core:
                return True
            if follower not in seen and follower not in closed:
                seen.add(follower)
                stack.append(follower)
    return False


def _place(graph: SectionGraph, number: int, count: int) -> RestingPlace:
    s_m = standing_s_m(graph, number)
    assert s_m is not None
    return RestingPlace(f"rest-{count}", graph.sections[number].lane_id, s_m)
