"""The can room alone: frames in, motion out; actuation in, frames out."""

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vehicle_agent.can.dbc import FrameError, layouts
from vehicle_agent.can.module_state import FAULT_SHOWN_NS
from vehicle_agent.can.pacmod.codec import CanState, Pacmod
from vehicle_agent.signals import Actuation, CanFrame, Gear, VehicleMotion

TICK_NS = 20_000_000
CAN = Pacmod()
DRIVE = Actuation(True, "drive", 0.1, 0.3, 0.0)
BRAKE = Actuation(True, "drive", 0.0, 0.0, 0.6)
OFF = Actuation(False, "park", 0.0, 0.0, 0.0)


def report(name: str, stamp_ns: int, **values: float) -> CanFrame:
    layout = layouts()[name]
    return CanFrame(stamp_ns, layout.arbitration_id, layout.pack(values))


def healthy(stamp_ns: int, **flags: float) -> tuple[CanFrame, ...]:
    enabled = {"enabled": flags.get("enabled", 0)}
    return (
        report("global_report", stamp_ns, **flags),
        report("system_report", stamp_ns, ready=1),
        report("accelerator_report", stamp_ns, output=0.25, **enabled),
        report("brake_report", stamp_ns, output=0.5, **enabled),
        report("shift_report", stamp_ns, output=3, **enabled),
        report("steering_report", stamp_ns, output=2.0, **enabled),
        report("speed_report", stamp_ns, speed=1.5),
        report("stop_button_report", stamp_ns),
        report("energy_report", stamp_ns, charge=0.8),
    )


class Loop:
    """Ticks the room by hand; remembers the last motion and the frames by name."""

    def __init__(self) -> None:
        self.state = CAN.initial()
        self.now_ns = 1_000_000_000
        self.motion: VehicleMotion
        self.sent: dict[str, dict[str, float]] = {}
        self.frames: tuple[CanFrame, ...] = ()

    def tick(self, act: Actuation, frames: tuple[CanFrame, ...] | None = None, **flags: float) -> None:
        self.now_ns += TICK_NS
        heard = healthy(self.now_ns, **flags) if frames is None else frames
        self.motion, self.state = CAN.decode(self.state, heard, self.now_ns)
        self.frames, self.state = CAN.encode(self.state, act, self.now_ns)
        names = {layout.arbitration_id: layout for layout in layouts().values()}
        self.sent = {
            names[f.arbitration_id].name: names[f.arbitration_id].unpack(f.data) for f in self.frames
        }

    def enable(self) -> None:
        self.tick(OFF)
        self.tick(DRIVE)
        self.tick(DRIVE)
        self.tick(DRIVE, enabled=1)


def test_before_the_first_report_the_vehicle_is_neither_ready_nor_driven_nor_faulty() -> None:
    """What is not known is reported as missing by the guard, by the stamp."""
    loop = Loop()
    loop.tick(OFF, frames=())
    assert loop.motion == VehicleMotion(0, 0.0, 0.0, 0.0, 0.0, False, False, False, 0.0, ())


@pytest.mark.parametrize(("gear", "code"), [("park", 0), ("reverse", 1), ("neutral", 2), ("drive", 3)])
def test_gears_have_the_modules_own_numbers(gear: Gear, code: int) -> None:
    loop = Loop()
    loop.enable()
    loop.tick(msgspec.structs.replace(DRIVE, gear=gear), enabled=1)
    assert loop.sent["shift_command"]["gear"] == code


def test_reports_become_si_units_and_the_front_wheel_angle() -> None:
    loop = Loop()
    loop.tick(OFF)
    motion = loop.motion
    assert motion.speed_mps == pytest.approx(1.5)
    assert motion.steer_rad == pytest.approx(0.0944, abs=1e-4)
    assert (motion.throttle_ratio, motion.brake_ratio) == pytest.approx((0.25, 0.5))
    assert motion.battery_ratio == pytest.approx(0.8)
    assert motion.stamp_ns == loop.now_ns
    assert motion.ready
    assert not motion.enabled


def test_every_tick_sends_all_nine_commands_half_a_millisecond_apart() -> None:
    loop = Loop()
    loop.tick(OFF)
    driving, signalling = [0x80, 0x81, 0x100, 0x104, 0x128, 0x12C], [0x130, 0x11C, 0x118]
    assert [f.arbitration_id for f in loop.frames] == driving + signalling
    assert [f.stamp_ns - loop.now_ns for f in loop.frames] == [500_000 * i for i in range(9)]


def test_the_counter_grows_by_one_a_tick_and_the_complement_fills_it_to_fifteen() -> None:
    loop = Loop()
    counters = []
    for _ in range(40):
        loop.tick(OFF)
        counters.append(loop.sent["global_command"]["counter"])
        for command in ("global_command", "supervisory_command"):
            assert loop.sent[command]["counter"] + loop.sent[command]["complement"] == 15
        assert loop.sent["supervisory_command"]["counter"] == counters[-1]
    assert counters == [i % 16 for i in range(40)]


def test_overrides_are_cleared_one_tick_before_enabling_and_never_in_the_same() -> None:
    loop = Loop()
    loop.tick(OFF)
    loop.tick(DRIVE)
    assert loop.sent["global_command"]["clear_overrides"] == 1
    assert loop.sent["supervisory_command"]["enable"] == 0
    loop.tick(DRIVE)
    assert loop.sent["global_command"]["clear_overrides"] == 0
    assert loop.sent["supervisory_command"]["enable"] == 1


@pytest.mark.parametrize("act", [DRIVE, BRAKE])
def test_pedals_are_commanded_zero_until_the_module_says_enabled(act: Actuation) -> None:
    loop = Loop()
    for flags in ({}, {}, {}, {}):
        loop.tick(act, **flags)
        assert loop.sent["accelerator_command"]["position"] == 0.0
        assert loop.sent["brake_command"]["position"] == 0.0
    loop.tick(act, enabled=1)
    assert loop.sent["accelerator_command"]["position"] == pytest.approx(act.throttle_ratio)
    assert loop.sent["brake_command"]["position"] == pytest.approx(act.brake_ratio)


def test_nothing_is_enabled_that_the_guard_does_not_want() -> None:
    loop = Loop()
    loop.enable()
    loop.tick(OFF, enabled=1)
    assert all(values.get("enable", 0) == 0 for values in loop.sent.values())


def test_after_a_takeover_enable_must_be_dropped_and_asked_for_again() -> None:
    loop = Loop()
    loop.enable()
    loop.tick(DRIVE, override_active=1)
    assert loop.motion.overridden
    for _ in range(50):
        loop.tick(DRIVE)
        assert loop.sent["supervisory_command"]["enable"] == 0
        assert loop.sent["global_command"]["clear_overrides"] == 0
        assert loop.motion.overridden
    loop.enable()
    assert loop.motion.enabled
    assert not loop.motion.overridden


def test_a_module_that_drops_out_by_itself_is_asked_again_at_once() -> None:
    loop = Loop()
    loop.enable()
    loop.tick(BRAKE, computer_timeout=1)
    codes = {fault.code: fault.severity for fault in loop.motion.faults}
    assert codes == {"bywire_timeout": "stop", "bywire_lost": "stop"}
    assert loop.sent["global_command"]["clear_overrides"] == 1
    loop.tick(BRAKE)
    assert loop.sent["supervisory_command"]["enable"] == 1


def test_a_module_that_never_answers_is_a_fault() -> None:
    loop = Loop()
    for _ in range(80):
        loop.tick(DRIVE)
    assert "bywire_refuses_enable" in {fault.code for fault in loop.motion.faults}


def test_missing_reports_are_faults_that_keep_the_time_they_began() -> None:
    loop = Loop()
    for _ in range(60):
        loop.tick(OFF)
    began_ns = 0
    for _ in range(20):
        loop.tick(OFF, frames=tuple(f for f in healthy(loop.now_ns + TICK_NS) if f.arbitration_id != 0x400))
        lost = [f for f in loop.motion.faults if f.code == "can_speed_report_lost"]
        if lost and not began_ns:
            began_ns = loop.now_ns
        if lost:
            assert lost[0].since_ns == began_ns
    assert began_ns
    assert [f.code for f in loop.motion.faults] == ["can_speed_report_lost"]


def test_silence_of_the_module_is_not_enabled() -> None:
    loop = Loop()
    loop.enable()
    for _ in range(10):
        loop.tick(DRIVE, frames=())
    assert not loop.motion.enabled


def test_a_cut_frame_is_a_warning_and_changes_nothing() -> None:
    loop = Loop()
    loop.tick(OFF)
    loop.tick(OFF, frames=(*healthy(loop.now_ns + TICK_NS), CanFrame(loop.now_ns + TICK_NS, 0x400, b"\x01")))
    assert loop.motion.speed_mps == pytest.approx(1.5)
    assert [(f.code, f.severity) for f in loop.motion.faults] == [("can_frame_malformed", "warning")]


def test_a_speed_that_leaps_is_believed_when_a_second_report_agrees() -> None:
    loop = Loop()
    loop.tick(OFF)
    for lie_mps in (36.0, -20.0, 36.0):
        loop.tick(OFF, (report("speed_report", loop.now_ns + TICK_NS, speed=lie_mps),))
        assert loop.motion.speed_mps == pytest.approx(1.5), "one flipped bit is nothing to brake for"
        assert [fault.code for fault in loop.motion.faults] == ["can_frame_malformed"]
    loop.tick(OFF, (report("speed_report", loop.now_ns + TICK_NS, speed=1.8),))
    assert loop.motion.speed_mps == pytest.approx(1.8)
    for _ in range(2):
        loop.tick(OFF, (report("speed_report", loop.now_ns + TICK_NS, speed=9.0),))
    assert loop.motion.speed_mps == pytest.approx(9.0), "wheels that slip, or a missed second, are real"


def test_the_stop_button_is_a_stop_fault() -> None:
    loop = Loop()
    pressed = (*healthy(loop.now_ns + TICK_NS), report("stop_button_report", loop.now_ns, pressed=1))
    loop.tick(OFF, frames=pressed)
    assert [(f.code, f.severity) for f in loop.motion.faults] == [("emergency_stop_pressed", "stop")]


@pytest.mark.parametrize("field", ["steer_rad", "throttle_ratio", "brake_ratio"])
def test_a_command_that_is_not_a_number_ends_the_frames(field: str) -> None:
    loop = Loop()
    loop.enable()
    with pytest.raises(FrameError):
        loop.tick(msgspec.structs.replace(DRIVE, **{field: float("nan")}), enabled=1)


ACTS = st.builds(
    Actuation,
    st.booleans(),
    st.sampled_from(["park", "reverse", "neutral", "drive"]),
    st.floats(-0.5, 0.5),
    st.floats(0.0, 1.0),
    st.floats(0.0, 1.0),
)
FLAGS = st.fixed_dictionaries({}, optional={"enabled": st.just(1), "override_active": st.just(1)})


@given(st.lists(st.tuples(ACTS, FLAGS), max_size=60))
def test_no_history_enables_with_a_pedal_down_or_commands_another_tick_s_pedals(
    history: list[tuple[Actuation, dict[str, int]]],
) -> None:
    loop = Loop()
    enabled_before = False
    for act, flags in history:
        loop.tick(act, **flags)
        enable = loop.sent["supervisory_command"]["enable"] == 1
        pedals = (loop.sent["accelerator_command"]["position"], loop.sent["brake_command"]["position"])
        if enable and not enabled_before:
            assert pedals == (0.0, 0.0)
        if any(pedals):
            assert pedals == pytest.approx((act.throttle_ratio, act.brake_ratio), abs=0.00051)
        assert not (enable and loop.sent["global_command"]["clear_overrides"])
        assert act.enable or not enable
        enabled_before = enable


@given(st.lists(st.tuples(ACTS, FLAGS), min_size=2, max_size=30), st.integers(1, 29))
def test_a_state_restored_in_the_middle_continues_identically(
    history: list[tuple[Actuation, dict[str, int]]], cut: int
) -> None:
    loop, other = Loop(), Loop()
    for i, (act, flags) in enumerate(history):
        if i == cut:
            other.state = msgspec.msgpack.decode(msgspec.msgpack.encode(other.state), type=CanState)
        loop.tick(act, **flags)
        other.tick(act, **flags)
        assert (loop.frames, loop.motion, loop.state) == (other.frames, other.motion, other.state)


def test_a_leap_is_believed_at_the_second_report_though_the_clock_went_back() -> None:
    loop = Loop()
    loop.tick(OFF)
    loop.now_ns -= 500_000_000
    for _ in range(2):
        loop.tick(OFF, (report("speed_report", loop.now_ns + TICK_NS, speed=12.0),))
    assert loop.motion.speed_mps == pytest.approx(12.0)


@pytest.mark.parametrize(
    ("name", "flag", "code"),
    [
        ("global_report", "fault_active", "bywire_fault"),
        ("global_report", "config_fault", "bywire_fault"),
        ("system_report", "disable_all", "bywire_fault"),
        ("global_report", "computer_timeout", "bywire_timeout"),
        ("global_report", "subsystem_timeout", "bywire_timeout"),
    ],
)
def test_each_of_the_modules_own_flags_is_a_fault_until_a_second_after_it(
    name: str, flag: str, code: str
) -> None:
    loop = Loop()
    loop.tick(OFF)
    loop.tick(OFF, (*healthy(loop.now_ns + TICK_NS), report(name, loop.now_ns + TICK_NS, **{flag: 1})))
    assert [fault.code for fault in loop.motion.faults] == [code]
    loop.now_ns += FAULT_SHOWN_NS
    loop.tick(OFF)
    assert loop.motion.faults == ()


@pytest.mark.parametrize(("disabled", "ready"), [(0, True), (1, False)])
def test_a_module_that_has_disabled_its_systems_is_not_ready(disabled: int, ready: bool) -> None:
    loop = Loop()
    system = report("system_report", loop.now_ns, ready=1, disable_all=disabled)
    loop.tick(OFF, (*healthy(loop.now_ns), system))
    assert loop.motion.ready == ready


def test_a_fault_of_the_module_is_cleared_only_while_by_wire_is_off() -> None:
    loop = Loop()
    loop.enable()
    loop.tick(DRIVE, enabled=1, fault_active=1)
    assert loop.sent["global_command"]["clear_faults"] == 0
    loop.tick(OFF, fault_active=1)
    assert loop.sent["global_command"]["clear_faults"] == 1
    loop.tick(OFF)
    assert loop.sent["global_command"]["clear_faults"] == 0


def test_a_speed_that_is_marked_as_not_available_changes_nothing() -> None:
    loop = Loop()
    loop.tick(OFF)
    stamp_ns = loop.motion.stamp_ns
    raw = CanFrame(loop.now_ns + TICK_NS, 0x400, b"\x7f\xff")
    loop.tick(OFF, (raw,))
    assert loop.motion.speed_mps == pytest.approx(1.5)
    assert loop.motion.stamp_ns == stamp_ns, "and grows older"
    assert [fault.code for fault in loop.motion.faults] == ["can_frame_malformed"]


def test_a_first_speed_report_that_is_marked_as_not_available_is_no_speed() -> None:
    loop = Loop()
    loop.tick(OFF, (CanFrame(loop.now_ns + TICK_NS, 0x400, b"\x7f\xff"),))
    assert (loop.motion.speed_mps, loop.motion.stamp_ns) == (0.0, 0)


def test_frames_of_other_modules_are_ignored() -> None:
    loop = Loop()
    loop.tick(OFF, (*healthy(loop.now_ns + TICK_NS), CanFrame(loop.now_ns, 0x7FF, b"\x01")))
    assert loop.motion.faults == ()
