"""Orders: accepted, repeated, replaced, refused."""

import msgspec
import pytest

from contract.geometry import Pose2
from contract.roads.network import RoadNetwork
from contract.wire.messages import Command, CommandDone, OrderAccepted, OrderRejected, Visit, VisitChanged
from tests.vehicle_agent.mission.ring import (
    NETWORK,
    OFFSET_NS,
    STEP_NS,
    RingShuttle,
    a_visit,
    an_order,
    rest,
    ring,
)
from vehicle_agent.mission.memory import MissionMemory, order_progress
from vehicle_agent.mission.order_line import LanePoint
from vehicle_agent.mission.orders import with_order

STOP = ("south", 40.0)


def two_visits() -> tuple[Visit, ...]:
    return a_visit("a", *STOP), rest(STOP)


def test_an_order_is_driven_to_its_end_visit_by_visit() -> None:
    shuttle = RingShuttle()
    shuttle.go(an_order(two_visits()))
    shuttle.run(200)
    changes = [(e.visit_id, e.state) for e in shuttle.of(VisitChanged)]  # type: ignore[attr-defined]
    assert changes == [("a", "under_way"), ("a", "done"), ("rest", "under_way"), ("rest", "done")]
    assert shuttle.task is not None
    assert shuttle.task.mode == "idle"


def test_a_new_vehicle_is_held_until_a_resume() -> None:
    shuttle = RingShuttle()
    shuttle.step()
    shuttle.step(an_order(two_visits()))
    shuttle.run(10)
    assert shuttle.task is not None
    assert (shuttle.task.mode, shuttle.task.s_m) == ("hold", pytest.approx(5.0))
    shuttle.step(Command(1, "c", "resume"))
    shuttle.run(5)
    assert shuttle.task.s_m > 6.0


def test_a_shuttle_that_was_never_resumed_is_to_stand_where_it_stands_when_its_first_order_comes() -> None:
    shuttle = RingShuttle()
    shuttle.step()
    task = shuttle.step(an_order(two_visits()))
    assert task.line is not None
    assert task.mode == "hold"
    assert task.stop_s_m == pytest.approx(task.s_m, abs=1e-6)


def test_a_repeat_is_accepted_again_and_changes_nothing() -> None:
    shuttle, order = RingShuttle(), an_order(two_visits())
    shuttle.go(order)
    shuttle.run(5)
    memory, line = shuttle.state.memory, shuttle.state.route
    shuttle.step(order)
    assert shuttle.answers == [OrderAccepted(1, "o", 1)] * 2
    assert shuttle.state.memory is memory
    assert shuttle.state.route is line


def test_a_higher_revision_replaces_the_lower_one_mid_way() -> None:
    shuttle = RingShuttle()
    shuttle.go(an_order(two_visits()))
    shuttle.run(5)
    farther = ("south", 60.0)
    shuttle.step(an_order((a_visit("b", *farther), rest(farther)), revision=2))
    shuttle.run(200)
    assert [e.visit_id for e in shuttle.of(VisitChanged) if e.state == "done"] == ["b", "rest"]  # type: ignore[attr-defined]


@pytest.mark.parametrize("rolled_m", [0.1, 1.0])
def test_a_stop_ordered_too_late_to_brake_for_is_served_a_little_beyond(rolled_m: float) -> None:
    shuttle = RingShuttle()
    shuttle.go(an_order(two_visits()))
    shuttle.run(5)
    assert shuttle.task is not None
    here = ("south", shuttle.task.s_m - 0.1)
    shuttle.step(an_order((a_visit("b", *here), rest(here)), revision=2))
    shuttle.pose = Pose2(*NETWORK.pose("south", here[1] + rolled_m))
    shuttle.run(200)
    assert [e.visit_id for e in shuttle.of(VisitChanged) if e.state == "done"] == ["b", "rest"]  # type: ignore[attr-defined]


REFUSED = {
    "stale_revision": an_order(two_visits(), revision=1),
    "expired": an_order(two_visits(), revision=3, expires_ns=OFFSET_NS),
    "map_version": an_order(two_visits(), revision=3, map_version="another"),
}


@pytest.mark.parametrize("code", REFUSED)
def test_an_invalid_order_is_rejected_and_the_old_one_stays(code: str) -> None:
    shuttle = RingShuttle()
    shuttle.go(an_order(two_visits(), revision=2))
    memory = shuttle.state.memory
    shuttle.step(REFUSED[code])
    answer = shuttle.answers[-1]
    assert isinstance(answer, OrderRejected)
    assert answer.code == code
    assert [progress.visit_id for progress in answer.visits] == ["a", "rest"]
    assert shuttle.state.memory is memory


def test_an_order_that_comes_too_late_is_told_by_how_much() -> None:
    shuttle = RingShuttle()
    shuttle.go(an_order(two_visits(), revision=2))
    server_ns = OFFSET_NS + shuttle.now_ns + STEP_NS
    shuttle.step(an_order(two_visits(), revision=3, expires_ns=server_ns - 2_500_000_000))
    assert shuttle.answers[-1].detail == "came 2.5 s after it expired"  # type: ignore[union-attr]


@pytest.mark.parametrize(
    "visits",
    [
        (),
        (a_visit("a", *STOP),),
        (a_visit("a", *STOP), a_visit("a", "north", 70.0, STOP, "rest")),
        (msgspec.structs.replace(a_visit("a", *STOP), s_m=80.5), rest(STOP)),
    ],
)
def test_a_malformed_order_is_refused(visits: tuple[Visit, ...]) -> None:
    shuttle = RingShuttle()
    shuttle.go(an_order(visits, sections=()))
    answer = shuttle.answers[-1]
    assert isinstance(answer, OrderRejected)
    assert answer.code == "malformed"


def test_an_order_with_a_visit_that_no_road_leads_to_is_refused_as_unreachable() -> None:
    road_map = ring()
    lanes = [
        msgspec.structs.replace(lane, successors=()) if lane.lane_id == "east" else lane
        for lane in road_map.lanes
    ]
    network = RoadNetwork(msgspec.structs.replace(road_map, lanes=tuple(lanes)))
    answer = with_order(an_order(two_visits()), MissionMemory(), network, LanePoint("south", 5.0), 1)
    assert isinstance(answer, OrderRejected)
    assert answer.code == "unreachable"


def test_a_revision_must_keep_the_visit_at_which_the_vehicle_stands() -> None:
    shuttle = RingShuttle()
    shuttle.go(an_order(two_visits()))
    shuttle.run_until(lambda: shuttle.state.memory.under_way != "")
    other = ("south", 60.0)
    shuttle.step(an_order((a_visit("b", *other), rest(other)), revision=2))
    answer = shuttle.answers[-1]
    assert isinstance(answer, OrderRejected)
    assert answer.code == "visit_under_way"
    assert answer.visits[0].state == "under_way"
    shuttle.step(an_order((*two_visits()[:1], a_visit("b", *other, STOP), rest(other)), revision=2))
    assert isinstance(shuttle.answers[-1], OrderAccepted)


def test_a_visit_that_is_done_cannot_be_ordered_again() -> None:
    shuttle = RingShuttle()
    shuttle.go(an_order(two_visits()))
    shuttle.run(40)
    shuttle.step(an_order(two_visits(), revision=2))
    answer = shuttle.answers[-1]
    assert isinstance(answer, OrderRejected)
    assert answer.code == "visit_under_way"


def test_an_order_without_routes_is_driven_by_a_star() -> None:
    bare = tuple(msgspec.structs.replace(visit, route=()) for visit in two_visits())
    shuttle = RingShuttle()
    shuttle.go(an_order(bare))
    shuttle.run(200)
    assert shuttle.state.memory.open_visits() == ()


def test_a_stop_just_passed_is_reached_by_going_around() -> None:
    shuttle = RingShuttle(start=("south", 50.0))
    visits = (a_visit("a", "south", 40.0, ("south", 50.0)), rest(STOP))
    shuttle.go(an_order(visits))
    assert shuttle.state.route is not None
    assert shuttle.state.route.line.lane_ids[:5] == ("south", "east", "north", "west", "south")


def test_an_order_that_comes_before_the_first_position_waits_for_it() -> None:
    shuttle = RingShuttle()
    shuttle.valid = False
    shuttle.step(an_order(two_visits()))
    shuttle.step()
    assert shuttle.answers == []
    assert shuttle.state.place.lane_id == "", "what a lost receiver says is no place"
    assert shuttle.state.hold_reason == RingShuttle().state.hold_reason, "and not off the map either"
    shuttle.valid = True
    shuttle.step()
    assert shuttle.answers == [OrderAccepted(1, "o", 1)]


def test_after_a_crash_the_order_is_still_there_and_the_vehicle_held() -> None:
    shuttle = RingShuttle()
    shuttle.go(an_order(two_visits()))
    shuttle.run(8)
    again = RingShuttle(shuttle.state.memory)
    again.pose = shuttle.pose
    again.run(3)
    assert again.task is not None
    assert again.task.mode == "hold"
    known = order_progress(again.state.memory)
    assert known is not None
    assert (known.order_id, known.revision) == ("o", 1)
    again.step(Command(1, "c", "resume"))
    again.run(200)
    assert again.state.memory.open_visits() == ()


def test_a_vehicle_that_rolls_while_its_computer_starts_is_to_stop_where_it_learns_its_place() -> None:
    shuttle = RingShuttle()
    shuttle.go(an_order(two_visits()))
    shuttle.run(8)
    again = RingShuttle(shuttle.state.memory)
    again.pose, again.speed_mps = shuttle.pose, 2.0
    task = again.step()
    assert task.line is not None
    assert task.mode == "hold"
    assert task.stop_s_m == pytest.approx(task.s_m, abs=1e-6)


def test_a_resume_without_a_position_is_refused_with_what_to_do() -> None:
    shuttle = RingShuttle()
    shuttle.valid = False
    shuttle.step(Command(1, "c", "resume"))
    done = shuttle.of(CommandDone)[-1]
    assert isinstance(done, CommandDone)
    assert not done.done
    assert "wait" in done.detail
    shuttle.valid = True
    shuttle.step(Command(1, "c", "resume"))
    assert shuttle.of(CommandDone)[-1] == CommandDone("c", True)


def test_a_shuttle_that_was_driven_off_its_route_holds_until_it_is_back_and_resumed() -> None:
    shuttle = RingShuttle()
    shuttle.go(an_order(two_visits()))
    shuttle.run(6)
    on_route = shuttle.pose
    shuttle.pose = Pose2(on_route.x_m, on_route.y_m - 20.0, on_route.yaw_rad)
    shuttle.step()
    held = shuttle.step()
    assert (held.mode, held.hold_reason, held.hold_detail) == ("hold", "off_route", "")
    shuttle.step(Command(1, "too early", "resume"))
    refused = shuttle.of(CommandDone)[-1]
    assert isinstance(refused, CommandDone)
    assert not refused.done
    assert "drive it onto one by hand" in refused.detail
    shuttle.pose = on_route
    shuttle.step()
    shuttle.step(Command(1, "back", "resume"))
    assert shuttle.of(CommandDone)[-1] == CommandDone("back", True)
    shuttle.run(200)
    assert shuttle.state.memory.open_visits() == ()


@pytest.mark.parametrize(("aside_m", "resumes"), [(4.0, False), (2.6, False), (2.3, True)])
def test_a_resume_beside_the_line_is_refused_where_it_could_not_last(aside_m: float, resumes: bool) -> None:
    """A lane is found from up to 15 m away, but a shuttle drives on it from 2.5 m at most."""
    shuttle = RingShuttle()
    shuttle.go(an_order(two_visits()))
    shuttle.run(6)
    on_route = shuttle.pose
    shuttle.pose = Pose2(on_route.x_m, on_route.y_m - 4.0, on_route.yaw_rad)
    shuttle.step()
    assert shuttle.step().hold_reason == "off_route"
    shuttle.pose = Pose2(on_route.x_m, on_route.y_m - aside_m, on_route.yaw_rad)
    shuttle.step()
    task = shuttle.step(Command(1, "resume", "resume"))
    done = shuttle.of(CommandDone)[-1]
    assert isinstance(done, CommandDone)
    assert done.done == resumes
    if resumes:
        assert (task.mode, shuttle.step().mode) == ("drive", "drive")
    else:
        assert f"{aside_m:.1f} m beside its lane: drive it onto the lane by hand" in done.detail
        assert (task.mode, task.hold_reason) == ("hold", "off_route")


def test_a_new_shuttle_beside_the_road_says_what_keeps_it_from_driving() -> None:
    shuttle = RingShuttle()
    shuttle.pose = Pose2(40.0, -20.0, 0.0)
    assert shuttle.step().hold_reason == "off_map"


def test_the_line_of_an_order_ends_with_its_last_lane() -> None:
    shuttle = RingShuttle()
    end = ("north", 70.0)
    shuttle.go(an_order((a_visit("a", *end), rest(end))))
    task = shuttle.task
    assert task is not None
    assert task.line is not None
    assert task.line.lane_ids == ("south", "east", "north")
    total_m = sum(NETWORK.lines[lane_id].length_m for lane_id in task.line.lane_ids)
    assert task.line.s[-1] == pytest.approx(total_m, abs=0.01)


def test_hold_brakes_comfortably_and_stop_now_at_once() -> None:
    for kind, most_m in (("hold", 12.0), ("stop_now", 0.5)):
        shuttle = RingShuttle()
        shuttle.go(an_order(two_visits()))
        shuttle.run(6)
        at_m = shuttle.state.s_m
        task = shuttle.step(Command(1, "c", kind))  # type: ignore[arg-type]
        assert task.mode == "hold"
        assert task.stop_s_m - at_m < most_m


@pytest.mark.parametrize(
    ("kind", "text", "reason"),
    [
        ("hold", "", "operator_hold"),
        ("hold", "fire drill", "operator_hold"),
        ("stop_now", "", "operator_stop"),
        ("stop_now", "child on the road", "operator_stop"),
    ],
)
def test_a_held_shuttle_says_why_in_the_operators_words(kind: str, text: str, reason: str) -> None:
    shuttle = RingShuttle()
    shuttle.go(an_order(two_visits()))
    shuttle.run(6)
    task = shuttle.step(Command(1, "c", kind, text))  # type: ignore[arg-type]
    assert (task.mode, task.hold_reason, task.hold_detail) == ("hold", reason, text)


def test_a_hold_stops_where_comfortable_braking_ends_and_a_second_word_does_not_move_it() -> None:
    shuttle = RingShuttle()
    shuttle.go(an_order(two_visits()))
    shuttle.run(6)
    # Reaction 0.4 s, then 0.6 m/s2, from the speed that the mission sees in this step.
    speed_mps, at_m = shuttle.speed_mps, shuttle.state.s_m
    task = shuttle.step(Command(1, "c", "hold"))
    assert task.stop_s_m == pytest.approx(shuttle.state.s_m + speed_mps * 0.4 + speed_mps**2 / 1.2, abs=0.02)
    assert shuttle.state.s_m > at_m
    shuttle.run(1)
    again = shuttle.step(Command(1, "d", "hold", "still"))
    assert (again.stop_s_m, again.hold_detail) == (task.stop_s_m, "still")


def test_an_order_that_comes_while_a_held_shuttle_brakes_does_not_move_its_stop() -> None:
    """It has left its first lane, so the new line begins elsewhere."""
    end = ("north", 30.0)
    shuttle = RingShuttle()
    shuttle.go(an_order((a_visit("a", *end), rest(end))))
    shuttle.run_until(lambda: shuttle.state.place.lane_id == "east")
    before = shuttle.step(Command(1, "c", "hold"))
    left_m = before.stop_s_m - before.s_m
    east = (shuttle.state.place.lane_id, shuttle.state.place.s_m)
    after = shuttle.step(an_order((a_visit("b", *end, east), rest(end)), revision=2))
    assert isinstance(shuttle.answers[-1], OrderAccepted)
    assert after.s_m < before.s_m - 50.0
    assert after.stop_s_m - after.s_m == pytest.approx(left_m - shuttle.speed_mps * STEP_NS * 1e-9, abs=0.1)


def test_where_two_lanes_meet_the_shuttle_is_on_the_one_that_its_first_visit_leads_over() -> None:
    end = ("north", 30.0)
    shuttle = RingShuttle(start=("east", 0.2))
    shuttle.go(an_order((a_visit("a", *end), rest(end))))
    assert shuttle.state.route is not None
    assert shuttle.state.route.line.lane_ids == ("south", "east", "north")


def test_a_command_is_obeyed_once_and_a_repeat_is_not_answered_again() -> None:
    shuttle = RingShuttle()
    shuttle.go(an_order(two_visits()))
    shuttle.step(Command(1, "c", "hold"))
    shuttle.step(Command(1, "d", "resume"))
    shuttle.step(Command(1, "c", "hold"))
    assert shuttle.task is not None
    assert shuttle.task.mode == "drive"
    assert [e.command_id for e in shuttle.of(CommandDone)][-2:] == ["c", "d"]  # type: ignore[attr-defined]


def test_an_announcement_changes_nothing_but_what_is_said() -> None:
    shuttle = RingShuttle()
    shuttle.go(an_order(two_visits()))
    shuttle.run(2)
    task = shuttle.step(Command(1, "c", "announce", "Mind the step"))
    assert (task.mode, task.announcement, task.announced_ns) == ("drive", "Mind the step", shuttle.now_ns)


def test_an_announcement_for_a_time_is_shown_until_its_end_or_until_it_is_taken_down() -> None:
    shuttle = RingShuttle()
    shuttle.step()
    until_ns = shuttle.now_ns + OFFSET_NS + 10_000_000_000
    said = Command(1, "c", "announce", "East side today", text_zh="今天在东侧", shown_until_ns=until_ns)
    task = shuttle.step(said)
    assert (task.announcement, task.announcement_zh) == ("East side today", "今天在东侧")
    shown = shuttle.state.shown_announcement()
    assert shown is not None
    assert (shown.text, shown.text_zh) == ("East side today", "今天在东侧")
    shuttle.step(Command(1, "d", "announce", "Mind the step"))
    assert shuttle.state.shown_announcement() == shown, "what is only said takes nothing down"
    shuttle.run(12)
    assert shuttle.state.shown_announcement() is None
    shuttle.step(msgspec.structs.replace(said, command_id="e", shown_until_ns=until_ns + 10**12))
    assert shuttle.state.shown_announcement() is not None
    shuttle.step(Command(1, "f", "announce"))
    assert shuttle.state.shown_announcement() is None


def test_a_vehicle_off_the_map_rejects_orders() -> None:
    shuttle = RingShuttle()
    shuttle.pose = Pose2(5000.0, 5000.0, 0.0)
    shuttle.step()
    shuttle.step(an_order(two_visits()))
    answer = shuttle.answers[-1]
    assert isinstance(answer, OrderRejected)
    assert answer.code == "unreachable"
