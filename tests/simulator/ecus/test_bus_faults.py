"""A fault of the bus changes what it says, and nothing else."""

import pytest

from simulator.ecus.bus_faults import BusFaults, flipped
from simulator.ecus.safety_driver import OVERRIDE_PEDAL_RATIO, SafetyDriver
from vehicle_agent.signals import CanFrame

FRAME = CanFrame(7, 0x211, bytes(4))


@pytest.mark.parametrize("bit", range(32))
def test_one_bit_is_flipped_counted_from_the_first_bytes_highest(bit: int) -> None:
    spoiled = flipped(FRAME, bit)
    assert int.from_bytes(spoiled.data) == 1 << (31 - bit)
    assert (spoiled.stamp_ns, spoiled.arbitration_id) == (7, 0x211)
    assert flipped(spoiled, bit) == FRAME
    assert flipped(FRAME, bit + 32) == spoiled


def test_each_direction_of_a_bus_is_lost_by_itself() -> None:
    faults = BusFaults()
    assert (faults.to_module((FRAME,)), faults.to_vehicle((FRAME,))) == ((FRAME,), (FRAME,))
    faults.loses_to_module = True
    assert (faults.to_module((FRAME,)), faults.to_vehicle((FRAME,))) == ((), (FRAME,))
    faults.loses_to_module, faults.loses_to_vehicle = False, True
    assert (faults.to_module((FRAME,)), faults.to_vehicle((FRAME,))) == ((FRAME,), ())


def test_reports_that_did_not_arrive_as_they_were_sent_are_counted() -> None:
    faults = BusFaults()
    other = CanFrame(8, 0x212, bytes(4))
    faults.to_vehicle((FRAME, other))
    assert faults.changed_to_vehicle == 0
    faults.filter_to_vehicle = lambda frames: (flipped(frames[0], 3), *frames[1:])
    faults.to_vehicle((FRAME, other))
    faults.to_module((FRAME,))
    assert faults.changed_to_vehicle == 1


@pytest.mark.parametrize("pedal", ["brake_ratio", "throttle_ratio"])
def test_a_foot_that_rests_on_a_pedal_takes_nothing_over(pedal: str) -> None:
    assert not SafetyDriver(**{pedal: OVERRIDE_PEDAL_RATIO}).takes_over
    assert SafetyDriver(**{pedal: OVERRIDE_PEDAL_RATIO + 0.01}).takes_over


def test_a_hand_on_the_wheel_takes_over_also_straight_ahead() -> None:
    assert SafetyDriver(steer_rad=0.0).takes_over
    assert not SafetyDriver().takes_over
