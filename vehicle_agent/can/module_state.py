"""A codec's state and the faults of its by-wire module, the same for every kind."""

from typing import TypeVar

import msgspec

from contract.wire.reasons import FaultCode, FaultSeverity
from vehicle_agent.can.faults import ActiveFault, with_start_times
from vehicle_agent.can.gate_report import GateStatus, take_gate_reports
from vehicle_agent.can.handshake import Handshake
from vehicle_agent.signals import CanFrame, Fault
from vehicle_agent.signals.rates import CAN_FRAME_AGE_NS_MAX

REPORT_LOST_NS = CAN_FRAME_AGE_NS_MAX
BOOT_GRACE_NS = 1_000_000_000
REFUSALS_MAX = 3
MALFORMED_SHOWN_NS = 1_000_000_000
# A fault that the module reports lasts this long after the last report of it: one that comes and goes with
# each frame is one fault, and one of a single frame is seen.
FAULT_SHOWN_NS = 1_000_000_000


class ReportedFault(msgspec.Struct, frozen=True):
    """A fault that the module itself reports; last_ns: stamp of the newest tick with it."""

    code: FaultCode
    severity: FaultSeverity
    last_ns: int


class CodecState(msgspec.Struct, frozen=True):
    """boot_ns: stamp of the first tick, 0 before it. A kind of by-wire adds its reports."""

    handshake: Handshake = Handshake()
    counter: int = 0
    boot_ns: int = 0
    overridden: bool = False
    faults: tuple[Fault, ...] = ()
    gate: GateStatus = GateStatus()
    reported: tuple[ReportedFault, ...] = ()


class ModuleStatus(msgspec.Struct, frozen=True):
    """The module's own state, from its reports.

    enabled, enabled_ns  by-wire controls the vehicle; stamp of that report
    stamps_ns            arrival of each cyclic report, by the fault of its loss
    malformed_ns         arrival of the last report that could not be read, 0 before the first
    stop_button_faulted  the module does not know whether the button is pressed
    in_part              enabled, but a subsystem that driving needs is not
    subsystem_faults     (code, severity) of faults of single subsystems
    """

    enabled: bool
    enabled_ns: int
    overridden: bool
    stop_pressed: bool
    faulted: bool
    timed_out: bool
    stamps_ns: tuple[tuple[FaultCode, int], ...]
    malformed_ns: int
    stop_button_faulted: bool = False
    in_part: bool = False
    subsystem_faults: tuple[ActiveFault, ...] = ()

    @property
    def has_fault(self) -> bool:
        """The module, or a subsystem that driving needs, reports a fault."""
        return self.faulted or any(severity == "stop" for _, severity in self.subsystem_faults)

    @property
    def refuses(self) -> bool:
        """By-wire is not requested while it is off: the module is at fault, or the stop button is pressed."""
        return self.has_fault or self.stop_pressed or self.stop_button_faulted

    def has_vehicle(self, now_ns: int) -> bool:
        """By-wire controls the vehicle, by a recent report."""
        return self.enabled and now_ns - self.enabled_ns <= REPORT_LOST_NS


State = TypeVar("State", bound=CodecState)


def with_faults(state: State, status: ModuleStatus, frames: tuple[CanFrame, ...], now_ns: int) -> State:
    """The state after this tick's frames: overridden until by-wire is enabled again, and all faults."""
    boot_ns = state.boot_ns or now_ns
    gate = take_gate_reports(state.gate, frames)
    reported = _still_reported(_reported(status, state.handshake), state.reported, now_ns)
    active = _active(status, state, boot_ns, now_ns) + gate.active(now_ns)
    active += [(fault.code, fault.severity) for fault in reported]
    return msgspec.structs.replace(
        state,
        boot_ns=boot_ns,
        overridden=status.overridden or (state.overridden and not status.has_vehicle(now_ns)),
        faults=with_start_times(active, state.faults, now_ns),
        gate=gate,
        reported=reported,
    )


def _still_reported(
    active: list[ActiveFault], before: tuple[ReportedFault, ...], now_ns: int
) -> tuple[ReportedFault, ...]:
    """The faults that the module reports or has reported shortly ago, in order of their codes."""
    kept = {fault.code: fault for fault in before if 0 <= now_ns - fault.last_ns <= FAULT_SHOWN_NS}
    kept |= {code: ReportedFault(code, severity, now_ns) for code, severity in active}
    return tuple(kept[code] for code in sorted(kept))


def _reported(status: ModuleStatus, handshake: Handshake) -> list[ActiveFault]:
    """(code, severity) of the faults in the module's newest reports."""
    driving = handshake.phase == "on"
    faults: list[ActiveFault] = list(status.subsystem_faults)
    if status.stop_pressed:
        faults.append(("emergency_stop_pressed", "stop"))
    if status.stop_button_faulted:
        faults.append(("stop_button_fault", "stop"))
    if status.faulted:
        faults.append(("bywire_fault", "stop"))
    if status.in_part:
        faults.append(("bywire_lost_in_part", "stop" if driving else "warning"))
    if status.timed_out and driving:
        faults.append(("bywire_timeout", "stop"))
    return faults


def _active(status: ModuleStatus, state: CodecState, boot_ns: int, now_ns: int) -> list[ActiveFault]:
    """(code, severity) of the faults that are there in this tick only, in a fixed order."""
    driving = state.handshake.phase == "on"
    faults: list[ActiveFault] = []
    if now_ns - boot_ns > BOOT_GRACE_NS:
        for lost, stamp_ns in status.stamps_ns:
            if now_ns - stamp_ns > REPORT_LOST_NS:
                faults.append((lost, "stop"))
    if status.timed_out and not driving:
        faults.append(("bywire_timeout", "info"))
    if driving and not status.enabled and not status.overridden:
        faults.append(("bywire_lost", "stop"))
    if state.handshake.refusals >= REFUSALS_MAX:
        faults.append(("bywire_refuses_enable", "stop"))
    if status.malformed_ns and now_ns - status.malformed_ns <= MALFORMED_SHOWN_NS:
        faults.append(("can_frame_malformed", "warning"))
    return faults
