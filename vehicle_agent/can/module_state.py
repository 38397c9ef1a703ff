"""What a codec remembers of its by-wire module, and what may be wrong with it: alike for every kind."""

from typing import TypeVar

import msgspec

from contract.wire.reasons import FaultCode
from vehicle_agent.can.faults import ActiveFault, since
from vehicle_agent.can.gate_report import GateStatus, heard_gate
from vehicle_agent.can.handshake import Handshake
from vehicle_agent.signals import CanFrame, Fault
from vehicle_agent.signals.rates import CAN_FRAME_AGE_NS_MAX

REPORT_LOST_NS = CAN_FRAME_AGE_NS_MAX
BOOT_GRACE_NS = 1_000_000_000
REFUSALS_MAX = 3
MALFORMED_SHOWN_NS = 1_000_000_000


class CodecState(msgspec.Struct, frozen=True):
    """boot_ns: stamp of the first tick; 0 before it. A kind of by-wire adds its reports."""

    handshake: Handshake = Handshake()
    counter: int = 0
    boot_ns: int = 0
    overridden: bool = False
    faults: tuple[Fault, ...] = ()
    gate: GateStatus = GateStatus()


class ModuleStatus(msgspec.Struct, frozen=True):
    """What a module's reports say of the module itself.

    enabled, enabled_ns  by-wire has the vehicle, as reported when
    stamps_ns            arrival of each report that must keep coming, by the fault of its loss
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
        """By-wire has the vehicle, as far as was heard lately."""
        return self.enabled and now_ns - self.enabled_ns <= REPORT_LOST_NS


State = TypeVar("State", bound=CodecState)


def watched(state: State, word: ModuleStatus, frames: tuple[CanFrame, ...], now_ns: int) -> State:
    """After this tick's frames: overridden until by-wire is had anew, and every fault with its beginning."""
    boot_ns = state.boot_ns or now_ns
    gate = heard_gate(state.gate, frames)
    active = _active(word, state.handshake, boot_ns, now_ns) + gate.active(now_ns)
    return msgspec.structs.replace(
        state,
        boot_ns=boot_ns,
        overridden=word.overridden or (state.overridden and not word.has_vehicle(now_ns)),
        faults=since(active, state.faults, now_ns),
        gate=gate,
    )


def _active(word: ModuleStatus, shake: Handshake, boot_ns: int, now_ns: int) -> list[ActiveFault]:
    """(code, severity) of everything wrong now, in a fixed order."""
    driving = shake.phase == "on"
    faults: list[ActiveFault] = []
    if now_ns - boot_ns > BOOT_GRACE_NS:
        for lost, stamp_ns in word.stamps_ns:
            if now_ns - stamp_ns > REPORT_LOST_NS:
                faults.append((lost, "stop"))
    if word.stop_pressed:
        faults.append(("emergency_stop_pressed", "stop"))
    if word.faulted:
        faults.append(("bywire_fault", "stop"))
    if word.timed_out:
        faults.append(("bywire_timeout", "stop" if driving else "info"))
    if driving and not word.enabled and not word.overridden:
        faults.append(("bywire_lost", "stop"))
    if shake.refusals >= REFUSALS_MAX:
        faults.append(("bywire_refuses_enable", "stop"))
    if word.malformed_ns and now_ns - word.malformed_ns <= MALFORMED_SHOWN_NS:
        faults.append(("can_frame_malformed", "warning"))
    return faults
