"""The seat button: where the shuttle stops, and when it goes on."""

import msgspec
import numpy as np
import pytest

from contract.geometry import Pose2
from contract.roads.model import NoStoppingZone
from contract.roads.network import RoadNetwork
from contract.wire.messages import Blocked, Command, DoorsChanged, SeatButtonPressed
from tests.vehicle_agent.mission.ring import NETWORK, ROOM, RingShuttle, a_visit, all_sections, an_order, rest
from vehicle_agent.mission.seat_button import StopRules, next_stopping_place
from vehicle_agent.signals import NO_TRACKS, PEDESTRIAN, VEHICLE, SeatButton, Tracks

STOP = ("north", 40.0)
VISITS = (msgspec.structs.replace(a_visit("a", *STOP), name_en="Stop A"), rest(STOP))


def driving(seconds: float, sections: int | None = None) -> RingShuttle:
    shuttle = RingShuttle()
    shuttle.go(an_order(VISITS, sections=all_sections(VISITS)[:sections]))
    shuttle.run(seconds)
    return shuttle


def pressed(shuttle: RingShuttle) -> SeatButtonPressed:
    shuttle.step(SeatButton(shuttle.now_ns, 2))
    answer = shuttle.of(SeatButtonPressed)[-1]
    assert isinstance(answer, SeatButtonPressed)
    return answer


def test_the_shuttle_stops_at_once_comfortably_dwells_eight_seconds_and_goes_on() -> None:
    shuttle = driving(6)
    speed, at_m = shuttle.speed_mps, shuttle.state.s_m
    answer = pressed(shuttle)
    assert answer.accepted
    assert answer.lane_id == "south"
    task = shuttle.step()
    assert task.reason == "requested_stop"
    assert task.stop_name == task.stop_name_en == "", "a requested stop has no name"
    assert at_m + speed**2 / 1.2 <= answer.s_m <= at_m + speed**2 / 1.2 + 4.0
    shuttle.run_until(lambda: shuttle.state.doors.phase == "open")
    assert abs(shuttle.state.s_m - answer.s_m) < 0.5
    opened_ns = shuttle.now_ns
    shuttle.run_until(lambda: shuttle.state.doors.phase != "open")
    assert 7.9e9 <= shuttle.now_ns - opened_ns <= 8.3e9
    assert {e.visit_id for e in shuttle.of(DoorsChanged)} == {answer.visit_id}  # type: ignore[attr-defined]
    shuttle.run(10)
    assert shuttle.speed_mps > 1.0
    task = shuttle.step()
    assert task.reason is None
    assert (task.stop_name, task.stop_name_en) == ("a", "Stop A")


def test_no_passenger_gets_out_in_a_junction() -> None:
    shuttle = driving(20)
    answer = pressed(shuttle)
    assert answer.accepted
    place = NETWORK.section_at(answer.lane_id, answer.s_m)
    assert NETWORK.lanes[answer.lane_id].kind == "road"
    assert place.section_id != "south/3", "the turn crosses there"
    rear = answer.s_m - 0.85
    assert answer.lane_id == "north"
    assert rear >= -1e-9


def test_no_stop_is_made_in_a_no_stopping_zone() -> None:
    """The same press, with a zone about the place where the shuttle would stop: it stops beyond the zone."""
    shuttle = driving(6)
    route, begin_m = shuttle.state.route, shuttle.state.s_m
    assert route is not None
    free_m = next_stopping_place(NETWORK, route, begin_m, 1.0, 80.0, ROOM.rules.body, StopRules(1.0))
    assert free_m is not None
    place = route.place(free_m)
    zone = NoStoppingZone("zone", place.lane_id, place.s_m - 1.0, place.s_m + 5.0)
    zoned = RoadNetwork(msgspec.structs.replace(NETWORK.road_map, no_stopping_zones=(zone,)))
    beyond_m = next_stopping_place(zoned, route, begin_m, 1.0, 80.0, ROOM.rules.body, StopRules(1.0))
    assert beyond_m == pytest.approx(free_m + 5.0 + ROOM.rules.body.back_m)


def test_no_stop_is_made_beyond_the_grants() -> None:
    shuttle = driving(9, sections=2)
    answer = pressed(shuttle)
    assert not answer.accepted
    assert answer.reason != ""


def test_just_before_the_next_stop_the_button_is_refused() -> None:
    shuttle = RingShuttle()
    near = ("south", 22.0)
    shuttle.go(an_order((a_visit("a", *near), rest(near))))
    shuttle.run(5)
    assert not pressed(shuttle).accepted
    assert shuttle.task is not None
    assert shuttle.task.refused_ns > 0


def test_a_button_at_a_stop_or_while_held_is_refused() -> None:
    assert not pressed(RingShuttle()).accepted
    shuttle = driving(6)
    shuttle.run_until(lambda: shuttle.state.memory.under_way != "")
    assert pressed(shuttle).reason == "the shuttle stands at a stop"


def test_a_second_press_requests_the_same_stop() -> None:
    shuttle = driving(6)
    assert pressed(shuttle) == pressed(shuttle)


BODY, HALF_WIDTH_M = ROOM.rules.body, ROOM.rules.half_width_m


def doors_open() -> RingShuttle:
    """The shuttle stands at a requested stop on a straight lane to the east, its doors open."""
    shuttle = driving(6)
    pressed(shuttle)
    shuttle.run_until(lambda: shuttle.state.doors.phase == "open")
    return shuttle


def person(
    shuttle: RingShuttle, x_m: float, y_m: float, kind: int = PEDESTRIAN, speed_mps: float = 0.0
) -> Tracks:
    """One tracked road user of 0.5 m in the shuttle's frame."""
    pose = [[shuttle.pose.x_m + x_m, shuttle.pose.y_m + y_m, 0.0]]
    size = np.full((1, 2), 0.5)
    return Tracks(
        shuttle.now_ns, np.array([7]), np.array([kind]), np.array(pose), np.array([[speed_mps, 0.0]]), size
    )


def leaving_with_somebody_alongside() -> tuple[RingShuttle, Tracks]:
    """The doors have just closed; a person stands 1 m beside the body."""
    shuttle = doors_open()
    shuttle.tracks = alongside = person(shuttle, 1.0, HALF_WIDTH_M + 1.0)
    shuttle.run_until(lambda: shuttle.state.doors.phase == "closed")
    return shuttle, alongside


@pytest.mark.parametrize(
    ("x_m", "y_m"),
    [
        (BODY.front_m + 0.45 + 0.25, 0.0),
        (BODY.front_m + 1.0, HALF_WIDTH_M + 0.5),
        (1.0, -HALF_WIDTH_M - 1.1),
    ],
)
def test_the_shuttle_waits_for_a_tracked_person_until_the_person_has_left(x_m: float, y_m: float) -> None:
    shuttle = doors_open()
    shuttle.tracks = person(shuttle, x_m, y_m)
    shuttle.run(60)
    assert shuttle.speed_mps == 0.0
    assert shuttle.task is not None
    assert shuttle.task.reason == "people_near"
    shuttle.tracks = NO_TRACKS
    shuttle.run(4)
    assert shuttle.speed_mps > 0.0


@pytest.mark.parametrize(("speed_mps", "waits"), [(0.0, False), (2.0, True)])
def test_a_vehicle_alongside_is_waited_for_while_it_moves(speed_mps: float, waits: bool) -> None:
    shuttle = doors_open()
    for _ in range(150):
        shuttle.tracks = person(shuttle, 1.0, HALF_WIDTH_M + 1.0, VEHICLE, speed_mps)
        shuttle.run(0.1)
    assert (shuttle.speed_mps == 0.0) is waits


@pytest.mark.parametrize(("aside_m", "waits"), [(1.1, False), (0.55, False), (0.4, True)])
def test_a_wall_aside_is_waited_for_only_if_it_is_beside_the_body(aside_m: float, waits: bool) -> None:
    shuttle = doors_open()
    along = np.arange(-5.0, 8.0, 0.2)
    shuttle.points = np.column_stack(
        (shuttle.pose.x_m + along, np.full(len(along), shuttle.pose.y_m + HALF_WIDTH_M + aside_m))
    )
    shuttle.run(13)
    assert (shuttle.speed_mps == 0.0) is waits


def test_something_that_stands_before_the_bumper_is_waited_for() -> None:
    shuttle = doors_open()
    shuttle.points = np.array([[shuttle.pose.x_m + BODY.front_m + 1.0, shuttle.pose.y_m]])
    shuttle.run(60)
    assert shuttle.speed_mps == 0.0


def test_a_track_whose_place_is_not_a_number_is_waited_for() -> None:
    shuttle = doors_open()
    shuttle.tracks = person(shuttle, np.nan, 0.0)
    shuttle.run(20)
    assert shuttle.speed_mps == 0.0


def test_the_operator_hears_once_of_people_who_stay_and_ends_the_wait_by_a_resume() -> None:
    shuttle, _ = leaving_with_somebody_alongside()
    shuttle.run(29)
    assert shuttle.of(Blocked) == []
    shuttle.run(31)
    assert [event.cleared for event in shuttle.of(Blocked)] == [False]  # type: ignore[attr-defined]
    assert shuttle.speed_mps == 0.0
    shuttle.step(Command(1, "go on", "resume"))
    shuttle.run(2)
    assert shuttle.speed_mps > 0.0
    assert [event.cleared for event in shuttle.of(Blocked)] == [False, True]  # type: ignore[attr-defined]


def test_a_hold_that_is_over_does_not_end_the_wait_for_people() -> None:
    """The server resumes a vehicle by the clock: no operator has looked."""
    shuttle, _ = leaving_with_somebody_alongside()
    shuttle.run(5)
    shuttle.step(Command(1, "wait", "hold"))
    shuttle.run(2)
    shuttle.step(Command(2, "the time is over", "resume"))
    shuttle.run(5)
    assert shuttle.speed_mps == 0.0


def test_one_look_without_the_people_alongside_is_no_reason_to_go() -> None:
    shuttle, alongside = leaving_with_somebody_alongside()
    for _ in range(8):
        shuttle.tracks = NO_TRACKS
        shuttle.run(0.9)
        shuttle.tracks = alongside
        shuttle.run(0.1)
        assert shuttle.speed_mps == 0.0
    shuttle.tracks = NO_TRACKS
    shuttle.run(1.3)
    assert shuttle.speed_mps > 0.0


# From the rear axle: the outline is 0.85 m back, 3.5 m ahead and 0.815 m to either side.
@pytest.mark.parametrize(
    ("ahead_m", "aside_m", "waits"),
    [
        (1.0, 0.815 + 0.25 + 1.4, True),
        (1.0, -0.815 - 0.25 - 1.4, True),
        (1.0, 0.815 + 0.25 + 1.6, False),
        (3.5 + 0.25 + 1.4, 0.5, True),
        (3.5 + 0.25 + 1.6, 0.5, False),
        (-0.85 - 0.2, 0.0, True),
        (-0.85 - 0.3, 0.0, False),
        (3.5 + 1.4, 0.815 + 1.4, False),
        (1.0, 12.0, False),
    ],
)
def test_people_are_waited_for_within_a_metre_and_a_half_of_the_body_except_behind_it(
    ahead_m: float, aside_m: float, waits: bool
) -> None:
    shuttle = doors_open()
    assert shuttle.pose.yaw_rad == 0.0
    shuttle.tracks = person(shuttle, ahead_m, aside_m)
    shuttle.run(15)
    assert (shuttle.speed_mps == 0.0) is waits


def test_a_new_order_keeps_the_requested_stop() -> None:
    shuttle = driving(6)
    answer = pressed(shuttle)
    shuttle.step(an_order(VISITS, revision=2))
    assert shuttle.state.temporary is not None
    assert abs(shuttle.state.temporary.s_m - answer.s_m) < 0.01


def test_a_new_order_keeps_a_requested_stop_that_the_shuttle_has_just_rolled_past() -> None:
    shuttle = driving(6)
    answer = pressed(shuttle)
    shuttle.pose = Pose2(*NETWORK.pose(answer.lane_id, answer.s_m + 0.4))
    shuttle.step()
    shuttle.step(an_order(VISITS, revision=2))
    shuttle.run_until(lambda: shuttle.state.doors.phase == "open", limit_s=10.0)
    assert shuttle.of(DoorsChanged) == [DoorsChanged(True, answer.visit_id)]


@pytest.mark.parametrize("beyond_m", [0.0, 1.2])
def test_a_new_order_during_a_requested_stop_neither_shortens_it_nor_keeps_the_shuttle(
    beyond_m: float,
) -> None:
    shuttle = driving(6)
    answer = pressed(shuttle)
    shuttle.pose = Pose2(*NETWORK.pose(answer.lane_id, answer.s_m + beyond_m))
    shuttle.run_until(lambda: shuttle.state.doors.phase == "open")
    shuttle.step(an_order(VISITS, revision=2))
    shuttle.run(7.5)
    assert shuttle.doors_open
    shuttle.run(10)
    assert shuttle.speed_mps > 1.0


def test_a_new_order_that_does_not_lead_over_the_requested_stop_leaves_its_own_visits_to_be_made() -> None:
    shuttle = driving(20)
    assert pressed(shuttle).lane_id == "north"
    shuttle.step(an_order((a_visit("b", "south", 76.0, kind="rest"),), revision=2))
    shuttle.run(0.5)
    assert [(visit.visit_id, visit.state) for visit in shuttle.state.memory.visits] == [("b", "pending")]
