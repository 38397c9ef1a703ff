import pytest

from vehicle_agent.can.commands import CommandEncoder
from vehicle_agent.can.dbc import layouts
from vehicle_agent.can.handshake import Handshake
from vehicle_agent.can.pacmod_braking import PacmodBraking
from vehicle_agent.config import SteeringColumn
from vehicle_agent.runtime.gate import FRESH_NS, TICK_NS, Gate
from vehicle_agent.signals import Actuation, CanFrame


def commands(counter: int, now_ns: int, throttle: float = 0.3, brake: float = 0.0) -> tuple[CanFrame, ...]:
    encoder = CommandEncoder(SteeringColumn(), wheel_rate_radps=5.0)
    return encoder.frames(
        Actuation(True, "drive", 0.1, throttle, brake), Handshake("on", 0), counter, False, now_ns
    )


def position(frames: tuple[CanFrame, ...], name: str) -> float:
    layout = layouts()[name]
    (data,) = [frame.data for frame in frames if frame.arbitration_id == layout.arbitration_id]
    return layout.unpack(data)["position"]


def test_fresh_commands_pass_unchanged_and_once() -> None:
    gate = Gate(PacmodBraking())
    frames = commands(3, TICK_NS)
    gate.take(frames, TICK_NS)
    assert gate.step(TICK_NS) == frames
    assert gate.step(TICK_NS + 1) == ()


def test_a_tick_that_goes_silent_is_braked_for_after_two_missed_ticks() -> None:
    gate = Gate(PacmodBraking())
    gate.take(commands(3, 0), 0)
    gate.step(0)
    assert gate.step(FRESH_NS) == ()
    braking = gate.step(FRESH_NS + 1)
    assert gate.braking
    assert position(braking, "brake_command") == 1.0
    assert position(braking, "accelerator_command") == 0.0


def test_the_brake_sequence_counts_on_where_the_tick_stopped() -> None:
    gate = Gate(PacmodBraking())
    gate.take(commands(15, 0), 0)
    gate.step(0)
    counters = []
    for i in range(3):
        frames = gate.step(FRESH_NS + 1 + i * TICK_NS)
        values = layouts()["supervisory_command"].unpack(frames[1].data)
        counters.append(values["counter"])
        assert values["counter"] + values["complement"] == 15
        assert values["enable"] == 1
    assert counters == [0, 1, 2]


def test_a_repeated_set_is_stale_and_ends_in_braking() -> None:
    gate = Gate(PacmodBraking())
    frames = commands(3, 0)
    gate.take(frames, 0)
    gate.step(0)
    for i in range(1, 5):
        gate.take(frames, i * TICK_NS)
        last = gate.step(i * TICK_NS)
    assert gate.refused == "the counter stands still"
    assert position(last, "brake_command") == 1.0


@pytest.mark.parametrize("spoil", ["missing", "both_pedals", "complement", "short"])
def test_an_inconsistent_set_is_not_let_through(spoil: str) -> None:
    gate = Gate(PacmodBraking())
    frames = commands(3, 0)
    if spoil == "missing":
        frames = frames[:-1]
    elif spoil == "both_pedals":
        frames = commands(3, 0, throttle=0.2, brake=0.2)
    elif spoil == "complement":
        broken = bytes([frames[1].data[0], *(byte ^ 0xFF for byte in frames[1].data[1:])])
        frames = (frames[0], CanFrame(0, frames[1].arbitration_id, broken), *frames[2:])
    else:
        frames = (*frames[:2], CanFrame(0, frames[2].arbitration_id, b"\x01"), *frames[3:])
    gate.take(frames, 0)
    assert gate.refused
    assert gate.step(0) == ()


def test_the_tick_has_the_vehicle_again_as_soon_as_it_is_back() -> None:
    gate = Gate(PacmodBraking())
    gate.take(commands(3, 0), 0)
    gate.step(0)
    gate.step(10 * TICK_NS)
    frames = commands(7, 11 * TICK_NS)
    gate.take(frames, 11 * TICK_NS)
    assert gate.step(11 * TICK_NS) == frames
    assert not gate.braking


def test_before_the_first_tick_the_gate_says_nothing() -> None:
    assert Gate(PacmodBraking()).step(10 * TICK_NS) == ()
