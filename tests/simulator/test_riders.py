import numpy as np
import pytest

from contract.geometry import Pose2
from simulator.riders import Rider, Riders
from simulator.vehicle.doors import MOVE_NS, Display, Doors
from tests.simulator.street import QuietPhone
from vehicle_agent.signals import CodeTyped, DoorState, HmiOutput, SeatButton, SeatSensor

FROM, TO, ELSEWHERE = Pose2(20.0, 0.0, 0.0), Pose2(560.0, 0.0, 0.0), Pose2(200.0, 0.0, 0.0)
STEP_NS = 20_000_000


class Cabin:
    """One vehicle's cabin, watched second by second."""

    def __init__(self, vehicle_id: str = "s1") -> None:
        self.phone = QuietPhone(vehicle_id)
        self.riders = Riders(("s1",), self.phone, np.random.default_rng(1))
        self.now_ns = 0
        self.items: list[object] = []

    def stand(self, pose: Pose2, seconds: float, doors_open: bool) -> None:
        for _ in range(round(seconds * 50)):
            self.now_ns += STEP_NS
            self.items.extend(self.riders.step(self.now_ns, "s1", pose, doors_open))

    def codes(self) -> list[str]:
        return [item.code for item in self.items if isinstance(item, CodeTyped)]

    def seats(self) -> list[int]:
        return [item.occupied for item in self.items if isinstance(item, SeatSensor)]


def a_rider(**changes: object) -> Rider:
    values: dict[str, object] = {
        "ride_id": "r1", "code": "4711", "party": 2, "how": "code", "from_map": FROM, "to_map": TO,
    }  # fmt: skip
    return Rider(**(values | changes))  # type: ignore[arg-type]


def test_a_rider_types_the_code_once_and_then_sits() -> None:
    cabin = Cabin()
    cabin.riders.add(a_rider())
    cabin.stand(FROM, 6.0, doors_open=True)
    assert cabin.codes() == ["4711"]
    assert cabin.riders.occupied("s1") == 2
    first_code = next(k for k, item in enumerate(cabin.items) if isinstance(item, CodeTyped))
    first_seat = next(k for k, i in enumerate(cabin.items) if isinstance(i, SeatSensor) and i.occupied)
    assert first_code < first_seat


@pytest.mark.parametrize(
    ("pose", "doors_open", "vehicle_id", "ready_ns"),
    [
        (FROM, False, "s1", 0),
        (ELSEWHERE, True, "s1", 0),
        (FROM, True, "s2", 0),
        (FROM, True, "s1", 10**12),
    ],
)
def test_nobody_boards_through_shut_doors_elsewhere_another_shuttle_or_too_early(
    pose: Pose2, doors_open: bool, vehicle_id: str, ready_ns: int
) -> None:
    cabin = Cabin(vehicle_id)
    cabin.riders.add(a_rider(ready_ns=ready_ns))
    cabin.stand(pose, 10.0, doors_open)
    assert cabin.codes() == []
    assert cabin.riders.occupied("s1") == 0


def test_a_rider_gets_off_at_the_own_stop_and_nowhere_else() -> None:
    cabin = Cabin()
    cabin.riders.add(a_rider())
    cabin.stand(FROM, 6.0, doors_open=True)
    cabin.stand(ELSEWHERE, 10.0, doors_open=True)
    assert cabin.riders.occupied("s1") == 2
    cabin.stand(TO, 6.0, doors_open=True)
    assert cabin.riders.occupied("s1") == 0
    assert cabin.riders.is_gone("r1")
    assert cabin.seats()[-1] == 0


def test_a_tapping_rider_taps_on_the_phone_and_types_nothing() -> None:
    cabin = Cabin()
    cabin.riders.add(a_rider(how="tap"))
    cabin.stand(FROM, 6.0, doors_open=True)
    cabin.stand(TO, 6.0, doors_open=True)
    assert cabin.phone.taps == [("r1", "board"), ("r1", "alight")]
    assert cabin.codes() == []


def test_a_rider_who_forgets_to_get_off_stays_seated() -> None:
    cabin = Cabin()
    cabin.riders.add(a_rider(alights=False))
    cabin.stand(FROM, 6.0, doors_open=True)
    cabin.stand(TO, 30.0, doors_open=True)
    assert cabin.riders.occupied("s1") == 2


def test_seats_are_told_at_once_when_they_change_and_once_a_second() -> None:
    cabin = Cabin()
    cabin.stand(ELSEWHERE, 5.0, doors_open=False)
    assert len(cabin.seats()) == 5


def test_a_seat_button_is_heard_once() -> None:
    cabin = Cabin()
    cabin.riders.press_seat_button("s1", 3, 0)
    cabin.stand(ELSEWHERE, 1.0, doors_open=False)
    assert [item.seat for item in cabin.items if isinstance(item, SeatButton)] == [3]


def test_a_ride_has_one_rider() -> None:
    cabin = Cabin()
    cabin.riders.add(a_rider())
    with pytest.raises(ValueError, match="r1"):
        cabin.riders.add(a_rider())


def run_doors(doors: Doors, start_ns: int, seconds: float, speed_mps: float) -> list[DoorState]:
    told = [doors.step(start_ns + k * STEP_NS, speed_mps) for k in range(round(seconds * 50))]
    return [state for state in told if state is not None]


def test_doors_take_two_seconds_and_tell_when_they_are_open() -> None:
    doors = Doors()
    doors.command(True, 0)
    told = run_doors(doors, 0, 4.0, 0.0)
    assert next(state.stamp_ns for state in told if state.open) == MOVE_NS
    doors.command(False, 4 * 10**9)
    told = run_doors(doors, 4 * 10**9, 4.0, 0.0)
    assert told[-1].open is False


def test_doors_stay_shut_while_the_vehicle_moves() -> None:
    doors = Doors()
    doors.command(True, 0)
    assert not any(state.open for state in run_doors(doors, 0, 10.0, 1.0))
    assert any(state.open for state in run_doors(doors, 10 * 10**9, 3.0, 0.0))


def test_an_announcement_is_spoken_once_while_it_stays_the_same() -> None:
    display = Display()
    for stamp, text in enumerate(["", "Next stop: Gate", "Next stop: Gate", "", "Next stop: Gate"]):
        display.show(HmiOutput("screen", "屏幕", text, "", False), stamp)
    assert [stamp for stamp, _, _ in display.announcements] == [1, 4]
