"""The simulated servo cart, driven over CAN by its codec."""

import dataclasses
from pathlib import Path

import pytest

from simulator.ecus.safety_driver import HANDS_OFF, SafetyDriver
from simulator.ecus.servo_cart import ServoModule
from simulator.fleet import STEP_NS
from tests.simulator.ecus.can_driver import (
    BRAKE,
    RELEASE,
    ROLL,
    CanDriver,
)
from vehicle_agent.can.dbc import SERVO, layouts
from vehicle_agent.can.servo.commands import SERVO_COUNTER_STEPS, checked_frame
from vehicle_agent.config import load_profile
from vehicle_agent.signals import Actuation, CanFrame

PROFILES = Path(__file__).resolve().parents[3] / "vehicle_agent" / "profiles"


def a_cart() -> CanDriver:
    return CanDriver(load_profile(PROFILES / "nus-cart.toml"))


def test_the_cart_is_homed_armed_and_drives() -> None:
    driver = a_cart()
    assert isinstance(driver.module, ServoModule)
    driver.run(0.3, ROLL)
    assert not driver.motion.enabled
    driver.run(3.0, ROLL)
    assert driver.motion.enabled
    assert driver.motion.speed_mps > 0.8
    assert not driver.motion.faults
    watch = driver.module.watch
    assert (watch.crowded, watch.miscounted, watch.malformed) == (0, 0, 0)


def test_steering_and_speed_come_back_as_they_are() -> None:
    driver = a_cart()
    driver.run(4.0, Actuation(True, "drive", 0.3, 0.3, 0.0))
    truth = driver.fleet.truth("s1")
    assert driver.motion.steer_rad == pytest.approx(0.3, abs=2e-3)
    assert driver.motion.speed_mps == pytest.approx(truth.speed_mps, abs=0.06)


def test_in_reverse_the_cart_goes_backwards_and_says_so() -> None:
    driver = a_cart()
    driver.run(4.0, Actuation(True, "reverse", 0.0, 0.3, 0.0))
    truth = driver.fleet.truth("s1")
    assert truth.speed_mps < -0.5
    assert driver.motion.speed_mps == pytest.approx(truth.speed_mps, abs=0.06)


def test_in_neutral_the_throttle_moves_nothing() -> None:
    driver = a_cart()
    driver.run(4.0, Actuation(True, "neutral", 0.0, 0.3, 0.0))
    assert driver.fleet.truth("s1").speed_mps == 0.0


def test_the_cart_turns_round_only_while_it_all_but_stands() -> None:
    driver = a_cart()
    driver.run(4.0, ROLL)
    assert driver.fleet.truth("s1").speed_mps > 0.5
    driver.run(0.5, Actuation(True, "reverse", 0.0, 0.3, 0.0))
    assert driver.fleet.truth("s1").speed_mps > 0.5, "the relay does not switch at speed"
    driver.run(3.0, Actuation(True, "reverse", 0.0, 0.0, 1.0))
    driver.run(4.0, Actuation(True, "reverse", 0.0, 0.3, 0.0))
    assert driver.fleet.truth("s1").speed_mps < -0.5


@pytest.mark.parametrize(("speed_mps", "goes_backwards"), [(0.25, True), (0.35, False)])
def test_below_a_third_of_a_metre_per_second_the_relay_switches(
    speed_mps: float, goes_backwards: bool
) -> None:
    driver = a_cart()
    driver.run(4.0, ROLL)
    rolling = dataclasses.replace(driver.fleet.truth("s1"), speed_mps=speed_mps)
    reverse = Actuation(True, "reverse", 0.0, 0.0, 0.0)
    for _ in range(5):
        commands, driver.state = driver.can.encode(driver.state, reverse, driver.now_ns)
        for frame in commands:
            driver.module.receive(frame)
        driver.module.supervise(driver.now_ns, rolling)
        driver.now_ns += STEP_NS
    assert (driver.module.gear()[0] < 0.0) is goes_backwards


def test_silence_disarms_and_coasts() -> None:
    driver = a_cart()
    driver.run(3.0, ROLL)
    driver.run(0.08, ROLL, silent=True)
    assert driver.module.enabled
    driver.run(0.2, ROLL, silent=True)
    assert not driver.module.enabled
    assert driver.fleet.truth("s1").brake_ratio == 0.0
    assert driver.module.gear() == (1.0, 0.0), "a cart has no parking lock"


def test_after_a_timeout_the_codec_asks_again() -> None:
    driver = a_cart()
    driver.run(3.0, ROLL)
    driver.run(0.3, ROLL, silent=True)
    driver.run(1.0, BRAKE)
    assert driver.module.enabled
    assert driver.fleet.truth("s1").brake_ratio > 0.9


def test_the_driver_takes_over_and_keeps_it() -> None:
    driver = a_cart()
    driver.run(3.0, ROLL)
    driver.module.driver = SafetyDriver(brake_ratio=0.3)
    driver.run(0.2, ROLL)
    assert driver.motion.overridden
    driver.module.driver = HANDS_OFF
    driver.run(2.0, ROLL)
    assert not driver.motion.enabled
    driver.run(0.1, RELEASE)
    driver.run(1.0, ROLL)
    assert driver.motion.enabled


def test_the_stop_button_stops_the_cart() -> None:
    driver = a_cart()
    driver.run(4.0, ROLL)
    driver.module.stop_pressed = True
    driver.run(2.0, ROLL)
    assert driver.fleet.truth("s1").speed_mps == 0.0
    assert "emergency_stop_pressed" in [fault.code for fault in driver.motion.faults]


def test_arming_with_the_throttle_open_is_a_fault_that_a_reset_clears() -> None:
    driver = a_cart()
    driver.run(1.0, RELEASE)
    module = driver.module
    assert isinstance(module, ServoModule)
    known = layouts(SERVO)
    stamp_ns = driver.now_ns
    counter = int(module.watch.value("drive_command", "counter")) + 1
    throttle = {"duty": 0.4, "counter": counter}
    module.receive(checked_frame(known["throttle_command"], throttle, stamp_ns))
    arm = {"arm": 1.0, "direction": 1.0, "counter": counter}
    module.receive(checked_frame(known["drive_command"], arm, stamp_ns + 1_000_000))
    assert module.start_fault
    assert not module.enabled
    arm = {"reset": 1.0, "counter": counter + 1}
    module.receive(checked_frame(known["drive_command"], arm, stamp_ns + 2_000_000))
    assert not module.start_fault


@pytest.mark.parametrize("bar", ["overridden", "injected_fault", "stop_pressed"])
def test_each_of_a_takeover_a_fault_and_the_stop_button_bars_arming(bar: str) -> None:
    driver = a_cart()
    driver.run(1.0, RELEASE)
    layout = layouts(SERVO)["drive_command"]
    counter = int(driver.module.watch.value("drive_command", "counter"))
    for barred in (True, False):
        setattr(driver.module, bar, barred)
        for arm in (0.0, 1.0):
            counter = (counter + 1) % SERVO_COUNTER_STEPS
            frame = checked_frame(layout, {"counter": counter, "arm": arm}, driver.now_ns)
            driver.module.receive(frame)
            driver.now_ns += 1_000_000
        assert driver.module.enabled is not barred


def test_a_repeated_frame_is_not_alive() -> None:
    driver = a_cart()
    driver.run(3.0, ROLL)
    frames = driver.can.encode(driver.state, ROLL, driver.now_ns)[0]  # type: ignore[arg-type]
    for step in range(10):
        for frame in frames:
            stamp_ns = frame.stamp_ns + step * 20_000_000
            driver.module.receive(type(frame)(stamp_ns, frame.arbitration_id, frame.data))
        driver.module.supervise(driver.now_ns + step * 20_000_000, driver.fleet.truth("s1"))
    assert not driver.module.enabled
    assert driver.module.watch.miscounted > 0


def test_the_cart_reports_how_many_frames_it_could_not_use() -> None:
    driver = a_cart()
    driver.run(0.5, ROLL)
    known = layouts(SERVO)
    drive = known["drive_command"].arbitration_id
    repeated = driver.can.encode(driver.state, ROLL, driver.now_ns)[0][0]  # type: ignore[arg-type]
    for number, data in enumerate((b"1", repeated.data, repeated.data)):
        driver.module.receive(CanFrame(driver.now_ns + number * 1_000_000, drive, data))
    driver.module.receive(CanFrame(driver.now_ns + 2_000_001, drive, repeated.data))
    watch = driver.module.watch
    assert min(watch.malformed, watch.miscounted, watch.crowded) >= 1
    reports = driver.module.reports(driver.now_ns, driver.fleet.truth("s1"))
    told = next(f for f in reports if f.arbitration_id == known["drive_report"].arbitration_id)
    assert known["drive_report"].unpack(told.data)["errors"] == (
        watch.malformed + watch.miscounted + watch.crowded
    )
