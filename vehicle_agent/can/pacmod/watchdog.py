"""What the module's watchdog and its components report: faults beside the status bytes of the subsystems.

A system of this kind has up to six components (three PACMod and three PACMini); each reports for itself. A
component that never reports is not there. The watchdog repeats the subsystems' faults, and has the missing
and faulty parts of the system.
"""

from functools import cache

import msgspec

from contract.wire.reasons import FaultCode
from vehicle_agent.can.dbc import MessageLayout, SignalLayout, layouts
from vehicle_agent.can.faults import ActiveFault
from vehicle_agent.can.pacmod.subsystems import DRIVING, FAULT_FLAGS, SIGNALLING
from vehicle_agent.signals import CanFrame

COMPONENTS = (
    "component_report",
    *(f"component_{number}_report" for number in range(2, 7)),
)
WATCHDOGS = ("watchdog_report", "watchdog_report_2")
COMPONENT_COUNTER_STEPS = 16
# A component that has reported and is silent, or repeats its counter, for this long is at fault.
COMPONENT_LOST_NS = 500_000_000
# Codes of a component's two-bit states: 2 is an error or unused, 3 not available.
_YES = 1
_READY = (1, 3)
# A warning of this level or above is for a stop; levels below it are reported.
SEVERE_LEVEL = 3

# Flags of the watchdog's reports by what they mean; flags that no row names repeat what other reports say.
_PARTS = tuple(f"{kind}_{number}" for kind in ("pacmod", "pacmini") for number in (1, 2, 3))
_FLAGS: dict[str, dict[FaultCode, tuple[str, ...]]] = {
    "watchdog_report": {
        "bywire_fault": ("fault_active", "config_fault"),
        "bywire_component_fault": (
            *(f"{part}_{what}" for part in _PARTS for what in ("config_fault", "counter_fault")),
            "pacmod_present_fault",
            "pacmini_present_fault",
            "supply_fault",
        ),
        "bywire_timeout": (
            "computer_timeout",
            "subsystem_timeout",
            "vehicle_timeout",
            "global_timeout",
            *(f"{name.removesuffix('_report')}_timeout" for name in DRIVING),
            *(f"{part}_can_timeout" for part in _PARTS),
            *(f"{part}_report_timeout" for part in _PARTS[3:]),
        ),
        **{
            code: tuple(f"{name.removesuffix('_report')}_{flag}" for flag in FAULT_FLAGS)
            for name, code in DRIVING.items()
        },
    },
    "watchdog_report_2": {
        "bywire_component_fault": (
            *(
                f"{part}_{what}"
                for part in _PARTS
                for what in ("sanity_fault", "component_timeout", "present_fault")
            ),
            "drive_mode_invalid",
            "command_sanity_fault",
        ),
        "bywire_timeout": (
            "command_timeout",
            *(f"{name.removesuffix('_report')}_timeout" for name in DRIVING),
        ),
        "bywire_signal_fault": tuple(f"{name.removesuffix('_report')}_timeout" for name in SIGNALLING),
    },
}


class Component(msgspec.Struct, frozen=True):
    """One component's newest report; stamp_ns: when its counter last moved on, 0 before its first report."""

    counter: int = -1
    stamp_ns: int = 0
    faulted: bool = False
    warned: bool = False


class Watchdog(msgspec.Struct, frozen=True):
    """The components in the order of COMPONENTS, and the codes in each of the watchdog's newest reports."""

    components: tuple[Component, ...] = (Component(),) * len(COMPONENTS)
    flagged: tuple[frozenset[FaultCode], ...] = (frozenset(), frozenset())

    @property
    def timed_out(self) -> bool:
        return any("bywire_timeout" in codes for codes in self.flagged)

    @property
    def faulted(self) -> bool:
        """The watchdog says that the module as a whole is at fault."""
        return any("bywire_fault" in codes for codes in self.flagged)

    def faults(self, now_ns: int) -> list[ActiveFault]:
        """(code, severity) of the faults of components and of those that the watchdog sees in subsystems."""
        codes: set[FaultCode] = set().union(*self.flagged) - {"bywire_timeout", "bywire_fault"}
        if any(component.faulted for component in self.components):
            codes.add("bywire_component_fault")
        if any(c.stamp_ns and now_ns - c.stamp_ns > COMPONENT_LOST_NS for c in self.components):
            codes.add("can_component_report_lost")
        found: list[ActiveFault] = [
            (code, "warning" if code == "bywire_signal_fault" else "stop") for code in sorted(codes)
        ]
        if "bywire_component_fault" not in codes and any(component.warned for component in self.components):
            found.append(("bywire_component_fault", "warning"))
        return found


class _ComponentReader(msgspec.Struct, frozen=True):
    place: int
    layout: MessageLayout
    faults: tuple[SignalLayout, ...]


@cache
def _components() -> dict[int, _ComponentReader]:
    readers = {}
    for place, name in enumerate(COMPONENTS):
        layout = layouts()[name]
        faults = tuple(layout.signals[flag] for flag in ("config_fault", "supply_fault", "watchdog_fault"))
        readers[layout.arbitration_id] = _ComponentReader(place, layout, faults)
    return readers


@cache
def _watchdogs() -> dict[int, tuple[int, MessageLayout, tuple[tuple[FaultCode, int], ...]]]:
    """By identifier: the report's place, its layout, and the bits of each code on the frame as an integer."""
    readers = {}
    for place, name in enumerate(WATCHDOGS):
        layout = layouts()[name]
        masks = tuple(
            (code, sum(1 << layout.signals[flag].shift for flag in flags))
            for code, flags in _FLAGS[name].items()
        )
        readers[layout.arbitration_id] = (place, layout, masks)
    return readers


def take_watchdog(before: Watchdog, frames: tuple[CanFrame, ...]) -> Watchdog:
    """What is known after these frames; frames of a wrong length change nothing.

    A flag of one report among several that arrive in one tick counts for the whole tick.
    """
    components: dict[int, Component] = {}
    flagged: dict[int, frozenset[FaultCode]] = {}
    for frame in frames:
        reader = _components().get(frame.arbitration_id)
        if reader is not None and len(frame.data) == reader.layout.length:
            earlier = components.get(reader.place)
            known = earlier or before.components[reader.place]
            new = _component(reader, known, frame)
            if earlier is not None:
                new = msgspec.structs.replace(
                    new, faulted=new.faulted or earlier.faulted, warned=new.warned or earlier.warned
                )
            components[reader.place] = new
            continue
        watchdog = _watchdogs().get(frame.arbitration_id)
        if watchdog is not None and len(frame.data) == watchdog[1].length:
            place, _, masks = watchdog
            word = int.from_bytes(frame.data, "big")
            codes = frozenset(code for code, mask in masks if word & mask)
            flagged[place] = flagged.get(place, frozenset()) | codes
    if not components and not flagged:
        return before
    return Watchdog(
        tuple(components.get(place, known) for place, known in enumerate(before.components)),
        tuple(flagged.get(place, known) for place, known in enumerate(before.flagged)),
    )


def _component(reader: _ComponentReader, before: Component, frame: CanFrame) -> Component:
    """The component after its report. A counter that stands still, or without its complement, is no life."""
    word = int.from_bytes(frame.data, "big")
    signals = reader.layout.signals
    counter, complement = round(signals["counter"].read(word)), round(signals["complement"].read(word))
    lives = counter != before.counter and counter + complement == COMPONENT_COUNTER_STEPS - 1
    level = round(signals["warning_level"].read(word))
    return Component(
        counter,
        # A first report that is no life starts the time until it is missed.
        frame.stamp_ns if lives or not before.stamp_ns else before.stamp_ns,
        any(round(signal.read(word)) == _YES for signal in reader.faults)
        or round(signals["ready"].read(word)) not in _READY
        or level >= SEVERE_LEVEL,
        0 < level < SEVERE_LEVEL,
    )
