"""The gate's report to the tick: it arrives with the module's reports and never goes on the bus."""

from typing import Literal, get_args

import msgspec

from contract.wire.reasons import FaultCode
from vehicle_agent.can.faults import ActiveFault
from vehicle_agent.signals import CanFrame
from vehicle_agent.signals.rates import CAN_FRAME_AGE_NS_MAX

# Unused on both supported buses.
GATE_REPORT_ID = 0x5F0
GATE_LOST_NS = CAN_FRAME_AGE_NS_MAX

# Why the gate brakes, numbered from 1 in this order.
GateCause = Literal[
    "tick_late", "commands_refused", "module_lost", "clock_jumped", "footprint", "too_fast", "steering_stuck"
]
CAUSES: tuple[GateCause, ...] = get_args(GateCause)
FAULTS: dict[GateCause, FaultCode] = {
    "tick_late": "gate_braking_tick_late",
    "commands_refused": "gate_braking_commands_refused",
    "module_lost": "gate_braking_module_lost",
    "clock_jumped": "gate_braking_clock_jumped",
    "footprint": "gate_braking_footprint",
    "too_fast": "gate_braking_too_fast",
    "steering_stuck": "gate_braking_steering_stuck",
}


class GateStatus(msgspec.Struct, frozen=True):
    """stamp_ns: arrival of the newest report, 0 before the first; cause: None without its own braking."""

    stamp_ns: int = 0
    cause: GateCause | None = None

    def active(self, now_ns: int) -> list[ActiveFault]:
        """(code, severity) of the gate's own braking, if the report is recent."""
        fresh = now_ns - self.stamp_ns <= GATE_LOST_NS
        return [(FAULTS[self.cause], "stop")] if self.cause is not None and fresh else []


def gate_report(cause: GateCause | None, stamp_ns: int) -> CanFrame:
    number = 0 if cause is None else CAUSES.index(cause) + 1
    return CanFrame(stamp_ns, GATE_REPORT_ID, bytes([number]))


def take_gate_reports(status: GateStatus, frames: tuple[CanFrame, ...]) -> GateStatus:
    """The status after these frames; frames of other senders and unknown causes are ignored."""
    for frame in frames:
        if frame.arbitration_id == GATE_REPORT_ID and len(frame.data) == 1 and frame.data[0] <= len(CAUSES):
            number = frame.data[0]
            status = GateStatus(frame.stamp_ns, CAUSES[number - 1] if number else None)
    return status
