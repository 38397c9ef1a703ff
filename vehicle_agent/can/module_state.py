"""A codec's state and the faults of its by-wire module, the same for every kind."""

from typing import TypeVar

import msgspec

from contract.wire.reasons import FaultCode
from vehicle_agent.can.faults import ActiveFault, with_start_times
from vehicle_agent.can.gate_report import GateStatus, take_gate_reports
from vehicle_agent.can.handshake import Handshake
from vehicle_agent.signals import CanFrame, Fault
from vehicle_agent.signals.rates import CAN_FRAME_AGE_NS_MAX

REPORT_LOST_NS = CAN_FRAME_AGE_NS_MAX
BOOT_GRACE_NS = 1_000_000_000
REFUSALS_MAX = 3
MALFORMED_SHOWN_NS = 1_000_000_000


class CodecState(msgspec.Struct, frozen=True):
    """boot_ns: stamp of the first tick, 0 before it. A kind of by-wire adds its reports."""

    handshake: Handshake = Handshake()
    counter: int = 0
    boot_ns: int = 0
    overridden: bool = False
    faults: tuple[Fault, ...] = ()
    gate: GateStatus = GateStatus()


class ModuleStatus(msgspec.Struct, frozen=True):
    """The module's own state, from its reports.

    enabled, enabled_ns  by-wire controls the vehicle; stamp of that report
    stamps_ns            arrival of each cyclic report, by the fault of its loss
    malformed_ns         arrival of the last report that could not be read, 0 before the first
    """

    enabled: bool
    enabled_ns: int
    overridden: bool
    stop_pressed: bool
    faulted: bool
    timed_out: bool
    stamps_ns: tuple[tuple[FaultCode, int], ...]
    malformed_ns: int

    def has_vehicle(self, now_ns: int) -> bool:
        """By-wire controls the vehicle, by a recent report."""
        return self.enabled and now_ns - self.enabled_ns <= REPORT_LOST_NS


State = TypeVar("State", bound=CodecState)


def with_faults(state: State, status: ModuleStatus, frames: tuple[CanFrame, ...], now_ns: int) -> State:
    """The state after this tick's frames: overridden until by-wire is enabled again, and all faults."""
    boot_ns = state.boot_ns or now_ns
    gate = take_gate_reports(state.gate, frames)
    active = _active(status, state.handshake, boot_ns, now_ns) + gate.active(now_ns)
    return msgspec.structs.replace(
        state,
        boot_ns=boot_ns,
        overridden=status.overridden or (state.overridden and not status.has_vehicle(now_ns)),
        faults=with_start_times(active, state.faults, now_ns),
        gate=gate,
    )


def _active(status: ModuleStatus, handshake: Handshake, boot_ns: int, now_ns: int) -> list[ActiveFault]:
    """(code, severity) of all present faults, in a fixed order."""
    driving = handshake.phase == "on"
    faults: list[ActiveFault] = []
    if now_ns - boot_ns > BOOT_GRACE_NS:
        for lost, stamp_ns in status.stamps_ns:
            if now_ns - stamp_ns > REPORT_LOST_NS:
                faults.append((lost, "stop"))
    if status.stop_pressed:
        faults.append(("emergency_stop_pressed", "stop"))
    if status.faulted:
        faults.append(("bywire_fault", "stop"))
    if status.timed_out:
        faults.append(("bywire_timeout", "stop" if driving else "info"))
    if driving and not status.enabled and not status.overridden:
        faults.append(("bywire_lost", "stop"))
    if handshake.refusals >= REFUSALS_MAX:
        faults.append(("bywire_refuses_enable", "stop"))
    if status.malformed_ns and now_ns - status.malformed_ns <= MALFORMED_SHOWN_NS:
        faults.append(("can_frame_malformed", "warning"))
    return faults
