"""Doors and riders: by code, tap and seat."""

import pytest

from contract.wire.messages import (
    CodeRefused,
    Command,
    DoorsChanged,
    PassengerTap,
    RiderAlighted,
    RiderBoarded,
    RiderDidNotAlight,
    RiderNoShow,
    RiderTask,
    TapAnswered,
    VisitChanged,
)
from tests.vehicle_agent.mission.ring import OFFSET_NS, RingShuttle, a_visit, an_order, rest
from vehicle_agent.config import Profile
from vehicle_agent.signals import CodeTyped, SeatSensor
from vehicle_agent.stacks.rooms import mission_rules

RULES = mission_rules(Profile())
DWELL_S = 5.0
ANN, BOB = RiderTask("ann", 1, "1111"), RiderTask("bob", 2, "2222")
ON, OFF = ("south", 40.0), ("north", 30.0)


def at_the_stop(not_before_ns: int = 0, timed: bool = False) -> RingShuttle:
    """Standing at the first stop with open doors."""
    visits = (
        a_visit("on", *ON, board=(ANN, BOB), not_before_ns=not_before_ns, timed=timed),
        a_visit("off", *OFF, ON, alight=(ANN, BOB)),
        rest(OFF),
    )
    shuttle = RingShuttle()
    shuttle.go(an_order(visits))
    shuttle.run_until(lambda: shuttle.state.doors.phase == "open")
    return shuttle


def to_the_next_stop(shuttle: RingShuttle) -> None:
    shuttle.run(2)
    shuttle.run_until(lambda: shuttle.state.doors.phase == "closed")
    shuttle.run_until(lambda: shuttle.state.doors.phase == "open")


def test_what_a_forgetful_server_asks_for_again_is_told_again() -> None:
    """Its database was restored: it wants one party picked up that is aboard, and one that has left."""
    shuttle = at_the_stop()
    shuttle.step(CodeTyped(1, "1111"))
    shuttle.run(1)
    to_the_next_stop(shuttle)
    shuttle.step(CodeTyped(1, "1111"))
    shuttle.run(1)
    shuttle.run_until(lambda: shuttle.state.stage == "driving")
    known = len(shuttle.events)
    visits = (a_visit("again", "north", 60.0, OFF, board=(BOB,), alight=(ANN,)), rest(("north", 60.0)))
    shuttle.go(an_order(visits, order_id="o2"))
    shuttle.run_until(lambda: shuttle.state.memory.under_way == "again")
    told = shuttle.events[known:]
    assert RiderAlighted("ann", "sensor") in told
    assert RiderNoShow("bob") in told


def test_a_party_that_is_aboard_is_told_again_where_it_should_board() -> None:
    shuttle = at_the_stop()
    shuttle.step(CodeTyped(1, "1111"))
    shuttle.run(1)
    shuttle.run_until(lambda: shuttle.state.stage == "driving")
    known = len(shuttle.events)
    visits = (a_visit("again", *OFF, ON, board=(ANN,)), rest(OFF))
    shuttle.go(an_order(visits, order_id="o2"))
    shuttle.run_until(lambda: shuttle.state.memory.under_way == "again")
    assert RiderBoarded("ann", "sensor") in shuttle.events[known:]


def test_doors_open_only_while_standing_at_the_stop() -> None:
    visits = (a_visit("on", *ON, board=(ANN,)), rest(ON))
    shuttle = RingShuttle()
    shuttle.go(an_order(visits))
    for _ in range(1200):
        task = shuttle.step()
        if task.doors_open:
            assert shuttle.speed_mps == 0.0
            assert abs(task.s_m - 40.0) < 0.5
    doors = [event.open for event in shuttle.of(DoorsChanged)]  # type: ignore[attr-defined]
    assert doors == [True, False]


def test_a_code_boards_its_party_once() -> None:
    shuttle = at_the_stop()
    shuttle.step(CodeTyped(1, "2222"))
    shuttle.step(CodeTyped(1, "9999"))
    assert shuttle.of(RiderBoarded) == [RiderBoarded("bob", "code")]
    assert shuttle.of(CodeRefused) == [CodeRefused("on")]
    assert shuttle.task is not None
    assert shuttle.task.aboard == ("bob",)


def test_seats_board_the_next_party_that_fits() -> None:
    shuttle = at_the_stop()
    shuttle.step(SeatSensor(1, 1))
    assert shuttle.of(RiderBoarded) == [RiderBoarded("ann", "sensor")]
    shuttle.step(SeatSensor(1, 2))
    assert len(shuttle.of(RiderBoarded)) == 1, "one of two is not a party yet"
    shuttle.step(SeatSensor(1, 3))
    assert shuttle.of(RiderBoarded)[-1] == RiderBoarded("bob", "sensor")


def test_a_party_that_typed_its_code_does_not_board_another_when_it_sits_down() -> None:
    shuttle = at_the_stop()
    shuttle.step(CodeTyped(1, "2222"))
    shuttle.step(SeatSensor(1, 2))
    assert shuttle.of(RiderBoarded) == [RiderBoarded("bob", "code")]


def test_a_tap_is_answered_once_and_only_with_open_doors() -> None:
    shuttle = at_the_stop()
    for _ in range(2):
        shuttle.step(PassengerTap(1, "t1", "ann", "board"))
    assert shuttle.of(TapAnswered) == [TapAnswered("t1", "ann", True)]
    assert shuttle.of(RiderBoarded) == [RiderBoarded("ann", "tap")]
    shuttle.run_until(lambda: shuttle.state.doors.phase == "closed")
    shuttle.step(PassengerTap(1, "t2", "bob", "board"))
    answer = shuttle.of(TapAnswered)[-1]
    assert isinstance(answer, TapAnswered)
    assert (answer.accepted, answer.reason != "") == (False, True)


def test_a_rider_who_does_not_come_is_a_no_show_at_the_end_of_the_dwell() -> None:
    shuttle = at_the_stop()
    shuttle.step(CodeTyped(1, "1111"))
    shuttle.run(4)
    assert shuttle.of(RiderNoShow) == []
    shuttle.run(2)
    assert shuttle.of(RiderNoShow) == [RiderNoShow("bob")]
    shuttle.step(CodeTyped(1, "2222"))
    assert len(shuttle.of(RiderBoarded)) == 1


def test_the_shuttle_does_not_leave_before_the_timetable_s_departure() -> None:
    shuttle = at_the_stop(not_before_ns=OFFSET_NS + 60 * 10**9, timed=True)
    shuttle.step(SeatSensor(1, 3))
    while shuttle.now_ns < 59.9e9:
        task = shuttle.step()
        assert task.mode == "dwell"
        assert task.doors_open
    shuttle.run(5)
    assert shuttle.task is not None
    assert shuttle.task.mode == "drive"


def test_a_shuttle_that_is_early_waits_for_its_riders_and_leaves_with_the_last_of_them() -> None:
    shuttle = at_the_stop(not_before_ns=OFFSET_NS + 60 * 10**9)
    shuttle.step(CodeTyped(1, "1111"))
    while shuttle.now_ns < 30e9:
        assert shuttle.step().mode == "dwell"
    shuttle.step(CodeTyped(1, "2222"))
    shuttle.run(5)
    assert shuttle.task is not None
    assert shuttle.task.mode == "drive"
    assert shuttle.of(RiderNoShow) == []


def test_a_shuttle_that_is_early_with_nobody_to_wait_for_leaves_after_its_dwell() -> None:
    shuttle = at_the_stop(not_before_ns=OFFSET_NS + 600 * 10**9)
    shuttle.step(SeatSensor(1, 3))
    shuttle.run(DWELL_S + 3.0)
    assert shuttle.task is not None
    assert shuttle.task.mode == "drive"


@pytest.mark.parametrize(("speed_mps", "close"), [(0.29, False), (0.31, True)])
def test_the_doors_of_a_shuttle_that_rolls_close_at_once(speed_mps: float, close: bool) -> None:
    shuttle = at_the_stop()
    shuttle.speed_mps = speed_mps
    task = shuttle.step()
    assert task.doors_open != close
    assert (shuttle.of(RiderNoShow) != []) == close


def test_riders_alight_by_seat_by_tap_and_by_code() -> None:
    shuttle = at_the_stop()
    shuttle.step(SeatSensor(1, 3))
    to_the_next_stop(shuttle)
    shuttle.step(SeatSensor(1, 2))
    shuttle.step(PassengerTap(1, "t", "bob", "alight"))
    shuttle.step(SeatSensor(1, 0))
    assert shuttle.of(RiderAlighted) == [RiderAlighted("ann", "sensor"), RiderAlighted("bob", "tap")]
    assert shuttle.state.memory.aboard == ()


@pytest.mark.parametrize(("stay", "extra_s"), [(True, RULES.alight_grace_ns * 1e-9), (False, 0.0)])
def test_the_doors_stay_open_a_while_longer_for_who_should_get_off_and_for_nobody_else(
    stay: bool, extra_s: float
) -> None:
    shuttle = at_the_stop()
    shuttle.step(SeatSensor(1, 3))
    to_the_next_stop(shuttle)
    shuttle.step(SeatSensor(1, 2 if stay else 0))
    opened_s = shuttle.now_ns * 1e-9
    shuttle.run_until(lambda: not shuttle.state.doors.commanded_open)
    assert shuttle.now_ns * 1e-9 - opened_s == pytest.approx(DWELL_S + extra_s, abs=0.5)


def test_seats_of_strangers_who_get_up_again_are_not_given_to_the_next_party() -> None:
    """One seat is taken by nobody's booking while the party of two boards by code."""
    shuttle = at_the_stop()
    shuttle.step(CodeTyped(1, "1111"))
    shuttle.step(SeatSensor(1, 1), SeatSensor(2, 2))
    shuttle.step(SeatSensor(3, 1))
    shuttle.step(SeatSensor(4, 2))
    assert [event.ride_id for event in shuttle.of(RiderBoarded)] == ["ann"]  # type: ignore[attr-defined]
    shuttle.step(SeatSensor(5, 3))
    assert [event.ride_id for event in shuttle.of(RiderBoarded)] == ["ann", "bob"]  # type: ignore[attr-defined]


def test_who_gets_up_after_a_tap_is_not_counted_twice() -> None:
    """A tap lets the party of one out; a stranger stands up with it; the party of two stays seated."""
    shuttle = at_the_stop()
    shuttle.step(SeatSensor(1, 3))
    shuttle.step(SeatSensor(2, 5))
    to_the_next_stop(shuttle)
    shuttle.step(PassengerTap(1, "t", "ann", "alight"))
    shuttle.step(SeatSensor(3, 3))
    assert shuttle.of(RiderAlighted) == [RiderAlighted("ann", "tap")]
    shuttle.step(SeatSensor(4, 0))
    assert shuttle.of(RiderAlighted) == [RiderAlighted("ann", "tap"), RiderAlighted("bob", "sensor")]


def test_a_rider_who_stays_aboard_is_reported_once_and_the_shuttle_drives_on() -> None:
    shuttle = at_the_stop()
    shuttle.step(SeatSensor(1, 3))
    to_the_next_stop(shuttle)
    shuttle.step(SeatSensor(1, 2))
    shuttle.run(100)
    assert shuttle.of(RiderDidNotAlight) == [RiderDidNotAlight("bob")]
    done = [e.visit_id for e in shuttle.of(VisitChanged) if e.state == "done"]  # type: ignore[attr-defined]
    assert done == ["on", "off", "rest"]


def test_the_shuttle_does_not_leave_with_a_door_that_does_not_close() -> None:
    shuttle = at_the_stop()
    shuttle.door_sensor = False
    shuttle.run(30)
    assert shuttle.task is not None
    assert (shuttle.task.mode, shuttle.task.s_m) == ("dwell", pytest.approx(40.0, abs=0.5))


def test_without_a_door_sensor_the_doors_count_as_moved_after_their_travel_time() -> None:
    visits = (a_visit("on", *ON), rest(ON))
    shuttle = RingShuttle()
    shuttle.door_sensor = False
    shuttle.go(an_order(visits))
    shuttle.run(60)
    assert [e.open for e in shuttle.of(DoorsChanged)] == [True, False]  # type: ignore[attr-defined]


def on_the_way() -> RingShuttle:
    """Ann and Bob aboard, driving to where they alight."""
    shuttle = at_the_stop()
    shuttle.step(CodeTyped(1, "1111"))
    shuttle.step(CodeTyped(1, "2222"))
    shuttle.run_until(lambda: shuttle.speed_mps > 1.0)
    return shuttle


def test_a_code_typed_behind_closed_doors_boards_nobody() -> None:
    shuttle = RingShuttle()
    shuttle.go(an_order((a_visit("on", *ON, board=(ANN,)), rest(ON))))
    shuttle.run_until(lambda: shuttle.state.doors.phase == "opening")
    shuttle.door_sensor = False
    shuttle.step(CodeTyped(1, "1111"))
    assert shuttle.of(RiderBoarded) == []
    assert shuttle.of(CodeRefused) == [CodeRefused("on")]


def test_a_code_typed_while_driving_lets_nobody_out() -> None:
    shuttle = on_the_way()
    shuttle.step(CodeTyped(1, "1111"))
    assert shuttle.of(RiderAlighted) == []
    assert shuttle.task is not None
    assert shuttle.task.aboard == ("ann", "bob")


def test_seats_that_change_behind_closed_doors_board_and_let_out_nobody() -> None:
    shuttle = on_the_way()
    for occupied in (0, 3, 0):
        shuttle.step(SeatSensor(1, occupied))
    assert shuttle.of(RiderAlighted) == []
    assert len(shuttle.of(RiderBoarded)) == 2


def test_an_empty_code_is_nobodys() -> None:
    shuttle = RingShuttle()
    shuttle.go(an_order((a_visit("on", *ON, board=(RiderTask("eve", 1, ""),)), rest(ON))))
    shuttle.run_until(lambda: shuttle.state.doors.phase == "open")
    shuttle.step(CodeTyped(1, ""))
    assert shuttle.of(RiderBoarded) == []


def test_a_shuttle_that_is_held_at_a_stop_keeps_its_doors_open_until_it_is_resumed() -> None:
    shuttle = at_the_stop()
    shuttle.step(Command(1, "stay", "hold"))
    shuttle.run(60)
    assert shuttle.task is not None
    assert shuttle.task.doors_open
    assert shuttle.of(RiderNoShow) == []
    shuttle.step(CodeTyped(1, "1111"))
    assert shuttle.of(RiderBoarded) == [RiderBoarded("ann", "code")]
    shuttle.step(Command(1, "go on", "resume"))
    shuttle.run(5)
    assert shuttle.task.mode == "drive"
    assert not shuttle.task.doors_open
