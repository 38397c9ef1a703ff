"""The gate's own word to the tick: it comes with the module's reports, and never goes on the bus."""

import msgspec

from vehicle_agent.can.faults import Severity
from vehicle_agent.signals import GATE_BRAKING, CanFrame

# Free on both buses that we know.
GATE_REPORT_ID = 0x5F0
GATE_LOST_NS = 150_000_000


class GateWord(msgspec.Struct, frozen=True):
    """stamp_ns: arrival of the newest word, 0 before the first."""

    stamp_ns: int = 0
    braking: bool = False

    def active(self, now_ns: int) -> list[tuple[str, Severity]]:
        """The gate brakes by itself, as far as was heard lately."""
        fresh = now_ns - self.stamp_ns <= GATE_LOST_NS
        return [(GATE_BRAKING, "stop")] if self.braking and fresh else []


def gate_report(braking: bool, stamp_ns: int) -> CanFrame:
    return CanFrame(stamp_ns, GATE_REPORT_ID, bytes([braking]))


def heard_gate(word: GateWord, frames: tuple[CanFrame, ...]) -> GateWord:
    """The newest word after these frames; frames of everybody else pass by."""
    for frame in frames:
        if frame.arbitration_id == GATE_REPORT_ID and len(frame.data) == 1:
            word = GateWord(frame.stamp_ns, bool(frame.data[0]))
    return word
