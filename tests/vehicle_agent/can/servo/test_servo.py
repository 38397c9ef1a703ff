"""The servo codec alone, and what the gate knows of it."""

import itertools
import math

import cantools
import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vehicle_agent.can.braking import CommandSetError
from vehicle_agent.can.dbc import DBC_PATH, SERVO, FrameError, layouts
from vehicle_agent.can.handshake import Handshake
from vehicle_agent.can.servo.braking import ServoBraking
from vehicle_agent.can.servo.codec import ServoState, servo_cart
from vehicle_agent.can.servo.commands import (
    SERVO_COMMANDS,
    SERVO_FRAME_GAP_NS,
    ServoEncoder,
    brake_from_travel,
    crc8,
    duty_from_throttle,
    throttle_from_duty,
    travel_from_brake,
    unpack_checked,
)
from vehicle_agent.can.servo.reports import encoder_ratio
from vehicle_agent.config import Body, ByWire, Profile, SteeringColumn
from vehicle_agent.gate.gate import gate_of
from vehicle_agent.gate.settings import gate_settings
from vehicle_agent.signals import Actuation, CanFrame, VehicleMotion

TICK_NS = 20_000_000
CART = Profile(
    by_wire=ByWire(kind="servo"),
    steering=SteeringColumn(12.0, 0.0),
    body=Body(wheelbase_m=1.65, turn_radius_m_min=2.9),
)
CAN = servo_cart(CART)
DRIVE = Actuation(True, "drive", 0.1, 0.3, 0.0)
OFF = Actuation(False, "park", 0.0, 0.0, 0.0)


def report(name: str, stamp_ns: int, **values: float) -> CanFrame:
    layout = layouts(SERVO)[name]
    return CanFrame(stamp_ns, layout.arbitration_id, layout.pack(values))


def healthy(stamp_ns: int, **flags: float) -> tuple[CanFrame, ...]:
    return (
        report("drive_report", stamp_ns, **{"homed": 1.0, **flags}),
        report("brake_report", stamp_ns, travel=0.55),
        report("throttle_report", stamp_ns, duty=0.0),
        report("steering_report", stamp_ns, shaft_angle=1.2),
        report("encoder_report", stamp_ns, front_left=1.5),
        report("battery_report", stamp_ns, charge=0.8),
    )


class Loop:
    """Ticks the room by hand; `sent` are the values of the last commands."""

    def __init__(self) -> None:
        self.state = CAN.initial()
        self.now_ns = 1_000_000_000
        self.motion: VehicleMotion
        self.frames: tuple[CanFrame, ...] = ()
        self.sent: dict[str, dict[str, float]] = {}

    def tick(self, act: Actuation, frames: tuple[CanFrame, ...] | None = None, **flags: float) -> None:
        self.now_ns += TICK_NS
        heard = healthy(self.now_ns, **flags) if frames is None else frames
        self.motion, self.state = CAN.decode(self.state, heard, self.now_ns)
        self.frames, self.state = CAN.encode(self.state, act, self.now_ns)
        known = layouts(SERVO)
        self.sent = {
            name: unpack_checked(known[name], frame.data)
            for name, frame in zip(SERVO_COMMANDS, self.frames, strict=True)
        }

    def enable(self) -> None:
        self.tick(OFF)
        self.tick(DRIVE)
        self.tick(DRIVE)
        self.tick(DRIVE, armed=1.0)

    def codes(self) -> list[str]:
        return [fault.code for fault in self.motion.faults]


def test_before_the_first_report_the_vehicle_is_neither_ready_nor_driven_nor_faulty() -> None:
    """What is not known is reported as missing by the guard, by the stamp."""
    loop = Loop()
    loop.tick(OFF, frames=())
    assert loop.motion == VehicleMotion(0, 0.0, 0.0, 0.0, 0.0, False, False, False, 0.0, ())


def test_reports_become_the_rear_axles_motion() -> None:
    loop = Loop()
    loop.tick(OFF)
    assert loop.motion.steer_rad == pytest.approx(0.1, abs=1e-3)
    assert loop.motion.speed_mps == pytest.approx(1.5 / encoder_ratio(0.1, 1.65, 0.98), abs=2e-3)
    assert loop.motion.brake_ratio == pytest.approx(0.5)
    assert loop.motion.battery_ratio == pytest.approx(0.8)
    assert loop.motion.ready
    assert not loop.motion.enabled


def test_the_left_front_wheel_is_slower_in_a_left_turn() -> None:
    assert encoder_ratio(0.0, 1.65, 0.98) == 1.0
    assert encoder_ratio(0.3, 1.65, 0.98) < encoder_ratio(-0.3, 1.65, 0.98)


@pytest.mark.parametrize("steer_rad", [0.3, -0.3])
def test_the_left_front_wheel_rolls_on_its_own_circle_around_the_turning_centre(steer_rad: float) -> None:
    radius_m = 1.65 / math.tan(steer_rad)
    wheel_m = math.hypot(radius_m - 0.49, 1.65)
    assert encoder_ratio(steer_rad, 1.65, 0.98) == pytest.approx(wheel_m / abs(radius_m))


def test_a_fault_of_the_module_is_reset_only_while_it_is_not_armed() -> None:
    loop = Loop()
    loop.enable()
    loop.tick(DRIVE, armed=1.0, fault=1.0)
    assert loop.sent["drive_command"]["reset"] == 0.0
    loop.tick(OFF, fault=1.0)
    assert loop.sent["drive_command"]["reset"] == 1.0


@pytest.mark.parametrize(
    ("flags", "ready"), [({}, True), ({"homed": 0.0}, False), ({"stop_pressed": 1.0}, False)]
)
def test_a_cart_is_ready_with_homed_servos_and_a_released_stop_button(
    flags: dict[str, float], ready: bool
) -> None:
    loop = Loop()
    loop.tick(OFF, **flags)
    assert loop.motion.ready == ready


def test_reset_and_arm_are_two_ticks_at_rest_and_then_the_throttle_opens() -> None:
    loop = Loop()
    loop.tick(OFF)
    assert (loop.sent["drive_command"]["arm"], loop.sent["drive_command"]["reset"]) == (0.0, 0.0)
    loop.tick(DRIVE)
    assert (loop.sent["drive_command"]["arm"], loop.sent["drive_command"]["reset"]) == (0.0, 1.0)
    loop.tick(DRIVE)
    assert (loop.sent["drive_command"]["arm"], loop.sent["drive_command"]["reset"]) == (1.0, 0.0)
    assert loop.sent["throttle_command"]["duty"] == 0.0
    loop.tick(DRIVE, armed=1.0)
    assert loop.sent["throttle_command"]["duty"] == pytest.approx(0.15 + 0.3 * 0.75)
    assert loop.sent["steering_command"]["shaft_angle"] == pytest.approx(1.2, abs=1e-3)


def test_nobody_is_asked_before_the_servos_are_homed() -> None:
    loop = Loop()
    for _ in range(100):
        loop.tick(DRIVE, homed=0.0)
    assert loop.state.handshake.phase == "off"
    assert loop.codes() == []


def test_counters_go_on_in_every_frame_and_frames_keep_their_distance() -> None:
    loop = Loop()
    counters = []
    for _ in range(300):
        loop.tick(OFF)
        assert len({values["counter"] for values in loop.sent.values()}) == 1
        counters.append(loop.sent["brake_command"]["counter"])
    assert all((b - a) % 256 == 1 for a, b in itertools.pairwise(counters))
    gaps = [b.stamp_ns - a.stamp_ns for a, b in zip(loop.frames, loop.frames[1:], strict=False)]
    assert gaps == [SERVO_FRAME_GAP_NS] * 3


def test_a_takeover_bars_until_enable_is_asked_for_again() -> None:
    loop = Loop()
    loop.enable()
    loop.tick(DRIVE, armed=0.0, overridden=1.0)
    assert loop.motion.overridden
    for _ in range(50):
        loop.tick(DRIVE)
    assert loop.sent["drive_command"]["arm"] == 0.0
    loop.tick(OFF)
    loop.tick(DRIVE)
    assert loop.sent["drive_command"]["reset"] == 1.0


@pytest.mark.parametrize(
    ("flags", "code"),
    [
        ({"stop_pressed": 1.0}, "emergency_stop_pressed"),
        ({"fault": 1.0}, "bywire_fault"),
        ({"timed_out": 1.0, "armed": 1.0}, "bywire_timeout"),
        ({"armed": 0.0}, "bywire_lost"),
    ],
)
def test_what_the_module_says_is_wrong_becomes_a_fault(flags: dict[str, float], code: str) -> None:
    loop = Loop()
    loop.enable()
    loop.tick(DRIVE, **flags)
    assert code in loop.codes()


def test_silence_becomes_a_fault_for_each_report() -> None:
    loop = Loop()
    loop.enable()
    for _ in range(60):
        loop.tick(DRIVE, frames=())
    names = ("drive", "brake", "throttle", "steering", "encoder")
    assert {f"can_{name}_report_lost" for name in names} <= set(loop.codes())
    assert not loop.motion.enabled


def test_a_cut_frame_is_a_warning_and_changes_nothing() -> None:
    loop = Loop()
    loop.tick(OFF)
    before = loop.motion.speed_mps
    encoder = layouts(SERVO)["encoder_report"]
    cut = CanFrame(loop.now_ns, encoder.arbitration_id, b"\x00")
    loop.tick(OFF, frames=(*healthy(loop.now_ns), cut))
    assert loop.codes() == ["can_frame_malformed"]
    assert loop.motion.speed_mps == before


def test_a_command_that_is_no_number_is_refused() -> None:
    loop = Loop()
    loop.enable()
    with pytest.raises(FrameError):
        CAN.encode(loop.state, Actuation(True, "drive", float("nan"), 0.1, 0.0), loop.now_ns)


def test_the_state_survives_being_written() -> None:
    loop = Loop()
    loop.enable()
    again = msgspec.msgpack.decode(msgspec.msgpack.encode(loop.state), type=ServoState)
    assert again == loop.state
    now_ns = loop.now_ns + TICK_NS
    assert CAN.encode(again, DRIVE, now_ns) == CAN.encode(loop.state, DRIVE, now_ns)


@given(st.floats(0.0, 1.0))
def test_throttle_and_brake_come_back_from_their_actuators(ratio: float) -> None:
    by_wire = CART.by_wire
    assert throttle_from_duty(by_wire, duty_from_throttle(by_wire, ratio)) == pytest.approx(ratio)
    assert brake_from_travel(by_wire, travel_from_brake(by_wire, ratio)) == pytest.approx(ratio)


def test_a_pedal_that_reports_more_or_less_than_its_range_is_at_its_end() -> None:
    by_wire = CART.by_wire
    assert throttle_from_duty(by_wire, by_wire.throttle_duty_max + 0.1) == 1.0
    assert throttle_from_duty(by_wire, by_wire.throttle_duty_min - 0.1) == 0.0
    assert brake_from_travel(by_wire, 1.1) == 1.0
    assert brake_from_travel(by_wire, by_wire.brake_travel_free - 0.1) == 0.0


def test_the_check_byte_is_the_published_crc() -> None:
    assert crc8(b"123456789") == 0x4B


@given(st.data())
def test_frames_are_what_the_dbc_says(data: st.DataObject) -> None:
    database = cantools.database.can.Database()
    database.add_dbc_file(DBC_PATH.with_name(SERVO))
    message = data.draw(st.sampled_from(database.messages))
    raw = {
        s.name: data.draw(st.integers(round(s.minimum / s.scale), round(s.maximum / s.scale)))  # type: ignore[operator]
        for s in message.signals
    }
    layout = layouts(SERVO)[message.name]
    ours = layout.pack({name: value * layout.signals[name].scale for name, value in raw.items()})
    assert ours == message.encode(raw, scaling=False)


# ---------------------------------------------------------------- the gate


def commands(counter: int, now_ns: int, throttle: float = 0.3, brake: float = 0.0) -> tuple[CanFrame, ...]:
    encoder = ServoEncoder(CART.steering, CART.by_wire, 5.0)
    act = Actuation(True, "drive", 0.1, throttle, brake)
    return encoder.frames(act, Handshake("on", 0), counter, False, now_ns)


def test_the_gate_brakes_with_the_servo_when_the_tick_goes_silent() -> None:
    gate, settings = gate_of(CART), gate_settings(CART)
    gate.take_commands(commands(255, 0), 0)
    gate.step(0)
    known = layouts(SERVO)
    for step in range(settings.comfort_steps):
        gate.step(settings.fresh_ns + 1 + step * TICK_NS)
    for step in range(settings.comfort_steps, settings.comfort_steps + 3):
        frames = gate.step(settings.fresh_ns + 1 + step * TICK_NS)
        values = {
            name: unpack_checked(known[name], frame.data)
            for name, frame in zip(SERVO_COMMANDS, frames, strict=True)
        }
        assert values["brake_command"]["travel"] == 1.0
        assert values["throttle_command"]["duty"] == 0.0
        assert values["drive_command"]["arm"] == 1.0
        assert {value["counter"] for value in values.values()} == {step}


@pytest.mark.parametrize("spoil", ["missing", "both", "check", "counter"])
def test_an_inconsistent_set_is_not_let_through(spoil: str) -> None:
    frames = commands(3, 0)
    if spoil == "missing":
        frames = frames[:-1]
    elif spoil == "both":
        frames = commands(3, 0, throttle=0.2, brake=0.2)
    elif spoil == "check":
        bad = frames[1].data[:-1] + bytes([frames[1].data[-1] ^ 1])
        frames = (frames[0], CanFrame(0, frames[1].arbitration_id, bad), *frames[2:])
    else:
        frames = (frames[0], commands(4, 0)[1], *frames[2:])
    with pytest.raises(CommandSetError):
        ServoBraking().commanded(frames)
    gate = gate_of(CART)
    gate.take_commands(frames, 0)
    assert gate.refused
    assert gate.step(0) == ()


def test_an_encoder_that_leaps_is_believed_when_a_second_report_agrees() -> None:
    loop = Loop()
    loop.tick(OFF)
    before_mps = loop.motion.speed_mps
    loop.tick(OFF, (report("encoder_report", loop.now_ns + TICK_NS, front_left=16.0),))
    assert loop.motion.speed_mps == pytest.approx(before_mps)
    assert loop.codes() == ["can_frame_malformed"]
    loop.tick(OFF, (report("encoder_report", loop.now_ns + TICK_NS, front_left=16.1),))
    assert loop.motion.speed_mps > 10.0
