"""Which parties board and alight, by codes, taps and seat counts in any order."""

import msgspec
import pytest

from contract.wire.messages import (
    CodeRefused,
    PassengerTap,
    RiderAlighted,
    RiderBoarded,
    RiderDidNotAlight,
    RiderNoShow,
    RiderTask,
    TapAnswered,
    VehicleEvent,
    Visit,
)
from tests.vehicle_agent.mission.ring import a_visit
from vehicle_agent.mission.boarding import (
    SeatState,
    alight,
    close_visit,
    riders_to_board,
    take_code,
    take_seat_count,
    take_tap,
)
from vehicle_agent.mission.memory import MissionMemory

ANN, BOB, EVE = RiderTask("ann", 1, "1111"), RiderTask("bob", 2, "2222"), RiderTask("eve", 1, "3333")
STOP = a_visit("stop", "south", 40.0, board=(ANN, BOB), alight=(EVE,))


class Cabin:
    """Seats and parties while the doors stay open; visit None: an unplanned stop."""

    def __init__(self, *aboard: RiderTask, visit: Visit | None = STOP, occupied: int = 0) -> None:
        self.memory = MissionMemory(aboard=aboard)
        self.seats = SeatState(occupied)
        self.visit = visit
        self.events: tuple[VehicleEvent, ...] = ()

    def sit(self, occupied: int) -> None:
        self._take(take_seat_count(self.memory, self.seats, self.visit, occupied, True))

    def code(self, code: str) -> None:
        self._take(take_code(self.memory, self.seats, self.visit, code, True))

    def tap(self, ride_id: str, kind: str, tap_id: str = "t") -> TapAnswered:
        message = PassengerTap(1, tap_id, ride_id, kind)  # type: ignore[arg-type]
        self._take(take_tap(self.memory, self.seats, self.visit, message, True))
        answer = self.events[-1]
        assert isinstance(answer, TapAnswered)
        return answer

    def _take(self, result: tuple[MissionMemory, SeatState, tuple[VehicleEvent, ...]]) -> None:
        self.memory, self.seats, events = result
        self.events += events

    @property
    def aboard(self) -> list[str]:
        return [rider.ride_id for rider in self.memory.aboard]


def test_a_party_that_sits_down_before_it_types_its_code_is_counted_once() -> None:
    cabin = Cabin(visit=a_visit("stop", "south", 40.0, board=(BOB, ANN)))
    cabin.sit(1)
    assert cabin.aboard == ["ann"], "one seat is no party of two"
    cabin.sit(2)
    cabin.code("2222")
    cabin.sit(3)
    assert cabin.aboard == ["ann", "bob"]
    assert cabin.events == (RiderBoarded("ann", "sensor"), RiderBoarded("bob", "code"))
    assert cabin.seats == SeatState(3)


def test_seats_that_a_code_has_announced_are_owed_one_by_one() -> None:
    cabin = Cabin()
    cabin.code("2222")
    cabin.sit(1)
    cabin.sit(2)
    assert cabin.aboard == ["bob"]
    cabin.sit(3)
    assert cabin.aboard == ["bob", "ann"]


def test_two_parties_that_sit_down_at_once_both_board() -> None:
    cabin = Cabin()
    cabin.sit(3)
    assert cabin.events == (RiderBoarded("ann", "sensor"), RiderBoarded("bob", "sensor"))
    assert cabin.seats == SeatState(3)


def test_strangers_fill_seats_and_no_more_parties_than_there_are_board() -> None:
    cabin = Cabin()
    cabin.sit(5)
    assert cabin.seats.unclaimed == 2
    cabin.sit(4)
    assert (cabin.seats.unclaimed, cabin.aboard) == (1, ["ann", "bob"])


def test_a_rider_who_stands_up_before_the_tap_is_not_counted_twice() -> None:
    two = a_visit("stop", "south", 40.0, alight=(BOB, EVE))
    cabin = Cabin(BOB, EVE, visit=two, occupied=3)
    cabin.sit(2)
    assert cabin.aboard == ["bob"], "the party of one has left"
    cabin.sit(1)
    assert cabin.tap("bob", "alight").accepted
    cabin.sit(0)
    assert cabin.events[-1] != RiderAlighted("bob", "sensor")
    assert (cabin.aboard, cabin.seats) == ([], SeatState(0))


def test_a_code_at_the_own_stop_lets_a_party_out_and_its_seats_empty_afterwards() -> None:
    cabin = Cabin(EVE, ANN, visit=a_visit("stop", "south", 40.0, alight=(EVE,)), occupied=2)
    cabin.code("3333")
    assert cabin.events == (RiderAlighted("eve", "code"),)
    cabin.sit(1)
    assert cabin.aboard == ["ann"]
    cabin.code("1111")
    assert cabin.events[-1] == CodeRefused("stop"), "not her stop"


def test_the_same_count_again_changes_nothing() -> None:
    cabin = Cabin(EVE, occupied=1)
    cabin.sit(1)
    assert (cabin.events, cabin.aboard) == ((), ["eve"])


@pytest.mark.parametrize(
    ("ride_id", "kind", "reason"),
    [
        ("zoe", "board", "this ride does not board at this stop"),
        ("zoe", "alight", "this ride is not aboard"),
        ("ann", "alight", "this ride is not aboard"),
    ],
)
def test_a_tap_that_cannot_be_meant_for_this_stop_is_answered_with_the_reason(
    ride_id: str, kind: str, reason: str
) -> None:
    cabin = Cabin(EVE)
    assert cabin.tap(ride_id, kind) == TapAnswered("t", ride_id, False, reason)
    assert cabin.aboard == ["eve"]


def test_a_tap_of_a_party_that_is_aboard_already_is_accepted_and_changes_nothing() -> None:
    cabin = Cabin(EVE)
    assert cabin.tap("eve", "board") == TapAnswered("t", "eve", True)
    assert cabin.events == (TapAnswered("t", "eve", True),)


def test_a_tap_lets_a_rider_out_at_any_stop_and_the_ride_does_not_board_again() -> None:
    cabin = Cabin(ANN, visit=a_visit("elsewhere", "north", 20.0, board=(ANN,)))
    assert cabin.tap("ann", "alight").accepted
    assert cabin.events[0] == RiderAlighted("ann", "tap")
    assert not cabin.tap("ann", "board", "t2").accepted
    assert riders_to_board(cabin.visit, cabin.memory) == ()


def test_a_tap_behind_closed_doors_changes_nothing() -> None:
    message = PassengerTap(1, "t", "eve", "alight")
    memory, _, (answer,) = take_tap(MissionMemory(aboard=(EVE,)), SeatState(1), STOP, message, False)
    assert answer == TapAnswered("t", "eve", False, "the shuttle does not stand with open doors")
    assert memory.aboard == (EVE,)


def test_a_tap_is_answered_once() -> None:
    cabin = Cabin(EVE)
    cabin.tap("eve", "alight")
    cabin.tap("eve", "alight")
    assert len(cabin.events) == 2


def test_at_an_unplanned_stop_anybody_may_leave_and_nobody_boards() -> None:
    cabin = Cabin(ANN, BOB, visit=None, occupied=3)
    cabin.sit(1)
    assert cabin.events == (RiderAlighted("bob", "sensor"),)
    cabin.code("1111")
    assert cabin.events[-1] == RiderAlighted("ann", "code")
    cabin.sit(4)
    assert cabin.aboard == []


def test_at_an_unplanned_stop_seats_do_not_tell_two_parties_of_one_size_apart() -> None:
    cabin = Cabin(ANN, EVE, visit=None, occupied=2)
    cabin.sit(1)
    assert cabin.events == ()
    cabin.code("3333")
    assert cabin.events == (RiderAlighted("eve", "code"),)


def test_at_an_unplanned_stop_more_empty_seats_than_a_party_has_are_not_that_party() -> None:
    cabin = Cabin(ANN, BOB, visit=None, occupied=6)
    cabin.sit(3)
    assert cabin.aboard == ["ann", "bob"], "three strangers have left"


def test_at_the_end_of_the_dwell_who_is_missing_and_who_stayed_are_each_told_once() -> None:
    memory, events = close_visit(MissionMemory(aboard=(EVE, ANN)), STOP)
    assert events == (RiderNoShow("bob"), RiderDidNotAlight("eve"))
    again, repeated = close_visit(memory, STOP)
    assert (repeated, again) == ((), memory)
    left, _ = alight(memory, "eve", "tap")
    assert (left.overdue, left.settled) == ((), ("bob", "eve"))


def test_at_an_unplanned_stop_nobody_is_missing() -> None:
    memory = MissionMemory(aboard=(ANN,))
    assert close_visit(memory, None) == (memory, ())


def test_a_stop_where_all_went_as_planned_leaves_the_memory_as_it_is() -> None:
    memory = MissionMemory(aboard=(ANN, BOB))
    closed, events = close_visit(memory, msgspec.structs.replace(STOP, alight=()))
    assert closed is memory
    assert events == ()
