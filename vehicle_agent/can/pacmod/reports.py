"""The by-wire module's latest reports."""

from functools import cache

import msgspec

from contract.wire.reasons import FaultCode
from vehicle_agent.can.dbc import FrameError, MessageLayout, SignalLayout, layouts
from vehicle_agent.can.speed_plausibility import is_doubted
from vehicle_agent.signals import CanFrame

# report message -> our field <- its signal
READ: dict[str, dict[str, str]] = {
    "global_report": {
        "enabled": "enabled",
        "override_active": "override_active",
        "computer_timeout": "computer_timeout",
        "subsystem_timeout": "subsystem_timeout",
        "fault_active": "fault_active",
        "config_fault": "config_fault",
    },
    "system_report": {"disable_all": "disable_all", "ready": "ready"},
    "accelerator_report": {"throttle_ratio": "output"},
    "brake_report": {"brake_ratio": "output"},
    "steering_report": {"wheel_rad": "output"},
    "speed_report": {"speed_mps": "speed"},
    "stop_button_report": {"stop_pressed": "pressed"},
    "energy_report": {"charge_ratio": "charge"},
}
STAMPED = {
    "global_report": "global_ns",
    "accelerator_report": "accelerator_ns",
    "brake_report": "brake_ns",
    "steering_report": "steering_ns",
    "speed_report": "speed_ns",
}
SPEED_NOT_AVAILABLE_MPS = 327.62


class Reports(msgspec.Struct, frozen=True):
    """Newest value of each report; `*_ns` are arrival stamps, 0 before the first.

    doubted_mps, doubted_ns  a speed report that is not plausible yet
    """

    enabled: float = 0.0
    override_active: float = 0.0
    computer_timeout: float = 0.0
    subsystem_timeout: float = 0.0
    fault_active: float = 0.0
    config_fault: float = 0.0
    disable_all: float = 0.0
    ready: float = 0.0
    throttle_ratio: float = 0.0
    brake_ratio: float = 0.0
    wheel_rad: float = 0.0
    speed_mps: float = 0.0
    stop_pressed: float = 0.0
    charge_ratio: float = 0.0
    global_ns: int = 0
    accelerator_ns: int = 0
    brake_ns: int = 0
    steering_ns: int = 0
    speed_ns: int = 0
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

    A frame of the wrong length, a speed marked not available and a speed that leaps are noted as malformed
    and change nothing else.
    """
    readers = _readers()
    values: dict[str, float] | None = None
    for frame in frames:
        reader = readers.get(frame.arbitration_id)
        if reader is None:
            continue
        if values is None:
            values = msgspec.structs.asdict(reports)
        _take(values, reader, frame)
    return reports if values is None else msgspec.structs.replace(reports, **values)


def _take(values: dict[str, float], reader: _Reader, frame: CanFrame) -> None:
    try:
        word = reader.layout.word(frame.data)
    except FrameError:
        values["malformed_ns"] = frame.stamp_ns
        return
    read = {field: signal.read(word) for field, signal in reader.signals}
    if read.get("speed_mps", 0.0) > SPEED_NOT_AVAILABLE_MPS:
        values["malformed_ns"] = frame.stamp_ns
        return
    speed_mps = read.get("speed_mps")
    if speed_mps is not None and is_doubted(values, speed_mps, frame.stamp_ns, "speed_mps", "speed_ns"):
        return
    values.update(read)
    if reader.stamp_field:
        values[reader.stamp_field] = frame.stamp_ns
