"""The start time of each fault."""

from contract.wire.reasons import FaultCode, FaultSeverity
from vehicle_agent.signals import Fault

ActiveFault = tuple[FaultCode, FaultSeverity]


def with_start_times(active: list[ActiveFault], before: tuple[Fault, ...], now_ns: int) -> tuple[Fault, ...]:
    """The active faults; one that was active in the last tick keeps its start time."""
    if not active:
        return ()
    started = {(fault.code, fault.severity): fault.since_ns for fault in before}
    return tuple(Fault(code, severity, started.get((code, severity), now_ns)) for code, severity in active)
