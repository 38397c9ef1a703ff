"""The gate's own brake frames, for both by-wires: the module must believe them as it does the tick's."""

from typing import Any

import pytest

from vehicle_agent.can.braking import ByWireBraking
from vehicle_agent.can.handshake import Handshake, Phase
from vehicle_agent.can.pacmod.braking import PacmodBraking
from vehicle_agent.can.pacmod.commands import CommandEncoder
from vehicle_agent.can.servo.braking import ServoBraking
from vehicle_agent.can.servo.commands import ServoEncoder
from vehicle_agent.config import ByWire, SteeringColumn
from vehicle_agent.signals import Actuation, CanFrame

S = 1_000_000_000
ENCODERS: dict[str, Any] = {
    "pacmod": CommandEncoder(SteeringColumn(), wheel_rate_radps=5.0),
    "servo": ServoEncoder(SteeringColumn(), ByWire(), 5.0),
}
GATES: dict[str, ByWireBraking] = {"pacmod": PacmodBraking(), "servo": ServoBraking()}
KINDS = pytest.mark.parametrize("kind", ENCODERS)


def told(
    kind: str,
    counter: int = 3,
    phase: Phase = "on",
    throttle: float = 0.4,
    brake: float = 0.0,
    steer: float = 0.1,
) -> tuple[CanFrame, ...]:
    act = Actuation(True, "drive", steer, throttle, brake)
    frames: tuple[CanFrame, ...] = ENCODERS[kind].frames(act, Handshake(phase, 0), counter, False, S)
    return frames


@KINDS
@pytest.mark.parametrize("steps", [1, 2, 15, 16, 17, 300])
def test_braking_is_a_sound_set_with_its_own_number_the_brake_pressed_and_the_wheel_as_it_was(
    kind: str, steps: int
) -> None:
    gate = GATES[kind]
    asked = gate.commanded(gate.braking_frames(told(kind), steps, 2 * S, 0.6))
    assert asked.counter == (3 + steps) % gate.counter_steps
    assert (asked.enable, asked.throttle_ratio) == (True, 0.0)
    assert asked.brake_ratio == pytest.approx(0.6, abs=2e-3)
    assert asked.steer_rad == pytest.approx(0.1, abs=2e-3)


@KINDS
def test_braking_frames_are_stamped_now_in_sending_order(kind: str) -> None:
    gate = GATES[kind]
    stamps = [frame.stamp_ns for frame in gate.braking_frames(told(kind), 1, 2 * S, 1.0)]
    assert stamps == [2 * S + number * gate.frame_gap_ns for number in range(len(stamps))]


@KINDS
def test_where_by_wire_is_off_the_gate_presses_nothing(kind: str) -> None:
    gate = GATES[kind]
    asked = gate.commanded(gate.braking_frames(told(kind, phase="off"), 1, 2 * S, 1.0))
    assert (asked.enable, asked.throttle_ratio, asked.brake_ratio) == (False, 0.0, 0.0)


@KINDS
@pytest.mark.parametrize("phase", ["off", "clear", "enable"])
@pytest.mark.parametrize("pedals", [(0.4, 0.0), (0.0, 0.7)])
def test_until_by_wire_is_on_the_tick_presses_nothing(
    kind: str, phase: Phase, pedals: tuple[float, float]
) -> None:
    throttle, brake = pedals
    asked = GATES[kind].commanded(told(kind, phase=phase, throttle=throttle, brake=brake))
    assert (asked.throttle_ratio, asked.brake_ratio) == (0.0, 0.0)
