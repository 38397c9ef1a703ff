"""Look-ups on a prepared map."""

import math

import numpy as np
import pytest

from contract.roads.design_vehicle import LATERAL_COMFORT_MPS2
from contract.roads.load import with_version
from contract.roads.model import Lane, Origin, Point, RoadMap, Section
from contract.roads.network import RoadNetwork
from tests.contract.roads.ring_map import ring_map


@pytest.fixture(scope="module")
def ring() -> RoadNetwork:
    return RoadNetwork(ring_map())


def test_a_vehicle_beside_a_lane_is_found_with_its_offset(ring: RoadNetwork) -> None:
    assert ring.locate(30.0, 1.5, 0.0) == pytest.approx(("side-0", 30.0, 1.5))
    assert ring.locate(30.0, -1.5, 0.3) == pytest.approx(("side-0", 30.0, -1.5))
    assert ring.locate(30.0, 14.9, 0.0) == pytest.approx(("side-0", 30.0, 14.9))


def test_a_vehicle_that_heads_against_the_only_lane_is_at_sea(ring: RoadNetwork) -> None:
    assert ring.locate(30.0, 0.0, math.pi) is None


@pytest.mark.parametrize(
    "pose",
    [(50.0, 50.0, 0.0), (30.0, 15.1, 0.0), (5000.0, 0.0, 0.0), (math.nan, 0.0, 0.0), (0.0, 0.0, math.inf)],
)
def test_a_pose_far_from_every_lane_is_at_sea(ring: RoadNetwork, pose: tuple[float, float, float]) -> None:
    assert ring.locate(*pose) is None


def crossing() -> RoadNetwork:
    """Two straight lanes that cross in the middle at half a right angle."""
    east: tuple[Point, ...] = tuple((float(x), 0.0) for x in range(-20, 21))
    slant: tuple[Point, ...] = tuple((0.7071 * x, 0.7071 * x) for x in range(-20, 21))
    lanes = tuple(
        Lane(name, "road", p, 4.0, 4.0, False, ()) for name, p in (("east", east), ("slant", slant))
    )
    sections = tuple(Section(f"{name}/0", name, 0.0, 39.9, ()) for name in ("east", "slant"))
    return RoadNetwork(with_version(RoadMap("x", "x", Origin(31.0, 121.0), lanes, sections, (), (), ())))


@pytest.mark.parametrize(("yaw_rad", "lane_id"), [(0.0, "east"), (math.pi / 4, "slant")])
def test_where_lanes_cross_a_vehicle_is_on_the_one_along_which_it_heads(yaw_rad: float, lane_id: str) -> None:
    network = crossing()
    for x_m, y_m in ((0.0, 0.0), (0.5, 0.1), (0.5, 0.4)):
        found = network.locate(x_m, y_m, yaw_rad)
        assert found is not None
        assert found[0] == lane_id


def test_between_two_lanes_a_vehicle_is_on_the_nearer_one() -> None:
    network = crossing()
    for y_m, lane_id in ((1.0, "east"), (9.0, "slant")):
        found = network.locate(10.0, y_m, math.pi / 8)
        assert found is not None
        assert found[0] == lane_id


def test_every_pose_on_a_lane_is_located_there(ring: RoadNetwork) -> None:
    for lane_id, line in ring.lines.items():
        for s_m in np.linspace(0.5, line.length_m - 0.5, 9):
            found = ring.locate(*ring.pose(lane_id, float(s_m)))
            assert found is not None
            assert found[0] == lane_id
            assert found[1] == pytest.approx(s_m, abs=0.05)
            assert found[2] == pytest.approx(0.0, abs=0.01)


def test_sections_are_found_by_distance_and_clamped_to_the_ends(ring: RoadNetwork) -> None:
    assert ring.section_at("side-0", 26.0).section_id == "side-0/1"
    assert ring.section_at("side-0", -5.0).section_id == "side-0/0"
    assert ring.section_at("side-0", 500.0).section_id == "side-0/3"


def test_predecessors_mirror_successors(ring: RoadNetwork) -> None:
    for lane_id in ring.lanes:
        for successor in ring.successors(lane_id):
            assert lane_id in ring.predecessors(successor)


def test_travel_time_obeys_limit_cap_and_lateral_comfort(ring: RoadNetwork) -> None:
    assert ring.travel_time_s("side-0") == pytest.approx(100.0 / 4.0)
    assert ring.travel_time_s("side-0", 2.0) == pytest.approx(100.0 / 2.0)
    corner_speed_mps = math.sqrt(LATERAL_COMFORT_MPS2 * 10.0)
    length_m = ring.lines["corner-0"].length_m
    assert ring.travel_time_s("corner-0") == pytest.approx(length_m / corner_speed_mps, rel=1e-3)


def test_what_must_be_kept_clear_is_the_shadow_of_the_other_resting_places(ring: RoadNetwork) -> None:
    assert ring.kept_clear(()) == {"side-3/0"}
    assert ring.kept_clear({"rest-1"}) == frozenset()


@pytest.mark.parametrize("lane_id", ["side-0", "corner-0"])
def test_the_time_between_two_places_is_what_the_lanes_clock_says_and_its_ends_hold_beyond(
    ring: RoadNetwork, lane_id: str
) -> None:
    clock, s = ring.clock(lane_id, 3.0), ring.lines[lane_id].s
    end_m = float(s[-1])
    for from_m, to_m in (
        (0.0, end_m),
        (0.3 * end_m, 0.6 * end_m),
        (-2.0, 5.0),
        (1.0, end_m + 4.0),
        (-2.0, -1.0),
    ):
        expected_s = np.interp(to_m, s, clock) - np.interp(from_m, s, clock)
        assert ring.time_between(lane_id, from_m, to_m, 3.0) == pytest.approx(expected_s, abs=1e-9)


def test_a_network_answers_alike_without_its_maps_points() -> None:
    whole, slim = RoadNetwork(ring_map()), RoadNetwork(ring_map(), keep_points=False)
    assert slim.map_version == whole.map_version
    assert {len(lane.points) for lane in slim.road_map.lanes} == {2}
    for lane_id, line in whole.lines.items():
        assert np.array_equal(slim.lines[lane_id].points, line.points)
        middle = line.length_m / 2.0
        assert slim.pose(lane_id, middle) == whole.pose(lane_id, middle)
        assert slim.time_between(lane_id, 0.0, middle, 5.0) == whole.time_between(lane_id, 0.0, middle, 5.0)
