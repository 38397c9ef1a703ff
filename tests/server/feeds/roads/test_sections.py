"""Sections against bodies: who holds what may stand where."""

import itertools
import math
import random

import numpy as np
import pytest
import shapely

from contract.geometry import pose_at
from contract.roads.design_vehicle import (
    CLEARANCE_M,
    FRONT_REACH_M,
    REAR_OVERHANG_M,
    RELEASE_MARGIN_M,
    STANDING_MARGIN_M,
    WIDTH_M,
)
from contract.roads.load import load_map
from contract.roads.model import RoadMap
from contract.roads.network import RoadNetwork
from contract.roads.routing import ReferenceLine, find_route, route_line
from server.feeds.roads.lanes.drafts import LaneDraft
from server.feeds.roads.lanes.sections import tile
from tests.contract.roads.generated_maps import generated_map
from tests.server.feeds.roads.shipped import CAMPUS_MAP, SNOW_LION_MAP

Standing = tuple[shapely.Polygon, frozenset[str]]


def _body(x_m: float, y_m: float, yaw_rad: float) -> shapely.Polygon:
    cos, sin, half = math.cos(yaw_rad), math.sin(yaw_rad), WIDTH_M / 2.0
    corners = (
        (-REAR_OVERHANG_M, -half),
        (FRONT_REACH_M, -half),
        (FRONT_REACH_M, half),
        (-REAR_OVERHANG_M, half),
    )
    return shapely.Polygon([(x_m + cos * a - sin * b, y_m + sin * a + cos * b) for a, b in corners])


def _standing(line: ReferenceLine, s_m: float) -> Standing:
    """A body on the line and what it holds: the sections under it and under its standing margin."""
    under = [
        section_id
        for section_id, begin_m, end_m in line.sections
        if begin_m < s_m + FRONT_REACH_M + STANDING_MARGIN_M
        and end_m > s_m - REAR_OVERHANG_M - RELEASE_MARGIN_M
    ]
    return _body(*pose_at(line.points, line.s, s_m)), frozenset(under)


def _everywhere(road_map: RoadMap, rng: random.Random, routes: int) -> list[Standing]:
    """Bodies every 1.5 m along random routes."""
    network, found = RoadNetwork(road_map), []
    for _ in range(routes):
        one, other = rng.sample(road_map.lanes, 2)
        route = find_route(network, one.lane_id, 0.0, other.lane_id, network.lines[other.lane_id].length_m)
        assert route is not None
        line = route_line(network, route)
        s_m = REAR_OVERHANG_M + rng.random()
        while s_m < line.s[-1] - FRONT_REACH_M:
            found.append(_standing(line, s_m))
            s_m += 1.5
    return found


@pytest.mark.parametrize(
    ("road_map", "routes"),
    [
        (generated_map(1), 25),
        (generated_map(4), 25),
        (load_map(CAMPUS_MAP), 25),
        (load_map(SNOW_LION_MAP), 4),
    ],
    ids=["made-1", "made-4", "campus", "snow-lion"],
)
def test_bodies_whose_sections_do_not_exclude_each_other_never_touch(road_map: RoadMap, routes: int) -> None:
    network = RoadNetwork(road_map)
    standing = _everywhere(road_map, random.Random(7), routes)
    bodies = [body for body, _ in standing]
    compared = 0
    for i, k in shapely.STRtree(bodies).query(bodies, predicate="intersects").T:
        held, others = standing[i][1], standing[k][1]
        compared += 1
        shadow = frozenset().union(*(network.shadow(section_id) for section_id in held))
        assert shadow & others, (held, others)
    assert compared > len(bodies)


def test_the_two_directions_of_a_narrow_road_exclude_each_other() -> None:
    road_map = generated_map(1)
    network = RoadNetwork(road_map)
    narrow = [lane for lane in road_map.lanes if lane.kind == "road" and not lane.can_pass]
    assert narrow
    for lane in narrow:
        opposite = lane.lane_id[:-1] + ("b" if lane.lane_id.endswith("f") else "f")
        if opposite not in network.lanes:
            continue
        theirs = {section.section_id for section in network.sections_of(opposite)}
        assert all(theirs & set(section.conflicts) for section in network.sections_of(lane.lane_id))


def test_the_two_directions_of_a_wide_road_do_not_exclude_each_other() -> None:
    road_map = load_map(CAMPUS_MAP)
    network = RoadNetwork(road_map)
    wide = [lane for lane in road_map.lanes if lane.kind == "road" and lane.can_pass]
    assert wide
    for lane in wide:
        opposite = lane.lane_id[:-1] + ("b" if lane.lane_id.endswith("f") else "f")
        theirs = {section.section_id for section in network.sections_of(opposite)}
        assert not any(theirs & set(section.conflicts) for section in network.sections_of(lane.lane_id))


def test_sections_that_follow_each_other_on_one_lane_do_not_exclude_each_other() -> None:
    network = RoadNetwork(generated_map(1))
    for lane_id in network.lanes:
        sections = network.sections_of(lane_id)
        for first, second in itertools.pairwise(sections):
            assert second.section_id not in first.conflicts


@pytest.mark.parametrize(("beyond_m", "excludes"), [(-0.05, True), (0.05, False)])
def test_lanes_side_by_side_exclude_each_other_where_bodies_would_pass_too_closely(
    beyond_m: float, excludes: bool
) -> None:
    """Two shuttles abreast keep the clearance, or only one of them drives."""
    apart_m = WIDTH_M + CLEARANCE_M + beyond_m
    along_m = np.linspace(0.0, 20.0, 41)
    lanes = [
        LaneDraft(name, "road", np.column_stack((along_m, np.full(41, y_m))), 3.0, 3.0)
        for name, y_m in (("south", 0.0), ("north", apart_m))
    ]
    south, north = tile(lanes)
    assert (south.conflicts, north.conflicts) == ((("north/0",), ("south/0",)) if excludes else ((), ()))
