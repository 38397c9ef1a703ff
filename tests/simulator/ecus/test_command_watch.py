"""Which commands a module believes: counted, complete, neither crowded nor late."""

import pytest

from simulator.ecus.command_watch import COMMAND_TIMEOUT_NS, SERVO_PROTOCOL, CommandWatch
from vehicle_agent.can.dbc import layouts
from vehicle_agent.can.pacmod.commands import COUNTER_STEPS, FRAME_GAP_NS
from vehicle_agent.signals import CanFrame

PERIOD_NS = 20_000_000


def counted(stamp_ns: int, counter: int) -> CanFrame:
    layout = layouts()["global_command"]
    values = {"counter": float(counter), "complement": float(COUNTER_STEPS - 1 - counter)}
    return CanFrame(stamp_ns, layout.arbitration_id, layout.pack(values))


def test_the_counter_begins_anywhere_and_begins_again_after_its_last_step() -> None:
    watch = CommandWatch()
    for number in range(2 * COUNTER_STEPS):
        assert watch.take(counted(number * PERIOD_NS, (5 + number) % COUNTER_STEPS)) == "global_command"
    assert watch.miscounted == 0


@pytest.mark.parametrize("counter", [5, 7, 4, 0])
def test_a_counter_that_does_not_follow_is_refused_and_the_next_one_that_does_counts(counter: int) -> None:
    watch = CommandWatch()
    watch.take(counted(0, 5))
    assert watch.take(counted(PERIOD_NS, counter)) == ""
    assert watch.take(counted(2 * PERIOD_NS, (counter + 1) % COUNTER_STEPS)) == "global_command"
    assert watch.miscounted == 1


def test_a_command_is_late_once_it_is_older_than_a_tenth_of_a_second() -> None:
    watch = CommandWatch()
    assert watch.is_late("global_command", 0), "before the first"
    watch.take(counted(PERIOD_NS, 1))
    assert not watch.is_late("global_command", PERIOD_NS + COMMAND_TIMEOUT_NS)
    assert watch.is_late("global_command", PERIOD_NS + COMMAND_TIMEOUT_NS + 1)
    assert COMMAND_TIMEOUT_NS == 100_000_000
    assert "global_command" not in watch.late(PERIOD_NS)
    assert set(watch.late(PERIOD_NS)) == set(watch.protocol.commands) - {"global_command"}


def test_frames_that_come_as_fast_as_the_module_can_take_them_are_taken() -> None:
    watch = CommandWatch()
    watch.take(counted(0, 1))
    assert watch.take(counted(FRAME_GAP_NS, 2)) == "global_command"
    assert watch.take(counted(2 * FRAME_GAP_NS - 1, 3)) == ""
    assert watch.crowded == 1


def test_a_command_that_never_came_is_at_rest() -> None:
    assert CommandWatch().value("brake_command", "position") == 0.0
    assert CommandWatch(protocol=SERVO_PROTOCOL).value("brake_command", "travel") == 0.0
