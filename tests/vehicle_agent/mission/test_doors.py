"""A shuttle leaves only with doors that are closed, as far as the sensor knows."""

from tests.vehicle_agent.mission.ring import RingShuttle, a_visit, an_order, rest
from vehicle_agent.mission.doors import Doors
from vehicle_agent.signals import DoorState

STOP = ("south", 40.0)
TRAVEL_NS = 1_500_000_000


def closing() -> RingShuttle:
    """The dwell is over, the doors are on their way; the test says what the sensor does."""
    shuttle = RingShuttle()
    shuttle.go(an_order((a_visit("a", *STOP), rest(STOP))))
    shuttle.run_until(lambda: shuttle.state.doors.phase == "open")
    shuttle.door_sensor = False
    for _ in range(600):
        if shuttle.state.doors.phase == "closing":
            return shuttle
        shuttle.step(DoorState(shuttle.now_ns, True))
    raise AssertionError("the doors never close")


def feel(shuttle: RingShuttle, *states: bool) -> None:
    """One step, in which the sensor says so much."""
    shuttle.step(*(DoorState(shuttle.now_ns, state) for state in states))


def test_a_door_that_is_held_open_keeps_the_shuttle_at_the_stop() -> None:
    shuttle = closing()
    for _ in range(300):
        feel(shuttle, True)
        assert shuttle.task is not None
        assert shuttle.task.mode == "dwell"
    assert shuttle.state.memory.visit_state("a") == "under_way"
    feel(shuttle, False)
    assert shuttle.state.memory.visit_state("a") == "done"


def test_a_door_that_opens_again_as_soon_as_it_was_closed_keeps_the_shuttle_at_the_stop() -> None:
    shuttle = closing()
    feel(shuttle, False, True)
    for _ in range(50):
        feel(shuttle, True)
        assert shuttle.task is not None
        assert shuttle.task.mode == "dwell"
        assert shuttle.speed_mps == 0.0
    feel(shuttle, False)
    shuttle.run(1)
    assert shuttle.task is not None
    assert shuttle.task.mode == "drive"


def test_without_a_sensor_doors_count_as_moved_after_the_time_they_take() -> None:
    opening = Doors().command(True, 1_000)
    assert opening.step(1_000 + TRAVEL_NS - 1, TRAVEL_NS).phase == "opening"
    assert opening.step(1_000 + TRAVEL_NS, TRAVEL_NS).phase == "open"


def test_with_a_sensor_no_time_counts() -> None:
    opening = Doors().sense(False).command(True, 1_000)
    assert opening.step(1_000 + 10 * TRAVEL_NS, TRAVEL_NS).phase == "opening"
    assert opening.sense(True).step(1_001, TRAVEL_NS).phase == "open"


def test_the_same_command_again_does_not_begin_anew() -> None:
    opening = Doors().command(True, 1_000)
    assert opening.command(True, 5_000) == opening
    assert opening.command(False, 5_000) == Doors("closing", 5_000)
