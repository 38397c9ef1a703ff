"""The report frames of a by-wire module."""

import math
from dataclasses import dataclass

from simulator.ecus.injected_flags import Flag, with_flags
from simulator.ecus.safety_driver import SafetyDriver
from simulator.vehicle.plant import PlantView
from vehicle_agent.can.dbc import layouts
from vehicle_agent.can.pacmod.codec import HEADLIGHTS, TURN_SIGNALS
from vehicle_agent.can.steering_column import wheel_from_front
from vehicle_agent.config import Profile
from vehicle_agent.signals import CanFrame

WHEEL_RADIUS_M = 0.28
TRACK_WIDTH_M = 1.2


@dataclass(frozen=True, slots=True)
class ModuleStatus:
    """The module's status at the time of a report."""

    enabled: bool
    overridden: bool
    faulted: bool
    timed_out: bool
    late: tuple[str, ...]
    stop_pressed: bool
    driver: SafetyDriver
    gear: float
    commanded_throttle: float
    commanded_brake: float
    commanded_gear: float
    commanded_wheel_rad: float
    errors: int
    injected: frozenset[Flag] = frozenset()


def report_frames(
    now_ns: int, status: ModuleStatus, truth: PlantView, profile: Profile
) -> tuple[CanFrame, ...]:
    """One round of reports, stamped now."""
    known = layouts()
    return tuple(
        CanFrame(now_ns, known[name].arbitration_id, known[name].pack(values))
        for name, values in with_flags(_values(status, truth, profile), status.injected).items()
    )


def _values(status: ModuleStatus, truth: PlantView, profile: Profile) -> dict[str, dict[str, float]]:
    wheel_rad = wheel_from_front(profile.steering, truth.steer_rad)
    driver = status.driver
    hands_rad = wheel_rad if driver.steer_rad is not None else 0.0
    return {
        "global_report": {
            "enabled": status.enabled,
            "override_active": status.overridden,
            "computer_timeout": status.timed_out,
            "fault_active": status.faulted,
            "supervisory_required": not status.enabled,
            "computer_read_errors": float(status.errors),
        },
        "system_report": {
            "enabled": status.enabled,
            "override_active": status.overridden,
            "fault_active": status.faulted,
            "supervisory_required": not status.enabled,
            "disable_all": status.stop_pressed,
            "ready": True,
        },
        "accelerator_report": _subsystem(status, "accelerator_command")
        | {
            "manual": driver.throttle_ratio,
            "commanded": status.commanded_throttle,
            "output": truth.throttle_ratio,
        },
        "brake_report": _subsystem(status, "brake_command")
        | {"manual": driver.brake_ratio, "commanded": status.commanded_brake, "output": truth.brake_ratio},
        "shift_report": _subsystem(status, "shift_command")
        | {"manual": status.gear, "commanded": status.commanded_gear, "output": status.gear},
        "steering_report": _subsystem(status, "steering_command")
        | {"manual": hands_rad, "commanded": status.commanded_wheel_rad, "output": wheel_rad},
        "turn_report": _stalk(status, TURN_SIGNALS.index(driver.turn_signal)),
        "horn_report": _stalk(status, driver.horn),
        "headlight_report": _stalk(status, HEADLIGHTS.index(driver.headlights)),
        "speed_report": {"speed": truth.speed_mps},
        "wheel_report": _wheel_speeds(truth, profile.body.wheelbase_m),
        "yaw_rate_report": {"yaw_new": True, "yaw_valid": True, "yaw_rate": truth.yaw_rate_radps},
        "stop_button_report": {"pressed": status.stop_pressed},
        "energy_report": {"charge": truth.battery_ratio},
    }


def _subsystem(status: ModuleStatus, command: str) -> dict[str, float]:
    return {
        "enabled": status.enabled,
        "override_active": status.overridden,
        "bywire_fault": status.faulted,
        "command_timeout": command in status.late,
    }


def _stalk(status: ModuleStatus, code: float) -> dict[str, float]:
    """What only the driver operates: no command takes it by wire."""
    return {"bywire_fault": status.faulted, "manual": code, "output": code}


def _wheel_speeds(truth: PlantView, wheelbase_m: float) -> dict[str, float]:
    """Turning rates of the four wheels (rad/s) of the rigid vehicle around its instant centre."""
    half = 0.5 * TRACK_WIDTH_M
    spin = truth.yaw_rate_radps
    way = math.copysign(1.0, truth.speed_mps)
    left, right = truth.speed_mps - spin * half, truth.speed_mps + spin * half
    nose = spin * wheelbase_m
    return {
        "front_left": way * math.hypot(left, nose) / WHEEL_RADIUS_M,
        "front_right": way * math.hypot(right, nose) / WHEEL_RADIUS_M,
        "rear_left": left / WHEEL_RADIUS_M,
        "rear_right": right / WHEEL_RADIUS_M,
    }
