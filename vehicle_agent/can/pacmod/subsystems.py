"""The status byte that each subsystem of the module reports: enabled, override, five faults, timeout."""

from functools import cache

import msgspec

from contract.wire.reasons import FaultCode
from vehicle_agent.can.dbc import MessageLayout, layouts
from vehicle_agent.can.faults import ActiveFault
from vehicle_agent.signals import CanFrame

# By-wire drives only with all of these; their faults stop the vehicle.
DRIVING: dict[str, FaultCode] = {
    "accelerator_report": "bywire_accelerator_fault",
    "brake_report": "bywire_brake_fault",
    "shift_report": "bywire_shift_fault",
    "steering_report": "bywire_steering_fault",
}
# What people outside see and hear; the vehicle drives on without them and the fault is reported.
SIGNALLING: dict[str, FaultCode] = {
    "turn_report": "bywire_signal_fault",
    "horn_report": "bywire_signal_fault",
    "headlight_report": "bywire_signal_fault",
}
SUBSYSTEMS = (*DRIVING, *SIGNALLING)
FAULT_FLAGS = (
    "command_output_fault",
    "input_output_fault",
    "output_reported_fault",
    "bywire_fault",
    "vehicle_fault",
)
_BRAKE = SUBSYSTEMS.index("brake_report")


class Subsystem(msgspec.Struct, frozen=True):
    """One subsystem's newest status; before its first report it hinders nothing.

    A flag of one report among several that arrive in one tick counts for the whole tick.
    """

    enabled: bool = True
    overridden: bool = False
    faulted: bool = False
    timed_out: bool = False
    stamp_ns: int = 0

    def merged(self, newer: "Subsystem") -> "Subsystem":
        """The newer status with the faults of both."""
        return msgspec.structs.replace(
            newer,
            faulted=self.faulted or newer.faulted,
            timed_out=self.timed_out or newer.timed_out,
        )


class Subsystems(msgspec.Struct, frozen=True):
    """The status of each subsystem, in the order of SUBSYSTEMS."""

    each: tuple[Subsystem, ...] = (Subsystem(),) * len(SUBSYSTEMS)

    @property
    def brakes(self) -> bool:
        """The brake is under by-wire control."""
        return self.each[_BRAKE].enabled

    @property
    def drives(self) -> bool:
        """Accelerator, brake, gear and steering are under by-wire control."""
        return all(subsystem.enabled for subsystem in self._driving())

    @property
    def overridden(self) -> bool:
        """The driver has taken a pedal, the wheel or the gear lever, and the subsystem has let go."""
        return any(subsystem.overridden and not subsystem.enabled for subsystem in self._driving())

    @property
    def timed_out(self) -> bool:
        return any(subsystem.timed_out for subsystem in self._driving())

    def lacks_control(self, enabled_ns: int) -> bool:
        """A subsystem reports since `enabled_ns`, when the module said enabled, that it is not."""
        return any(
            not subsystem.enabled and not subsystem.overridden and subsystem.stamp_ns >= enabled_ns
            for subsystem in self._driving()
        )

    def faults(self, enabled: bool) -> list[ActiveFault]:
        """(code, severity) of the subsystems' faults. enabled: the module has the vehicle.

        A subsystem that reports an override and keeps control is at fault: the driver has no vehicle. Signals
        that miss their commands while the module drives are dark, which nobody would notice otherwise.
        """
        found: dict[FaultCode, ActiveFault] = {}
        for name, subsystem in zip(SUBSYSTEMS, self.each, strict=True):
            if name in DRIVING and (subsystem.faulted or (subsystem.overridden and subsystem.enabled)):
                found[DRIVING[name]] = (DRIVING[name], "stop")
            elif name in SIGNALLING and (subsystem.faulted or (enabled and subsystem.timed_out)):
                found[SIGNALLING[name]] = (SIGNALLING[name], "warning")
        return list(found.values())

    def _driving(self) -> tuple[Subsystem, ...]:
        return self.each[: len(DRIVING)]


class _StatusMasks(msgspec.Struct, frozen=True):
    """Bits of the whole frame as one integer."""

    place: int
    layout: MessageLayout
    enabled: int
    overridden: int
    faulted: int
    timed_out: int


@cache
def _masks() -> dict[int, _StatusMasks]:
    masks = {}
    for place, name in enumerate(SUBSYSTEMS):
        layout = layouts()[name]
        bit = {flag: 1 << signal.shift for flag, signal in layout.signals.items()}
        masks[layout.arbitration_id] = _StatusMasks(
            place,
            layout,
            bit["enabled"],
            bit["override_active"],
            sum(bit[flag] for flag in FAULT_FLAGS),
            bit["command_timeout"],
        )
    return masks


def take_subsystems(before: Subsystems, frames: tuple[CanFrame, ...]) -> Subsystems:
    """The status after these frames; frames of a wrong length change nothing."""
    fresh: dict[int, Subsystem] = {}
    masks = _masks()
    for frame in frames:
        mask = masks.get(frame.arbitration_id)
        if mask is None or len(frame.data) != mask.layout.length:
            continue
        word = int.from_bytes(frame.data, "big")
        status = Subsystem(
            bool(word & mask.enabled),
            bool(word & mask.overridden),
            bool(word & mask.faulted),
            bool(word & mask.timed_out),
            frame.stamp_ns,
        )
        earlier = fresh.get(mask.place)
        fresh[mask.place] = status if earlier is None else earlier.merged(status)
    if not fresh:
        return before
    return Subsystems(tuple(fresh.get(place, known) for place, known in enumerate(before.each)))
