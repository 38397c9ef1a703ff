"""The by-wire module's latest reports."""

from functools import cache
from typing import Any

import msgspec

from contract.wire.reasons import FaultCode
from vehicle_agent.can.dbc import FrameError, MessageLayout, SignalLayout, layouts
from vehicle_agent.can.pacmod.subsystems import Subsystems, take_subsystems
from vehicle_agent.can.pacmod.watchdog import Watchdog, take_watchdog
from vehicle_agent.can.speed_plausibility import is_doubted
from vehicle_agent.signals import CanFrame

# report message -> our field <- its signal
READ: dict[str, dict[str, str]] = {
    "global_report": {
        "enabled": "enabled",
        "override_active": "override_active",
        "computer_timeout": "computer_timeout",
        "steering_timeout": "steering_timeout",
        "brake_timeout": "brake_timeout",
        "subsystem_timeout": "subsystem_timeout",
        "vehicle_timeout": "vehicle_timeout",
        "fault_active": "fault_active",
        "config_fault": "config_fault",
    },
    "system_report": {"disable_all": "disable_all", "ready": "ready", "system_fault": "fault_active"},
    "accelerator_report": {"throttle_ratio": "output"},
    "brake_report": {"brake_ratio": "output"},
    "shift_report": {"gear": "output"},
    "steering_report": {"wheel_rad": "output"},
    "turn_report": {"turn_signal": "output"},
    "horn_report": {"horn": "output"},
    "headlight_report": {"headlights": "output"},
    "speed_report": {"speed_mps": "speed"},
    "wheel_report": {
        "front_left_radps": "front_left",
        "front_right_radps": "front_right",
        "rear_left_radps": "rear_left",
        "rear_right_radps": "rear_right",
    },
    "yaw_rate_report": {"yaw_valid": "yaw_valid", "yaw_rate_radps": "yaw_rate"},
    "stop_button_report": {"stop_pressed": "pressed", "stop_button_fault": "fault"},
    "energy_report": {"charge_ratio": "charge"},
}
# Flags that count for the whole tick if one of several reports in it has them.
_KEPT = frozenset(
    {
        "computer_timeout",
        "steering_timeout",
        "brake_timeout",
        "subsystem_timeout",
        "vehicle_timeout",
        "fault_active",
        "config_fault",
        "system_fault",
        "disable_all",
        "stop_pressed",
        "stop_button_fault",
    }
)
STAMPED = {
    "global_report": "global_ns",
    "accelerator_report": "accelerator_ns",
    "brake_report": "brake_ns",
    "shift_report": "shift_ns",
    "steering_report": "steering_ns",
    "turn_report": "turn_ns",
    "horn_report": "horn_ns",
    "headlight_report": "headlight_ns",
    "speed_report": "speed_ns",
    "wheel_report": "wheel_ns",
    "yaw_rate_report": "yaw_rate_ns",
}


class Reports(msgspec.Struct, frozen=True):
    """Newest value of each report; `*_ns` are arrival stamps, 0 before the first.

    subsystems               the status byte of each subsystem's report
    watchdog                 what the watchdog and the components report
    gear, turn_signal, horn, headlights  codes as in the DBC
    doubted_mps, doubted_ns  a speed report that is not plausible yet
    """

    subsystems: Subsystems = Subsystems()
    watchdog: Watchdog = Watchdog()

    enabled: float = 0.0
    override_active: float = 0.0
    computer_timeout: float = 0.0
    steering_timeout: float = 0.0
    brake_timeout: float = 0.0
    subsystem_timeout: float = 0.0
    vehicle_timeout: float = 0.0
    fault_active: float = 0.0
    config_fault: float = 0.0
    system_fault: float = 0.0
    disable_all: float = 0.0
    ready: float = 0.0
    throttle_ratio: float = 0.0
    brake_ratio: float = 0.0
    gear: float = 0.0
    wheel_rad: float = 0.0
    turn_signal: float = 0.0
    horn: float = 0.0
    headlights: float = 0.0
    speed_mps: float = 0.0
    front_left_radps: float = 0.0
    front_right_radps: float = 0.0
    rear_left_radps: float = 0.0
    rear_right_radps: float = 0.0
    yaw_valid: float = 0.0
    yaw_rate_radps: float = 0.0
    stop_pressed: float = 0.0
    stop_button_fault: float = 0.0
    charge_ratio: float = 0.0
    global_ns: int = 0
    accelerator_ns: int = 0
    brake_ns: int = 0
    shift_ns: int = 0
    steering_ns: int = 0
    turn_ns: int = 0
    horn_ns: int = 0
    headlight_ns: int = 0
    speed_ns: int = 0
    wheel_ns: int = 0
    yaw_rate_ns: int = 0
    malformed_ns: int = 0
    doubted_mps: float = 0.0
    doubted_ns: int = 0

    def stamps_ns(self) -> tuple[tuple[FaultCode, int], ...]:
        """Arrival of each cyclic report, by the fault of its loss."""
        return (
            ("can_global_report_lost", self.global_ns),
            ("can_accelerator_report_lost", self.accelerator_ns),
            ("can_brake_report_lost", self.brake_ns),
            ("can_steering_report_lost", self.steering_ns),
            ("can_speed_report_lost", self.speed_ns),
        )

    @property
    def faulted(self) -> bool:
        """The module as a whole is at fault, or has disabled all its systems."""
        module = self.fault_active or self.config_fault or self.system_fault or self.disable_all
        return bool(module) or self.watchdog.faulted

    @property
    def timed_out(self) -> bool:
        """The module, or a subsystem of it, misses frames that it needs."""
        module = self.computer_timeout or self.subsystem_timeout or self.vehicle_timeout
        parts = self.subsystems.timed_out or self.watchdog.timed_out
        return bool(module or self.steering_timeout or self.brake_timeout) or parts


class _Reader(msgspec.Struct, frozen=True):
    layout: MessageLayout
    signals: tuple[tuple[str, SignalLayout], ...]
    stamp_field: str


@cache
def _readers() -> dict[int, _Reader]:
    known = layouts()
    readers = {}
    for name, fields in READ.items():
        layout = known[name]
        signals = tuple((field, layout.signals[signal]) for field, signal in fields.items())
        readers[layout.arbitration_id] = _Reader(layout, signals, STAMPED.get(name, ""))
    return readers


def take_reports(reports: Reports, frames: tuple[CanFrame, ...]) -> Reports:
    """The reports after these frames, in order; frames of other modules are ignored.

    A frame of the wrong length, a value that is marked as an error or not available, and a speed that leaps
    are noted as malformed and change nothing else; the status byte of such a report still counts.
    """
    readers = _readers()
    watchdog = take_watchdog(reports.watchdog, frames)
    if watchdog is not reports.watchdog:
        reports = msgspec.structs.replace(reports, watchdog=watchdog)
    values: dict[str, Any] | None = None
    heard: set[int] = set()
    for frame in frames:
        reader = readers.get(frame.arbitration_id)
        if reader is None:
            continue
        if values is None:
            values = msgspec.structs.asdict(reports)
        _take(values, reader, frame, frame.arbitration_id in heard)
        heard.add(frame.arbitration_id)
    if values is None:
        return reports
    values["subsystems"] = take_subsystems(reports.subsystems, frames)
    return msgspec.structs.replace(reports, **values)


def _take(values: dict[str, Any], reader: _Reader, frame: CanFrame, heard: bool) -> None:
    """heard: another report of the same kind came in this tick."""
    try:
        word = reader.layout.word(frame.data)
    except FrameError:
        values["malformed_ns"] = frame.stamp_ns
        return
    if not all(signal.is_within_range(word) for _, signal in reader.signals):
        values["malformed_ns"] = frame.stamp_ns
        return
    read = {field: signal.read(word) for field, signal in reader.signals}
    speed_mps = read.get("speed_mps")
    if speed_mps is not None and is_doubted(values, speed_mps, frame.stamp_ns, "speed_mps", "speed_ns"):
        return
    if heard:
        read |= {field: max(read[field], values[field]) for field in _KEPT & read.keys()}
    values.update(read)
    if reader.stamp_field:
        values[reader.stamp_field] = frame.stamp_ns
