"""The line of an order through a fork: which way it takes, and on which of two near lanes the vehicle is."""

import itertools
import math

import pytest

from contract.geometry import Pose2
from contract.roads.model import Lane, Origin, RoadMap, Section
from contract.roads.network import RoadNetwork
from contract.wire.messages import Visit
from vehicle_agent.mission.order_line import LanePoint, VisitUnreachable, locate, order_line

TURN_RAD = 2.5
COS, SIN = math.cos(TURN_RAD), math.sin(TURN_RAD)


def on_map(x_m: float, y_m: float) -> tuple[float, float]:
    """The roads are described with `west` along the x axis, and lie elsewhere on the map."""
    return 30.0 + COS * x_m - SIN * y_m, -12.0 + SIN * x_m + COS * y_m


def a_lane(name: str, *points: tuple[float, float], follows: tuple[str, ...] = ()) -> Lane:
    return Lane(name, "road", tuple(on_map(*point) for point in points), 3.0, 3.0, False, follows)


# From `west` straight over `short` or round over `long` to `east`; `beside` runs 1.2 m north of `west`.
LANES = (
    a_lane("west", (0.0, 0.0), (40.0, 0.0), follows=("short", "long")),
    a_lane("short", (40.0, 0.0), (80.0, 0.0), follows=("east",)),
    a_lane("long", (40.0, 0.0), (60.0, -30.0), (80.0, 0.0), follows=("east",)),
    a_lane("east", (80.0, 0.0), (120.0, 0.0), follows=("back",)),
    a_lane("back", (120.0, 0.0), (60.0, 60.0), (0.0, 0.0), follows=("west",)),
    a_lane("beside", (0.0, 1.2), (40.0, 1.2)),
)
SECTIONS = tuple(
    Section(
        lane.lane_id,
        lane.lane_id,
        0.0,
        sum(itertools.starmap(math.dist, itertools.pairwise(lane.points))),
        (),
    )
    for lane in LANES
)
NETWORK = RoadNetwork(RoadMap("fork", "fork", Origin(31.3, 121.4), LANES, SECTIONS, (), ()))


def a_visit(lane: str, s_m: float, *route: str) -> Visit:
    return Visit("v", "stop", "v", lane, s_m, route, (), (), 0.0, 0, False, "v")


def lanes(visit: Visit, start: tuple[str, float] = ("west", 30.0)) -> tuple[str, ...]:
    return order_line(NETWORK, (visit,), LanePoint(*start), 1).line.lane_ids


def test_the_way_that_the_server_chose_is_driven_though_another_is_shorter() -> None:
    assert lanes(a_visit("east", 10.0, "west", "long", "east")) == ("west", "long", "east")
    assert lanes(a_visit("east", 10.0)) == ("west", "short", "east")


@pytest.mark.parametrize(
    "route", [("east",), ("west", "east"), ("west", "long"), ("short", "east"), ("back", "west", "beside")]
)
def test_a_route_that_does_not_lead_from_here_to_the_visit_is_replaced(route: tuple[str, ...]) -> None:
    assert lanes(a_visit("east", 10.0, *route)) == ("west", "short", "east")


def test_a_route_that_began_behind_the_vehicle_is_driven_from_where_it_is() -> None:
    assert lanes(a_visit("east", 10.0, "back", "west", "long", "east")) == ("west", "long", "east")


@pytest.mark.parametrize(("s_m", "goes_round"), [(29.5, False), (29.3, True), (30.0, False), (35.0, False)])
def test_a_visit_on_this_lane_is_reached_by_going_round_once_it_is_passed(
    s_m: float, goes_round: bool
) -> None:
    driven = lanes(a_visit("west", s_m, "west"))
    assert driven == (("west", "short", "east", "back", "west") if goes_round else ("west",))


def test_a_visit_that_no_way_leads_to_is_named() -> None:
    with pytest.raises(VisitUnreachable, match="no way from lane west at 30 m to visit v"):
        lanes(a_visit("beside", 10.0))


@pytest.mark.parametrize(
    ("y_m", "yaw_rad", "expected", "found"),
    [
        (0.9, 0.0, ("west",), "west"),
        (1.45, 0.0, ("west",), "west"),
        (1.55, 0.0, ("west",), "beside"),
        (0.9, 0.0, (), "beside"),
        (0.9, 0.75, ("west",), "west"),
        (-0.2, 0.0, ("beside",), "beside"),
        (-0.4, 0.0, ("beside",), "west"),
    ],
)
def test_of_two_near_lanes_the_vehicle_is_on_the_one_that_it_is_expected_on(
    y_m: float, yaw_rad: float, expected: tuple[str, ...], found: str
) -> None:
    place = locate(NETWORK, Pose2(*on_map(20.0, y_m), TURN_RAD + yaw_rad), expected)
    assert place is not None
    assert place.lane_id == found
    assert place.s_m == pytest.approx(20.0, abs=0.01)
