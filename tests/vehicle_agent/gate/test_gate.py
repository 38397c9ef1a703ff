"""The gate: what passes, what is refused, when it brakes, and what it takes to let go."""

from typing import Any

import numpy as np
import pytest

from vehicle_agent.can.by_wire import braking_of, codec_of, motion_reports_of
from vehicle_agent.can.dbc import layouts
from vehicle_agent.can.handshake import Handshake
from vehicle_agent.can.pacmod.commands import CommandEncoder
from vehicle_agent.config import Profile, SteeringColumn
from vehicle_agent.gate.gate import Gate
from vehicle_agent.gate.settings import GateSettings, gate_settings
from vehicle_agent.signals import (
    PEDESTRIAN,
    Actuation,
    CanFrame,
    ObstaclePercept,
    TrackPercept,
    VehicleMotion,
)

PROFILE = Profile()
SETTINGS: GateSettings = gate_settings(PROFILE)
TICK_NS = 20_000_000
SILENT_NS = SETTINGS.fresh_ns + 1
SILENT_FOR_EVER_NS = 10_000_000_000


class Reporting:
    """Reports of a module that are just what the test wants."""

    def __init__(self) -> None:
        self.motion = VehicleMotion(0, 2.0, 0.0, 0.0, 0.0, True, False, True, 0.9)

    def decode(self, frames: tuple[CanFrame, ...], now_ns: int) -> VehicleMotion:
        return self.motion


class Bench:
    """A gate, its clock and a tick that may say anything."""

    def __init__(self) -> None:
        self.reporting = Reporting()
        self.gate = Gate(braking_of(PROFILE), self.reporting, SETTINGS)
        self.now_ns = 0
        self.counter = 0

    def report(self, speed_mps: float = 2.0, steer_rad: float = 0.0, enabled: bool = True) -> None:
        self.reporting.motion = VehicleMotion(
            self.now_ns, speed_mps, steer_rad, 0.0, 0.0, enabled, False, True, 0.9
        )
        self.gate.take_reports((), self.now_ns)

    def tick(self, tells: bool = True, **changes: Any) -> tuple[CanFrame, ...]:
        """20 ms on: a set of the tick, if it tells one, and what the gate sends."""
        self.now_ns += TICK_NS
        if tells:
            self.counter = (self.counter + 1) % 16
            self.gate.take_commands(commands(self.counter, self.now_ns, **changes), self.now_ns)
        return self.gate.step(self.now_ns)

    def drive(self, ticks: int = 50, **changes: Any) -> None:
        for _ in range(ticks):
            self.report(steer_rad=changes.get("steer", 0.0))
            assert self.tick(**changes)
        assert not self.gate.braking

    def silence(self) -> tuple[CanFrame, ...]:
        """Until the gate brakes by itself."""
        for _ in range(4):
            frames = self.tick(tells=False)
        assert self.gate.braking
        return frames


def commands(
    counter: int,
    now_ns: int,
    throttle: float = 0.3,
    brake: float = 0.0,
    steer: float = 0.0,
    phase: Any = "on",
) -> tuple[CanFrame, ...]:
    encoder = CommandEncoder(SteeringColumn(), wheel_rate_radps=5.0)
    act = Actuation(True, "drive", steer, throttle, brake)
    return encoder.frames(act, Handshake(phase, 0), counter, False, now_ns)


def position(frames: tuple[CanFrame, ...], name: str) -> float:
    layout = layouts()[name]
    (data,) = [frame.data for frame in frames if frame.arbitration_id == layout.arbitration_id]
    return layout.unpack(data)["position"]


def brake_of(frames: tuple[CanFrame, ...]) -> float:
    assert position(frames, "accelerator_command") == 0.0
    return position(frames, "brake_command")


def a_gate() -> Gate:
    return Gate(braking_of(PROFILE), motion_reports_of(PROFILE), SETTINGS)


def test_fresh_commands_pass_unchanged_and_once() -> None:
    gate = a_gate()
    frames = commands(3, TICK_NS)
    gate.take_commands(frames, TICK_NS)
    assert gate.step(TICK_NS) == frames
    assert gate.step(TICK_NS + 1) == ()


def test_a_gate_that_starts_under_way_does_not_take_its_first_step_for_a_jump_of_the_clock() -> None:
    gate, now_ns = a_gate(), 3_600_000_000_000
    frames = commands(3, now_ns)
    gate.take_commands(frames, now_ns)
    assert gate.step(now_ns) == frames
    assert not gate.braking


def test_before_the_first_tick_the_gate_sends_nothing() -> None:
    assert a_gate().step(10 * TICK_NS) == ()


def test_the_gate_brakes_after_two_missed_ticks() -> None:
    bench = Bench()
    bench.drive()
    assert bench.tick(tells=False) == ()
    assert bench.tick(tells=False) == ()
    assert brake_of(bench.tick(tells=False)) == pytest.approx(SETTINGS.comfort_ratio, abs=1e-3)
    assert bench.gate.braking == "the tick is silent"


@pytest.mark.parametrize("lost", [1, 2])
def test_one_or_two_lost_sets_do_no_harm(lost: int) -> None:
    bench = Bench()
    bench.drive()
    for _ in range(lost):
        bench.tick(tells=False)
        bench.counter += 1
    assert bench.tick()
    assert not bench.gate.braking


def test_the_brake_sequence_is_comfortable_first_then_full_and_keeps_counting() -> None:
    bench = Bench()
    bench.drive()
    last = bench.counter
    bench.tick(tells=False), bench.tick(tells=False)
    brakes, counters = [], []
    for _ in range(10):
        frames = bench.tick(tells=False)
        brakes.append(brake_of(frames))
        values = layouts()["supervisory_command"].unpack(frames[1].data)
        counters.append(values["counter"])
        assert values["counter"] + values["complement"] == 15
        assert values["enable"] == 1, "by-wire is kept alive: without it nobody could brake"
    assert counters == [(last + step) % 16 for step in range(1, 11)]
    assert brakes[:5] == pytest.approx([SETTINGS.comfort_ratio] * 5, abs=1e-3)
    assert brakes[5:] == [1.0] * 5


def test_the_steering_is_held_while_the_gate_brakes() -> None:
    bench = Bench()
    bench.drive(steer=0.005)
    frames = bench.silence()
    assert frames[5].data[1:] == commands(0, 0, steer=0.005)[5].data[1:]


def test_a_repeated_set_is_stale_and_ends_in_braking() -> None:
    bench = Bench()
    bench.drive()
    for _ in range(4):
        bench.now_ns += TICK_NS
        bench.gate.take_commands(commands(bench.counter, bench.now_ns), bench.now_ns)
        last = bench.gate.step(bench.now_ns)
    assert bench.gate.braking == "the counter stands still"
    assert brake_of(last) > 0.0


@pytest.mark.parametrize(
    ("late_ns", "reason"),
    [(60_000_000, "the set is stale"), (-60_000_000, "the set is stamped in the future")],
)
def test_stale_and_future_sets_are_refused_and_end_in_braking(late_ns: int, reason: str) -> None:
    bench = Bench()
    bench.drive()
    for _ in range(4):
        bench.now_ns += TICK_NS
        bench.counter += 1
        bench.gate.take_commands(commands(bench.counter % 16, bench.now_ns - late_ns), bench.now_ns)
        bench.gate.step(bench.now_ns)
    assert bench.gate.braking == reason


@pytest.mark.parametrize(("leap", "refused"), [(3, ""), (4, "the set is out of order")])
def test_a_counter_that_leaps_over_more_sets_than_may_be_lost_is_refused(leap: int, refused: str) -> None:
    bench = Bench()
    bench.drive()
    bench.now_ns += TICK_NS
    bench.gate.take_commands(commands((bench.counter + leap) % 16, bench.now_ns), bench.now_ns)
    assert bench.gate.refused == refused


def test_an_older_set_is_out_of_order() -> None:
    bench = Bench()
    bench.drive()
    bench.now_ns += TICK_NS
    bench.gate.take_commands(commands((bench.counter - 1) % 16, bench.now_ns), bench.now_ns)
    assert bench.gate.refused == "the set is out of order"


@pytest.mark.parametrize(
    "spoil", ["missing", "both_pedals", "complement", "short", "angle", "jump", "enable"]
)
def test_an_inconsistent_set_is_refused(spoil: str) -> None:
    bench = Bench()
    bench.drive(3)
    bench.now_ns += TICK_NS
    counter = bench.counter + 1
    frames = commands(counter, bench.now_ns)
    if spoil == "missing":
        frames = frames[:-1]
    elif spoil == "both_pedals":
        frames = commands(counter, bench.now_ns, throttle=0.2, brake=0.2)
    elif spoil == "complement":
        broken = bytes([frames[1].data[0], *(byte ^ 0xFF for byte in frames[1].data[1:])])
        frames = (frames[0], CanFrame(0, frames[1].arbitration_id, broken), *frames[2:])
    elif spoil == "angle":
        frames = commands(counter, bench.now_ns, steer=0.6)
    elif spoil == "jump":
        frames = commands(counter, bench.now_ns, steer=0.1)
    elif spoil == "enable":
        off = commands(counter, bench.now_ns, phase="off")
        frames = (*frames[:3], off[3], *frames[4:])
    else:
        frames = (*frames[:2], CanFrame(0, frames[2].arbitration_id, b"\x01"), *frames[3:])
    bench.gate.take_commands(frames, bench.now_ns)
    assert bench.gate.refused
    assert bench.gate.step(bench.now_ns) == ()


def test_a_tick_that_comes_back_waits_for_a_new_by_wire_request() -> None:
    bench = Bench()
    bench.drive()
    bench.silence()
    for _ in range(50):
        bench.report(speed_mps=0.0)
        assert brake_of(bench.tick()) > 0.0, "held at standstill, whatever the tick says"
    bench.tick(phase="off")
    assert brake_of(bench.tick(phase="clear")) == 1.0, "until the enable rises the brake stays on"
    assert bench.tick(phase="enable") == commands(bench.counter, bench.now_ns, phase="enable")
    assert not bench.gate.braking


def test_each_braking_waits_for_a_request_of_its_own() -> None:
    bench = Bench()
    bench.drive()
    for _ in range(2):
        bench.silence()
        bench.report(speed_mps=0.0)
        bench.tick()
        assert bench.gate.braking, "the request that ended an earlier braking does not count again"
        for phase in ("off", "clear", "enable", "on"):
            bench.report(speed_mps=0.0)
            bench.tick(phase=phase)
        assert not bench.gate.braking


def test_the_brake_is_not_released_while_the_vehicle_rolls() -> None:
    bench = Bench()
    bench.drive()
    bench.silence()
    bench.report(speed_mps=1.0)
    bench.tick(phase="off"), bench.tick(phase="clear")
    assert brake_of(bench.tick(phase="enable")) > 0.0


def test_an_enable_that_fell_while_the_vehicle_rolled_does_not_count_when_it_stands() -> None:
    bench = Bench()
    bench.drive()
    bench.silence()
    for speed_mps, phase in ((1.0, "off"), (0.0, "enable")):
        bench.report(speed_mps=speed_mps)
        bench.tick(phase=phase)
    assert bench.gate.braking
    for phase in ("off", "clear", "enable"):
        bench.report(speed_mps=0.0)
        bench.tick(phase=phase)
    assert not bench.gate.braking


def test_without_by_wire_a_silent_tick_causes_no_braking() -> None:
    bench = Bench()
    bench.drive(3)
    bench.tick(phase="off")
    for _ in range(5):
        assert bench.tick(tells=False) == ()


def test_the_gate_brakes_when_the_clock_goes_back() -> None:
    bench = Bench()
    bench.drive()
    bench.now_ns -= 500_000_000
    bench.tick()
    assert bench.gate.braking == "the clock jumped"


def test_the_gate_brakes_when_the_clock_jumps_ahead_though_all_stamps_agree() -> None:
    bench = Bench()
    bench.drive()
    bench.now_ns += 200_000_000
    bench.report()
    assert brake_of(bench.tick()) > 0.0
    assert bench.gate.braking == "the clock jumped"


def test_the_gate_brakes_for_stuck_steering_within_a_few_reports() -> None:
    bench = Bench()
    bench.drive(60)
    steer, ticks = 0.0, 0
    while not bench.gate.braking:
        steer, ticks = steer + 0.005, ticks + 1
        bench.report(steer_rad=0.0)
        bench.tick(steer=steer)
        assert ticks < 40
    assert bench.gate.braking == "the steering does not follow"
    delay_ticks = SETTINGS.steer_delay_s / 0.02
    apart_rad = 0.005 * (ticks - delay_ticks)
    assert 0.03 < apart_rad < 0.08


def test_steering_that_follows_late_is_no_fault() -> None:
    bench = Bench()
    bench.drive(60)
    angles = [0.0] * 14
    for number in range(300):
        angles.append(0.3 * float(np.sin(0.03 * number)))
        bench.report(steer_rad=angles[-15])
        bench.tick(steer=angles[-1])
    assert not bench.gate.braking


def test_a_wheel_that_turns_a_little_slower_than_commanded_is_no_fault() -> None:
    bench = Bench()
    bench.drive(60)
    distance_m, wheel = [0.0] * 14, 0.0
    for number in range(120):
        distance_m.append(
            min(distance_m[-1] + 0.012, 0.4) if number < 60 else max(distance_m[-1] - 0.012, -0.4)
        )
        wheel += min(max(distance_m[-15] - wheel, -0.0104), 0.0104)
        bench.report(steer_rad=wheel)
        bench.tick(steer=distance_m[-1])
    assert not bench.gate.braking


def test_the_gate_brakes_for_an_excessive_speed_that_is_reported_twice() -> None:
    bench = Bench()
    bench.drive()
    bench.report(speed_mps=9.0)
    bench.tick()
    assert not bench.gate.braking
    bench.report(speed_mps=9.0)
    bench.tick()
    assert bench.gate.braking == "too fast"


def a_wall(x_m: float, stamp_ns: int) -> ObstaclePercept:
    return ObstaclePercept(stamp_ns, np.array([[x_m, 0.2]]), np.ones(1), 100)


def a_person(
    x_m: float, stamp_ns: int, y_m: float = 0.0, velocity: tuple[float, float] = (0.0, 0.0)
) -> TrackPercept:
    return TrackPercept(
        stamp_ns,
        np.ones(1, np.int64),
        np.array([PEDESTRIAN]),
        np.array([[x_m, y_m, 0.0]]),
        np.array([velocity]),
        np.full((1, 2), 0.5),
    )


@pytest.mark.parametrize("look", [a_wall, a_person])
def test_the_gate_brakes_fully_for_an_obstacle_ahead_that_the_tick_ignores(look: Any) -> None:
    bench = Bench()
    bench.drive()
    bench.gate.take_percept(look(PROFILE.body.front_overhang_m + 0.8, bench.now_ns))
    for _ in range(3):
        frames = bench.tick()
    assert bench.gate.braking == "something before the bumper"
    assert brake_of(frames) == 1.0


def test_the_gate_does_not_brake_for_a_person_who_is_leaving_the_way() -> None:
    bench = Bench()
    bench.drive()
    x_m = PROFILE.body.front_overhang_m + 0.8
    bench.gate.take_percept(a_person(x_m, bench.now_ns, 0.7, (0.0, 2.0)))
    for _ in range(3):
        bench.report()
        bench.tick()
    assert not bench.gate.braking
    bench.gate.take_percept(a_person(x_m, bench.now_ns, 0.7, (0.0, -2.0)))
    for _ in range(3):
        bench.tick()
    assert bench.gate.braking == "something before the bumper"


def a_spoiled_wall(x_m: float, stamp_ns: int) -> ObstaclePercept:
    cells = np.array([[np.nan, 0.0], [np.inf, 0.0], [x_m, 0.2]])
    return ObstaclePercept(stamp_ns, cells, np.ones(3), 100)


def a_spoiled_person(x_m: float, stamp_ns: int) -> TrackPercept:
    return TrackPercept(
        stamp_ns,
        np.arange(4),
        np.full(4, PEDESTRIAN),
        np.array([[np.nan, 0.0, 0.0], [9.0, 0.0, np.inf], [9.0, 0.0, 0.0], [x_m, 0.0, 0.0]]),
        np.array([[0.0, 0.0], [0.0, 0.0], [np.nan, 0.0], [0.0, 0.0]]),
        np.full((4, 2), 0.5),
    )


@pytest.mark.parametrize("look", [a_spoiled_wall, a_spoiled_person])
def test_values_that_are_not_finite_are_skipped_and_the_others_still_count(look: Any) -> None:
    bench = Bench()
    bench.drive()
    bench.gate.take_percept(look(PROFILE.body.front_overhang_m + 0.8, bench.now_ns))
    for _ in range(3):
        frames = bench.tick()
    assert bench.gate.braking == "something before the bumper"
    assert brake_of(frames) == 1.0


def test_an_obstacle_that_the_tick_brakes_for_is_left_to_the_tick() -> None:
    bench = Bench()
    bench.drive()
    bench.gate.take_percept(a_wall(PROFILE.body.front_overhang_m + 0.8, bench.now_ns))
    for _ in range(5):
        bench.report()
        bench.tick(throttle=0.0, brake=0.5)
    assert not bench.gate.braking


def test_the_gate_brakes_when_the_module_is_silent() -> None:
    bench = Bench()
    bench.drive()
    silent_ns = 0
    while not bench.gate.braking:
        bench.tick()
        silent_ns += TICK_NS
        assert silent_ns < SILENT_FOR_EVER_NS, "the gate never brakes"
    assert bench.gate.braking == "the module is silent"
    assert silent_ns <= 120_000_000


def test_the_gate_reports_braking_to_the_tick_and_its_end_once() -> None:
    bench = Bench()
    bench.drive()
    assert bench.gate.report_frames(bench.now_ns) == ()
    bench.silence()
    codec = codec_of(PROFILE)
    motion, _ = codec.decode(codec.initial(), bench.gate.report_frames(bench.now_ns), bench.now_ns)
    assert [fault.code for fault in motion.faults] == ["gate_braking_tick_late"]
    bench.report(speed_mps=0.0)
    bench.tick(phase="off"), bench.tick(phase="clear"), bench.tick(phase="enable")
    released = bench.gate.report_frames(bench.now_ns)
    assert len(released) == 1, (
        "the tick is told, for it would wait for the end of the report's time otherwise"
    )
    motion, _ = codec.decode(codec.initial(), released, bench.now_ns)
    assert motion.faults == ()
    assert bench.gate.report_frames(bench.now_ns) == ()
