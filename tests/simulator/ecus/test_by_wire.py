import pytest

from simulator.ecus.by_wire import ByWire
from simulator.ecus.command_watch import CommandWatch
from simulator.ecus.safety_driver import HANDS_OFF, SafetyDriver
from tests.simulator.ecus.can_driver import (
    BRAKE,
    RELEASE,
    ROLL,
    CanDriver,
)
from vehicle_agent.can.dbc import layouts
from vehicle_agent.config import Profile
from vehicle_agent.signals import Actuation, CanFrame

FIRST_NS = 1_000_000_000


def command(name: str, stamp_ns: int, **values: float) -> CanFrame:
    layout = layouts()[name]
    return CanFrame(stamp_ns, layout.arbitration_id, layout.pack(values))


def heartbeat(name: str, stamp_ns: int, counter: int, **values: float) -> CanFrame:
    return command(name, stamp_ns, counter=counter, complement=15 - counter, **values)


def test_the_handshake_enables_and_the_vehicle_drives() -> None:
    driver = CanDriver()
    driver.run(3.0, ROLL)
    assert driver.motion.enabled
    assert driver.motion.speed_mps > 1.0
    assert not driver.motion.faults
    watch = driver.module.watch
    assert (watch.crowded, watch.miscounted, watch.malformed) == (0, 0, 0)


def test_steering_comes_back_through_the_column_as_it_was_commanded() -> None:
    driver = CanDriver()
    driver.run(3.0, Actuation(True, "drive", -0.2, 0.3, 0.0))
    assert driver.fleet.truth("s1").steer_rad == pytest.approx(-0.2, abs=1e-3)
    assert driver.motion.steer_rad == pytest.approx(-0.2, abs=1e-3)


def test_reports_come_thirty_times_a_second() -> None:
    driver = CanDriver()
    driver.run(10.0, RELEASE)
    speeds = [f for f in driver.heard if f.arbitration_id == 0x400]
    assert len(speeds) == pytest.approx(300, abs=3)
    assert {f.arbitration_id for f in driver.heard} >= {0x10, 0x11, 0x200, 0x204, 0x228, 0x22C, 0x400, 0x407}


def test_silence_for_100_ms_ends_by_wire_and_nobody_brakes_when_coasting() -> None:
    driver = CanDriver(Profile(fail_action="coast"))
    driver.run(4.0, ROLL)
    before_mps = driver.motion.speed_mps
    driver.run(0.08, ROLL, silent=True)
    assert driver.module.enabled
    driver.run(1.0, ROLL, silent=True)
    assert not driver.module.enabled
    assert not driver.motion.enabled
    assert driver.fleet.truth("s1").brake_ratio == 0.0
    assert driver.fleet.truth("s1").speed_mps > 0.6 * before_mps


def test_silence_stops_the_vehicle_with_a_spring_brake() -> None:
    driver = CanDriver(Profile(fail_action="spring_brake"))
    driver.run(4.0, ROLL)
    driver.run(2.0, ROLL, silent=True)
    assert driver.fleet.truth("s1").speed_mps == 0.0


def test_by_wire_comes_back_by_a_new_handshake_after_silence() -> None:
    driver = CanDriver()
    driver.run(4.0, ROLL)
    driver.run(1.0, ROLL, silent=True)
    driver.run(0.5, BRAKE)
    assert driver.module.enabled
    driver.run(2.0, BRAKE)
    assert driver.fleet.truth("s1").speed_mps == 0.0


def test_a_driver_on_the_brake_takes_over_and_keeps_the_vehicle() -> None:
    driver = CanDriver()
    driver.run(4.0, ROLL)
    driver.module.driver = SafetyDriver(brake_ratio=0.5)
    driver.run(3.0, ROLL)
    assert driver.motion.overridden
    assert not driver.motion.enabled
    assert driver.fleet.truth("s1").speed_mps == 0.0
    driver.module.driver = HANDS_OFF
    driver.run(2.0, ROLL)
    assert not driver.module.enabled
    driver.run(0.1, RELEASE)
    driver.run(2.0, ROLL)
    assert driver.motion.enabled
    assert not driver.motion.overridden


def test_the_stop_button_stops_and_bars_enabling_while_pressed() -> None:
    driver = CanDriver()
    driver.run(4.0, ROLL)
    driver.module.stop_pressed = True
    driver.run(2.0, ROLL)
    assert driver.fleet.truth("s1").speed_mps == 0.0
    assert not driver.module.enabled
    assert "emergency_stop_pressed" in {fault.code for fault in driver.motion.faults}
    driver.module.stop_pressed = False
    driver.run(1.0, ROLL)
    assert driver.module.enabled


def send_round(
    module: ByWire, t: int, counter: int, enable: int, brake_ratio: float = 0.0, gear: int = 0
) -> int:
    """Sends every command once from t on; returns when the next round is due."""
    module.receive(heartbeat("global_command", t, counter))
    module.receive(command("accelerator_command", t + 500_000))
    module.receive(command("brake_command", t + 1_000_000, position=brake_ratio))
    module.receive(command("shift_command", t + 1_500_000, gear=gear))
    module.receive(command("steering_command", t + 2_000_000))
    module.receive(heartbeat("supervisory_command", t + 2_500_000, counter, enable=enable))
    return t + 20_000_000


def enable_with_brake(module: ByWire, brake_ratio: float) -> None:
    t = send_round(module, FIRST_NS, 0, enable=0, brake_ratio=brake_ratio)
    send_round(module, t, 1, enable=1, brake_ratio=brake_ratio)


def test_enabling_with_the_brake_down_damages_the_servo() -> None:
    module = ByWire(Profile())
    enable_with_brake(module, 0.3)
    assert module.start_fault
    assert not module.enabled


def test_enabling_with_both_pedals_up_enables() -> None:
    module = ByWire(Profile())
    enable_with_brake(module, 0.0)
    assert module.enabled


@pytest.mark.parametrize("before", [0, 1])
def test_after_silence_by_wire_comes_back_only_when_the_enable_bit_falls_and_rises(before: int) -> None:
    module, truth = ByWire(Profile()), CanDriver().fleet.truth("s1")
    t = send_round(module, FIRST_NS, 0, enable=0)
    t = send_round(module, t, 1, enable=before)
    module.supervise(t + 200_000_000, truth)
    enabled = []
    for counter, enable in ((2, 1), (3, 0), (4, 1)):
        t = send_round(module, t + 200_000_000, counter, enable=enable)
        module.supervise(t, truth)
        enabled.append(module.enabled)
    assert enabled == [False, False, True]


def test_in_low_gear_the_vehicle_drives_forward() -> None:
    module = ByWire(Profile())
    t = send_round(module, FIRST_NS, 0, enable=0, gear=4)
    t = send_round(module, t, 1, enable=1, gear=4)
    module.supervise(t, CanDriver().fleet.truth("s1"))
    assert module.gear() == (1.0, 0.0)


def test_a_repeated_heartbeat_is_no_life_sign() -> None:
    watch = CommandWatch()
    assert watch.take(heartbeat("supervisory_command", 0, 4, enable=1)) == "supervisory_command"
    for k in range(1, 6):
        assert watch.take(heartbeat("supervisory_command", k * 20_000_000, 4, enable=1)) == ""
    assert watch.miscounted == 5
    assert watch.is_late("supervisory_command", 110_000_000)


def test_a_wrong_complement_is_refused() -> None:
    watch = CommandWatch()
    assert watch.take(command("global_command", 0, counter=3, complement=3)) == ""
    assert watch.miscounted == 1


def test_counting_resumes_after_a_lost_frame() -> None:
    watch = CommandWatch()
    watch.take(heartbeat("global_command", 0, 15))
    assert watch.take(heartbeat("global_command", 20_000_000, 0)) == "global_command"
    assert watch.take(heartbeat("global_command", 60_000_000, 2)) == ""
    assert watch.take(heartbeat("global_command", 80_000_000, 3)) == "global_command"


def test_frames_closer_than_half_a_millisecond_are_lost() -> None:
    watch = CommandWatch()
    assert watch.take(command("brake_command", 0)) == "brake_command"
    assert watch.take(command("accelerator_command", 400_000)) == ""
    assert watch.take(command("accelerator_command", 600_000)) == "accelerator_command"
    assert watch.crowded == 1


def test_frames_of_other_modules_pass_by() -> None:
    watch = CommandWatch()
    assert watch.take(CanFrame(0, 0x7FF, b"12345678")) == ""
    assert watch.take(CanFrame(0, 0x100, b"1")) == ""
    assert watch.malformed == 1


def test_the_gearbox_refuses_to_shift_while_rolling() -> None:
    driver = CanDriver()
    driver.run(4.0, ROLL)
    driver.run(0.5, Actuation(True, "reverse", 0.0, 0.0, 0.0))
    assert driver.module.targets(driver.fleet.truth("s1")).direction == 1.0


def test_in_park_the_gearbox_locks_and_the_throttle_drives_nothing() -> None:
    driver = CanDriver()
    driver.run(2.0, Actuation(True, "park", 0.0, 0.0, 0.0))
    assert driver.module.gear() == (0.0, 1.0), "no direction, and the lock is in"
    driver.run(2.0, Actuation(True, "park", 0.0, 0.3, 0.0))
    assert driver.fleet.truth("s1").speed_mps == 0.0
    driver.run(2.0, ROLL)
    assert driver.module.gear() == (1.0, 0.0)


def test_the_module_reports_how_many_frames_it_could_not_use() -> None:
    driver = CanDriver()
    driver.run(0.5, ROLL)
    watch = driver.module.watch
    watch.take(CanFrame(driver.now_ns + 1_000_000, 0x100, b"1"))
    watch.take(command("global_command", driver.now_ns + 2_000_000, counter=3, complement=3))
    watch.take(command("brake_command", driver.now_ns + 3_000_000))
    watch.take(command("accelerator_command", driver.now_ns + 3_100_000))
    driver.run(0.1, ROLL)
    counts = watch.malformed, watch.miscounted, watch.crowded
    assert min(counts) >= 1
    layout = layouts()["global_report"]
    newest = [frame for frame in driver.heard if frame.arbitration_id == layout.arbitration_id][-1]
    assert layout.unpack(newest.data)["computer_read_errors"] == sum(counts)


@pytest.mark.parametrize("back_rad", [-0.2, 0.0, 0.4])
def test_wheels_whose_motor_is_stuck_stay_where_they_are_and_turn_again_afterwards(back_rad: float) -> None:
    driver = CanDriver()
    driver.run(4.0, Actuation(True, "drive", 0.2, 0.1, 0.0))
    stuck_rad = driver.fleet.truth("s1").steer_rad
    assert stuck_rad == pytest.approx(0.2, abs=0.01)
    driver.module.steering_stuck = True
    driver.run(1.0, Actuation(True, "drive", back_rad, 0.1, 0.0))
    assert driver.fleet.truth("s1").steer_rad == stuck_rad
    driver.module.steering_stuck = False
    driver.run(2.0, Actuation(True, "drive", back_rad, 0.1, 0.0))
    assert driver.fleet.truth("s1").steer_rad == pytest.approx(back_rad, abs=0.01)
