"""The gate's report to the tick: it arrives with the module's reports and never goes on the bus."""

from typing import Literal, get_args

import msgspec

from vehicle_agent.can.faults import Severity
from vehicle_agent.signals import GATE_BRAKING, CanFrame

# Unused on both supported buses.
GATE_REPORT_ID = 0x5F0
GATE_LOST_NS = 150_000_000

# Why the gate brakes: the end of the fault's code, numbered from 1 in this order.
GateCause = Literal[
    "tick_late", "commands_refused", "module_lost", "clock_jumped", "footprint", "too_fast", "steering_stuck"
]
CAUSES: tuple[GateCause, ...] = get_args(GateCause)


class GateStatus(msgspec.Struct, frozen=True):
    """stamp_ns: arrival of the newest report, 0 before the first; cause: None without its own braking."""

    stamp_ns: int = 0
    cause: GateCause | None = None

    def active(self, now_ns: int) -> list[tuple[str, Severity]]:
        """(code, severity) of the gate's own braking, if the report is recent."""
        fresh = now_ns - self.stamp_ns <= GATE_LOST_NS
        return [(f"{GATE_BRAKING}_{self.cause}", "stop")] if self.cause is not None and fresh else []


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
