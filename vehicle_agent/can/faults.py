"""Since when each fault has been there."""

from contract.wire.reasons import FaultCode, FaultSeverity
from vehicle_agent.signals import Fault

ActiveFault = tuple[FaultCode, FaultSeverity]


def since(active: list[ActiveFault], before: tuple[Fault, ...], now_ns: int) -> tuple[Fault, ...]:
    """Active faults with the time each began, taken from the last tick where it was there already."""
    if not active:
        return ()
    began = {(fault.code, fault.severity): fault.since_ns for fault in before}
    return tuple(Fault(code, severity, began.get((code, severity), now_ns)) for code, severity in active)
