"""Where a vehicle is on the sections that it holds, and how many more of them it asks for."""

import pytest

from contract.geometry import Pose2
from contract.roads.design_vehicle import FRONT_REACH_M, REAR_OVERHANG_M
from contract.roads.load import with_version
from contract.roads.model import Lane, Origin, Point, RoadMap, Section
from contract.roads.network import RoadNetwork
from contract.wire.messages import Status
from server.domain.planning.plans import PlannedVisit
from server.usecases.roads.road_positions import (
    RoadPosition,
    ahead_of,
    road_position,
    sections_to_request,
    under_body,
)
from tests.contract.roads.ring_map import SIDE_M, ring_map

NETWORK = RoadNetwork(ring_map())
# Four sections of 25 m a side; a corner is one section of 15.7 m.
SIDE = tuple(f"side-0/{k}" for k in range(4))
CORNER = "corner-0/0"
CORNER_M = NETWORK.lines["corner-0"].length_m
NEXT = tuple(f"side-1/{k}" for k in range(4))


def _lanes_of(side: int) -> list[tuple[str, int]]:
    """A side's sections behind the corner that leads to it."""
    return [(f"corner-{side - 1}", 0), *((f"side-{side}", number) for number in range(4))]


def a_status(lane_id: str, s_m: float, aside_m: float = 0.0) -> Status:
    x_m, y_m, yaw_rad = NETWORK.pose(lane_id, s_m)
    pose = Pose2(x_m, y_m + aside_m, yaw_rad)
    return Status(1, 1, pose, 0.0, 0.0, 0.0, "autonomous", 0.9, False, lane_id, s_m, "", 0, "")


def a_halt(lane_id: str, s_m: float) -> PlannedVisit:
    return PlannedVisit("v", "stop", "C6", lane_id, s_m)


@pytest.mark.parametrize(
    ("s_m", "under"),
    [
        (10.0, ("side-0/0",)),
        (25.0 - FRONT_REACH_M - 0.01, ("side-0/0",)),
        (25.0 - FRONT_REACH_M + 0.01, ("side-0/0", "side-0/1")),
        (25.0 + REAR_OVERHANG_M - 0.01, ("side-0/0", "side-0/1")),
        (25.0 + REAR_OVERHANG_M + 0.01, ("side-0/1",)),
        (REAR_OVERHANG_M - 0.01, ("corner-3/0", "side-0/0")),
        (SIDE_M - FRONT_REACH_M + 0.01, ("side-0/3", "corner-0/0")),
    ],
)
def test_a_standing_body_covers_every_section_from_its_rear_to_its_front(
    s_m: float, under: tuple[str, ...]
) -> None:
    assert under_body(NETWORK, "side-0", s_m) == under


def test_the_sections_under_a_body_are_told_from_rear_to_front_however_short_they_are() -> None:
    cuts = (("a", 0.0, 30.0), ("b", 0.0, 2.0), ("b", 2.0, 3.5), ("b", 3.5, 30.0))
    ways: dict[str, tuple[Point, ...]] = {
        lane_id: tuple((x_m + float(x), 0.0) for x in range(31)) for lane_id, x_m in (("a", 0.0), ("b", 30.0))
    }
    lanes = tuple(
        Lane(lane_id, "road", points, 4.0, 4.0, False, ("b",) if lane_id == "a" else ())
        for lane_id, points in ways.items()
    )
    sections = tuple(
        Section(f"{lane_id}/{number}", lane_id, begins_m, ends_m, ())
        for number, (lane_id, begins_m, ends_m) in enumerate(cuts)
    )
    road_map = RoadMap("x", "x", Origin(31.0, 121.0), lanes, sections, (), (), ())
    network = RoadNetwork(with_version(road_map))
    assert under_body(network, "b", 0.5) == ("a/0", "b/1", "b/2", "b/3")


@pytest.mark.parametrize(
    ("s_m", "index", "held_m"),
    [
        (30.0, 0, 30.0),
        (24.3, 0, 25.0),
        (50.7, 0, 50.0),
        (50.8, 1, 50.8),
        (75.0, 1, 75.0),
        (75.7, 1, 75.0),
    ],
)
def test_a_position_a_little_off_its_held_sections_is_moved_onto_them(
    s_m: float, index: int, held_m: float
) -> None:
    """By noise a shuttle is reported up to 0.75 m before or behind the sections that it holds."""
    here = road_position(NETWORK, SIDE[1:3], a_status("side-0", s_m))
    assert (here.index, here.lane_id, here.s_m) == (index, "side-0", pytest.approx(held_m))


def test_a_position_on_another_lane_is_moved_to_the_nearest_held_place() -> None:
    held = (SIDE[3], CORNER, NEXT[0])
    status = replace_lane(a_status("side-0", 90.0, aside_m=2.0), "side-2")
    here = road_position(NETWORK, held, status)
    assert (here.index, here.lane_id, here.s_m) == (0, "side-0", pytest.approx(90.0))
    beyond = replace_lane(a_status("side-1", 40.0), "side-2")
    here = road_position(NETWORK, held, beyond)
    assert (here.index, here.lane_id, here.s_m) == (2, "side-1", pytest.approx(25.0))


# Once around the ring and on, from the second section: the first one was released.
ROUND = (
    *SIDE[1:],
    *(f"{lane_id}/{number}" for side in (1, 2, 3) for lane_id, number in _lanes_of(side)),
    "corner-3/0",
    *SIDE,
)


@pytest.mark.parametrize(
    ("lane_id", "s_m", "index", "held_m"),
    [
        ("side-0", 24.0, 0, 25.0),
        ("side-0", 3.0, 0, 25.0),
        ("corner-3", 10.0, 0, 25.0),
        ("side-0", 26.0, 0, 26.0),
        ("side-0", 80.0, 2, 80.0),
        ("corner-0", 5.0, 3, 5.0),
        ("side-3", 20.0, ROUND.index("side-3/0"), 20.0),
    ],
)
def test_a_status_older_than_a_release_is_no_place_of_the_next_round(
    lane_id: str, s_m: float, index: int, held_m: float
) -> None:
    """A loop leads by the same sections again: one that was released is held once more, farther ahead."""
    here = road_position(NETWORK, ROUND, a_status(lane_id, s_m))
    assert (here.index, here.s_m) == (index, pytest.approx(held_m))


def test_a_status_older_than_a_release_is_not_on_the_lane_in_the_opposite_direction() -> None:
    """On the way to a turn: the place before the first held section is nearer to the way back than to it."""
    ways: dict[str, tuple[tuple[Point, ...], tuple[str, ...]]] = {
        "before": (tuple((float(x) - 30.0, 0.0) for x in range(31)), ("out",)),
        "out": (tuple((float(x), 0.0) for x in range(31)), ("turn",)),
        "turn": (((30.0, 0.0), (32.0, 1.5), (30.0, 3.0)), ("back",)),
        "back": (tuple((30.0 - x, 3.0) for x in range(61)), ()),
    }
    lanes = tuple(
        Lane(lane_id, "road", points, 4.0, 4.0, False, after) for lane_id, (points, after) in ways.items()
    )
    lengths_m = {"before": 30.0, "out": 30.0, "turn": 5.0, "back": 60.0}
    sections = tuple(Section(f"{lane_id}/0", lane_id, 0.0, lengths_m[lane_id], ()) for lane_id in ways)
    network = RoadNetwork(with_version(RoadMap("x", "x", Origin(31.0, 121.0), lanes, sections, (), (), ())))
    held = ("out/0", "turn/0", "back/0")
    for s_m in (18.0, 29.0):
        pose = Pose2(*network.pose("before", s_m))
        status = Status(1, 1, pose, 0.0, 0.0, 0.0, "autonomous", 0.9, False, "before", s_m, "", 0, "")
        assert road_position(network, held, status) == RoadPosition(0, "out", 0.0)
        # Also where the map says nothing of the way between.
        beside = replace_lane(status, "turn")
        assert road_position(network, held, beside) == RoadPosition(0, "out", 0.0)


def replace_lane(status: Status, lane_id: str) -> Status:
    fields = {name: getattr(status, name) for name in status.__struct_fields__}
    return Status(**(fields | {"lane_id": lane_id}))


def test_a_vehicle_without_sections_has_no_position() -> None:
    with pytest.raises(ValueError, match="without held sections"):
        road_position(NETWORK, (), a_status("side-0", 1.0))


@pytest.mark.parametrize(
    ("distance_m", "index", "lane_id", "s_m"),
    [
        (4.0, 0, "side-0", 99.0),
        (5.0, 0, "side-0", 100.0),
        (6.0, 1, "corner-0", 1.0),
        (5.0 + CORNER_M + 2.0, 2, "side-1", 2.0),
        (500.0, 2, "side-1", 25.0),
    ],
)
def test_a_place_farther_along_lies_on_the_held_sections_or_at_their_end(
    distance_m: float, index: int, lane_id: str, s_m: float
) -> None:
    held = (SIDE[3], CORNER, NEXT[0])
    there = ahead_of(NETWORK, held, RoadPosition(0, "side-0", 95.0), distance_m)
    assert (there.index, there.lane_id, there.s_m) == (index, lane_id, pytest.approx(s_m))


HERE = RoadPosition(0, "side-0", 20.0)


@pytest.mark.parametrize(
    ("distance_m", "count"), [(5.0, 0), (5.1, 1), (30.0, 1), (30.1, 2), (80.0, 3), (80.1, 4), (1000.0, 4)]
)
def test_road_is_requested_as_far_as_the_distance_reaches(distance_m: float, count: int) -> None:
    ahead = (*SIDE[1:], CORNER)
    assert sections_to_request(NETWORK, SIDE[:1], ahead, HERE, distance_m, None) == count


def test_road_that_is_held_already_counts_as_room() -> None:
    assert sections_to_request(NETWORK, SIDE[:3], (SIDE[3], CORNER), HERE, 55.0, None) == 0
    assert sections_to_request(NETWORK, SIDE[:3], (SIDE[3], CORNER), HERE, 55.1, None) == 1


def test_no_more_road_is_requested_than_the_next_halt_needs() -> None:
    """The bumper and 1.5 m beyond the rear axle's place."""
    ahead = (*SIDE[1:], CORNER, *NEXT)
    nose_m = FRONT_REACH_M + 1.5
    for halt_m, count in ((50.0 - nose_m - 0.1, 1), (50.0 - nose_m + 0.1, 2), (90.0, 3), (99.0, 4)):
        halt = a_halt("side-0", halt_m)
        assert sections_to_request(NETWORK, SIDE[:1], ahead, HERE, 500.0, halt) == count, halt_m
    around = a_halt("side-1", 10.0)
    assert sections_to_request(NETWORK, SIDE[:1], ahead, HERE, 500.0, around) == 5


def test_a_halt_that_the_vehicle_has_just_reached_or_passed_by_a_little_needs_no_road() -> None:
    for halt_m in (20.0, 18.0):
        assert sections_to_request(NETWORK, SIDE[:1], SIDE[1:], HERE, 500.0, a_halt("side-0", halt_m)) == 0
    behind = a_halt("side-0", 16.0)
    assert sections_to_request(NETWORK, SIDE[:1], SIDE[1:], HERE, 500.0, behind) == 3


def test_a_section_that_is_still_held_is_left_before_it_is_requested_again() -> None:
    round_trip = (*SIDE[1:], SIDE[0])
    assert sections_to_request(NETWORK, SIDE[:1], round_trip, HERE, 1000.0, None) == 3
    twice = (SIDE[1], SIDE[2], SIDE[1])
    assert sections_to_request(NETWORK, SIDE[:1], twice, HERE, 1000.0, None) == 2
