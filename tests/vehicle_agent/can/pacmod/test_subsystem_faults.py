"""What each flag of the module's reports does to the vehicle, from the bytes of the frame."""

import pytest

from simulator.ecus.injected_flags import UnknownFlagError
from simulator.ecus.safety_driver import SafetyDriver
from tests.vehicle_agent.can.pacmod.guarded_vehicle import GuardedVehicle
from vehicle_agent.can.dbc import layouts
from vehicle_agent.can.pacmod.codec import Pacmod
from vehicle_agent.can.pacmod.subsystems import DRIVING, FAULT_FLAGS, SIGNALLING
from vehicle_agent.signals import CanFrame

NOW_NS = 1_000_000_000
STOPPING = [*DRIVING.items()]


def report(name: str, stamp_ns: int = NOW_NS, **values: float) -> CanFrame:
    layout = layouts()[name]
    return CanFrame(stamp_ns, layout.arbitration_id, layout.pack(values))


def found(*frames: CanFrame) -> list[tuple[str, str]]:
    """(code, severity) that a codec reads from one tick's frames."""
    can = Pacmod()
    motion, _ = can.decode(can.initial(), frames, NOW_NS)
    return [(fault.code, fault.severity) for fault in motion.faults]


def driving() -> GuardedVehicle:
    vehicle = GuardedVehicle()
    vehicle.drive(2.5)
    assert vehicle.motion.enabled
    assert vehicle.speed_mps > 0.8
    assert vehicle.raised() == []
    return vehicle


@pytest.mark.parametrize("flag", FAULT_FLAGS)
@pytest.mark.parametrize(("name", "code"), STOPPING)
def test_each_fault_of_a_subsystem_that_driving_needs_is_a_stop_fault_with_its_name(
    name: str, code: str, flag: str
) -> None:
    assert found(report(name, enabled=1, **{flag: 1})) == [(code, "stop")]


@pytest.mark.parametrize("flag", FAULT_FLAGS)
@pytest.mark.parametrize("name", SIGNALLING)
def test_a_fault_of_signals_horn_and_lights_is_a_warning(name: str, flag: str) -> None:
    assert found(report(name, **{flag: 1})) == [("bywire_signal_fault", "warning")]


@pytest.mark.parametrize("name", DRIVING)
def test_a_subsystem_that_misses_its_commands_has_timed_out(name: str) -> None:
    assert found(report(name, command_timeout=1)) == [("bywire_timeout", "info")]


@pytest.mark.parametrize(
    "flag", ["computer_timeout", "steering_timeout", "brake_timeout", "subsystem_timeout", "vehicle_timeout"]
)
def test_each_timeout_that_the_module_reports_is_read(flag: str) -> None:
    assert found(report("global_report", **{flag: 1})) == [("bywire_timeout", "info")]


@pytest.mark.parametrize("name", DRIVING)
def test_a_module_that_is_enabled_without_one_of_its_subsystems_is_noticed_before_driving(name: str) -> None:
    frames = (report("global_report", enabled=1), report(name, enabled=0))
    assert found(*frames) == [("bywire_lost_in_part", "warning")]


def test_an_override_that_a_subsystem_does_not_give_way_to_is_its_fault() -> None:
    assert found(report("steering_report", enabled=1, override_active=1)) == [
        ("bywire_steering_fault", "stop")
    ]


def test_the_issue_s_frame_of_everything_wrong_names_everything() -> None:
    wrong = {"enabled": 0, "bywire_fault": 1, "command_timeout": 1}
    frames = (
        report("global_report", enabled=1, brake_timeout=1, steering_timeout=1, vehicle_timeout=1),
        report("brake_report", **wrong),
        report("steering_report", **wrong),
    )
    assert {code for code, _ in found(*frames)} == {
        "bywire_brake_fault",
        "bywire_steering_fault",
        "bywire_lost_in_part",
        "bywire_timeout",
    }


def test_a_fault_in_the_first_of_two_reports_of_one_tick_is_not_lost() -> None:
    frames = (report("brake_report", enabled=1, vehicle_fault=1), report("brake_report", enabled=1))
    assert found(*frames) == [("bywire_brake_fault", "stop")]
    frames = (report("global_report", config_fault=1), report("global_report"))
    assert found(*frames) == [("bywire_fault", "stop")]


def test_a_status_counts_though_the_value_beside_it_is_not_available() -> None:
    data = bytearray(report("brake_report", vehicle_fault=1).data)
    data[5:7] = b"\xff\xff"
    assert found(CanFrame(NOW_NS, 0x204, bytes(data))) == [
        ("can_frame_malformed", "warning"),
        ("bywire_brake_fault", "stop"),
    ]


def test_gear_lights_horn_wheels_and_yaw_rate_are_read_and_unknown_before_their_reports() -> None:
    can = Pacmod()
    motion, state = can.decode(can.initial(), (), NOW_NS)
    unknown = (motion.gear, motion.turn_signal, motion.horn, motion.headlights, motion.wheels_radps)
    assert (*unknown, motion.yaw_rate_radps) == (None,) * 6
    frames = (
        report("shift_report", output=1),
        report("turn_report", output=2),
        report("horn_report", output=1),
        report("headlight_report", output=2),
        report("wheel_report", front_left=1.0, front_right=2.0, rear_left=3.0, rear_right=4.0),
        report("yaw_rate_report", yaw_valid=1, yaw_rate=-0.25),
    )
    motion, state = can.decode(state, frames, NOW_NS)
    assert (motion.gear, motion.turn_signal, motion.horn, motion.headlights) == (
        "reverse",
        "left",
        True,
        "high",
    )
    assert motion.wheels_radps == pytest.approx((1.0, 2.0, 3.0, 4.0))
    assert motion.yaw_rate_radps == pytest.approx(-0.25)
    motion, _ = can.decode(state, (report("yaw_rate_report", yaw_valid=0, yaw_rate=1.0),), NOW_NS)
    assert motion.yaw_rate_radps is None


@pytest.mark.parametrize(("name", "code"), STOPPING)
def test_a_fault_of_one_report_stops_the_vehicle_until_it_is_over_and_the_operator_resumes(
    name: str, code: str
) -> None:
    vehicle = driving()
    vehicle.module.inject(name, "vehicle_fault", reports=1)
    vehicle.drive(3.0)
    assert vehicle.speed_mps < 0.05
    assert vehicle.modes()[-1] == "minimal_risk"
    assert vehicle.raised() == [(code, False), (code, True)]
    vehicle.resume()
    vehicle.drive(2.0)
    assert vehicle.status.mode == "autonomous"
    assert vehicle.speed_mps > 0.5


@pytest.mark.parametrize("name", ["accelerator_report", "shift_report", "steering_report"])
def test_without_one_subsystem_the_vehicle_is_braked_by_wire(name: str) -> None:
    vehicle = driving()
    vehicle.module.inject(name, "enabled")
    vehicle.drive(0.3)
    assert "bywire_lost_in_part" in vehicle.codes
    vehicle.drive(2.5)
    assert vehicle.speed_mps < 0.05
    assert vehicle.motion.enabled, "the brake is held"
    assert vehicle.motion.brake_ratio > 0.2


def test_without_the_brake_by_wire_the_throttle_is_released_and_the_brake_asked_for_again() -> None:
    vehicle = driving()
    vehicle.module.inject("brake_report", "enabled", reports=4)
    vehicle.drive(0.1)
    assert not vehicle.motion.enabled
    accelerator = layouts()["accelerator_command"]
    data = [frame.data for frame in vehicle.sent if frame.arbitration_id == accelerator.arbitration_id]
    assert [accelerator.unpack(sent)["position"] for sent in data] == [0.0]
    vehicle.drive(3.0)
    assert vehicle.motion.enabled
    assert vehicle.speed_mps < 0.05, "the minimal-risk stop goes on with the brake that came back"
    assert vehicle.modes()[-1] == "minimal_risk"


def test_a_fault_of_the_lights_is_reported_and_the_vehicle_drives_on() -> None:
    vehicle = driving()
    vehicle.module.inject("turn_report", "output_reported_fault", reports=1)
    vehicle.drive(2.0)
    assert vehicle.raised() == [("bywire_signal_fault", False), ("bywire_signal_fault", True)]
    assert vehicle.status.mode == "autonomous"
    assert vehicle.speed_mps > 0.8


def test_faults_that_change_with_each_report_are_raised_once_each() -> None:
    vehicle = driving()
    turns = [(name, flag) for flag in FAULT_FLAGS for name in (*DRIVING, "horn_report")]
    for name, flag in turns * 3:
        vehicle.module.inject(name, flag, reports=1)
        vehicle.drive(0.04)
    codes = [*DRIVING.values(), "bywire_signal_fault"]
    assert sorted(vehicle.raised()) == sorted((code, False) for code in codes)
    vehicle.drive(1.5)
    assert sorted(vehicle.raised()[len(codes) :]) == sorted((code, True) for code in codes)


def test_by_wire_is_not_requested_for_a_vehicle_whose_brake_is_at_fault() -> None:
    vehicle = GuardedVehicle()
    vehicle.module.inject("brake_report", "command_output_fault")
    vehicle.drive(3.0)
    assert not vehicle.module.enable_requested
    assert vehicle.status.mode == "fault"
    assert not vehicle.motion.enabled
    vehicle.module.clear_injected("brake_report", "command_output_fault")
    vehicle.drive(1.2)
    vehicle.resume()
    vehicle.drive(2.0)
    assert vehicle.status.mode == "autonomous"
    assert vehicle.speed_mps > 0.3


def test_a_driver_who_takes_one_subsystem_has_the_vehicle() -> None:
    vehicle = driving()
    vehicle.module.inject("steering_report", "override_active")
    vehicle.module.inject("steering_report", "enabled")
    vehicle.drive(0.3)
    assert vehicle.status.mode == "manual"
    assert vehicle.status.reason == "takeover"
    assert not vehicle.module.enabled


def test_a_stop_button_that_the_module_cannot_read_stops_the_vehicle() -> None:
    vehicle = driving()
    vehicle.module.inject("stop_button_report", "fault")
    vehicle.drive(3.0)
    assert ("stop_button_fault", False) in vehicle.raised()
    assert vehicle.speed_mps < 0.05


def test_the_driver_s_stalks_are_reported() -> None:
    vehicle = driving()
    vehicle.module.driver = SafetyDriver(turn_signal="left", horn=True, headlights="low")
    vehicle.drive(0.1)
    motion = vehicle.motion
    assert (motion.turn_signal, motion.horn, motion.headlights, motion.gear) == ("left", True, "low", "drive")
    assert motion.enabled, "a stalk is no takeover"


@pytest.mark.parametrize(
    ("name", "flag"),
    [
        ("brake_report", "brakes"),
        ("door_report", "enabled"),
        ("brake_command", "enable"),
        ("brake_report", "output"),
    ],
)
def test_the_simulated_module_refuses_a_flag_that_it_does_not_have(name: str, flag: str) -> None:
    with pytest.raises(UnknownFlagError, match=name):
        GuardedVehicle().module.inject(name, flag)
