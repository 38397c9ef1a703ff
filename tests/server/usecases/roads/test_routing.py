"""The way over a vehicle's visits: granted road is driven to its end, and served on where it still can be."""

from itertools import pairwise

import pytest

from contract.roads.load import encode_map
from server.domain.planning.plans import PlannedVisit
from server.domain.rules import FleetRules
from server.store.roads.map_library import MapLibrary
from server.usecases.roads.road_positions import RoadPosition
from server.usecases.roads.routing import DrivingRoute, way_through
from tests.server.usecases.shipped_maps import shipped_map

ROADS = MapLibrary(FleetRules()).decode(encode_map(shipped_map("snow-lion")))
NETWORK = ROADS.network


def two_granted() -> tuple[str, str]:
    """Two long sections that follow each other on one lane."""
    sections = sorted(NETWORK.sections.values(), key=lambda one: (one.lane_id, one.s_from_m))
    return next(
        (before.section_id, after.section_id)
        for before, after in pairwise(sections)
        if before.lane_id == after.lane_id and after.s_to_m - after.s_from_m > 10.0
    )


HELD = two_granted()
LAST = NETWORK.sections[HELD[1]]


def way_to(*visits: PlannedVisit, stopping_m: float = 0.0) -> DrivingRoute | None:
    """From the beginning of the first granted section."""
    first = NETWORK.sections[HELD[0]]
    start = RoadPosition(0, first.lane_id, first.s_from_m)
    return way_through(ROADS, HELD, start, visits, frozenset(), stopping_m=stopping_m, heading_for="")


def a_rest(s_m: float) -> PlannedVisit:
    return PlannedVisit("rest", "rest", "", LAST.lane_id, s_m)


@pytest.mark.parametrize("s_m", [LAST.s_from_m, LAST.s_from_m + 5.0, LAST.s_to_m - 0.5, LAST.s_to_m])
def test_a_place_anywhere_on_the_last_granted_section_needs_no_more_road(s_m: float) -> None:
    assert way_to(a_rest(s_m)) == DrivingRoute(((LAST.lane_id,),), HELD)


def test_a_place_that_is_too_near_to_stop_for_is_come_to_by_going_round() -> None:
    first = NETWORK.sections[HELD[0]]
    near = PlannedVisit("near", "stop", "", first.lane_id, first.s_from_m + 3.0)
    far = PlannedVisit("rest", "rest", "", LAST.lane_id, LAST.s_to_m - 1.0)
    assert way_to(near, far, stopping_m=2.0) == DrivingRoute(((first.lane_id,), (first.lane_id,)), HELD)
    round_about = way_to(near, far, stopping_m=4.0)
    assert round_about is not None
    assert round_about.sections[:2] == HELD
    assert len(round_about.sections) > 4
