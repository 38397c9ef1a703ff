"""The report frames of a by-wire module."""

import math
from dataclasses import dataclass

from simulator.ecus.injected_flags import Flag, with_flags
from simulator.ecus.safety_driver import SafetyDriver
from simulator.vehicle.plant import PlantView
from vehicle_agent.can.dbc import layouts
from vehicle_agent.can.pacmod.codec import HEADLIGHTS, TURN_SIGNALS
from vehicle_agent.can.pacmod.watchdog import COMPONENT_COUNTER_STEPS
from vehicle_agent.can.steering_column import wheel_from_front
from vehicle_agent.config import Profile
from vehicle_agent.signals import CanFrame

WHEEL_RADIUS_M = 0.28
_NO_TURN = float(TURN_SIGNALS.index("none"))
# A component's states.
_READY, _AUTONOMOUS = 1.0, 2.0
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
    commanded_turn: float
    commanded_horn: float
    commanded_headlights: float
    counter: int
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
        "turn_report": _stalk(
            status, "turn_command", TURN_SIGNALS.index(driver.turn_signal), status.commanded_turn, _NO_TURN
        ),
        "horn_report": _stalk(status, "horn_command", driver.horn, status.commanded_horn, 0.0),
        "headlight_report": _stalk(
            status,
            "headlight_command",
            HEADLIGHTS.index(driver.headlights),
            status.commanded_headlights,
            0.0,
        ),
        "speed_report": {"speed": truth.speed_mps * truth.wheel_ratio},
        "wheel_report": _wheel_speeds(truth, profile.body.wheelbase_m),
        "yaw_rate_report": {"yaw_new": True, "yaw_valid": True, "yaw_rate": truth.yaw_rate_radps},
        "stop_button_report": {"pressed": status.stop_pressed},
        "energy_report": {"charge": truth.battery_ratio},
        "component_report": {
            "enabled": status.enabled,
            "override_active": status.overridden,
            "fault_active": status.faulted,
            "ready": True,
            "state": _AUTONOMOUS if status.enabled else _READY,
            "counter": float(status.counter),
            "complement": float(COMPONENT_COUNTER_STEPS - 1 - status.counter),
        },
        "watchdog_report": {
            "enabled": status.enabled,
            "override_active": status.overridden,
            "computer_timeout": status.timed_out,
            "fault_active": status.faulted,
        },
        "watchdog_report_2": {"command_timeout": status.timed_out},
    }


def _subsystem(status: ModuleStatus, command: str) -> dict[str, float]:
    return {
        "enabled": status.enabled,
        "override_active": status.overridden,
        "bywire_fault": status.faulted,
        "command_timeout": command in status.late,
    }


def _stalk(
    status: ModuleStatus, command: str, manual: float, commanded: float, rest: float
) -> dict[str, float]:
    """Signals: a stalk that the driver moves from its rest has precedence, and is no takeover."""
    is_moved, is_late = manual != rest, command in status.late
    by_wire = status.enabled and not is_late and not is_moved
    return {
        "enabled": by_wire,
        "override_active": status.enabled and is_moved,
        "bywire_fault": status.faulted,
        "command_timeout": is_late,
        "manual": manual,
        "commanded": rest if is_late else commanded,
        "output": commanded if by_wire else manual,
    }


def _wheel_speeds(truth: PlantView, wheelbase_m: float) -> dict[str, float]:
    """Turning rates of the four wheels (rad/s) of the rigid vehicle around its instant centre."""
    half = 0.5 * TRACK_WIDTH_M
    spin = truth.yaw_rate_radps
    speed_mps = truth.speed_mps * truth.wheel_ratio
    way = math.copysign(1.0, speed_mps)
    left, right = speed_mps - spin * half, speed_mps + spin * half
    nose = spin * wheelbase_m
    return {
        "front_left": way * math.hypot(left, nose) / WHEEL_RADIUS_M,
        "front_right": way * math.hypot(right, nose) / WHEEL_RADIUS_M,
        "rear_left": left / WHEEL_RADIUS_M,
        "rear_right": right / WHEEL_RADIUS_M,
    }
