"""Getting by-wire: clear overrides in one tick, enable in the next, both at zero pedals.

off -> clear -> enable -> on, and `barred` after the safety driver has taken over: then `enable` must be
dropped once and asked for again, so that nothing takes the vehicle out of a driver's hands.
"""

from typing import Literal

import msgspec

Phase = Literal["off", "clear", "enable", "on", "barred"]

ANSWER_WITHIN_NS = 300_000_000


class Handshake(msgspec.Struct, frozen=True):
    """since_ns: when the phase began; refusals: tries the module has not answered since the last success."""

    phase: Phase = "off"
    since_ns: int = 0
    refusals: int = 0

    @property
    def clears(self) -> bool:
        """This tick's global frame clears overrides."""
        return self.phase == "clear"

    @property
    def enables(self) -> bool:
        """This tick's frames carry the enable bit."""
        return self.phase in ("enable", "on")

    @property
    def live(self) -> bool:
        """Pedal commands may be other than zero."""
        return self.phase == "on"


def advance(shake: Handshake, wanted: bool, enabled: bool, overridden: bool, now_ns: int) -> Handshake:
    """The handshake of this tick, from what the guard wants and what the module last reported.

    A module that drops out without the driver's doing (a timeout) is asked again at once: without by-wire
    nobody could brake.
    """
    if not wanted:
        return Handshake("off", now_ns) if shake.phase != "off" else shake
    match shake.phase:
        case "off":
            return Handshake("clear", now_ns, shake.refusals)
        case "clear":
            return Handshake("enable", now_ns, shake.refusals)
        case "enable" if enabled and not overridden:
            return Handshake("on", now_ns)
        case "enable" if now_ns - shake.since_ns > ANSWER_WITHIN_NS:
            phase: Phase = "barred" if overridden else "clear"
            return Handshake(phase, now_ns, shake.refusals + 1)
        case "on" if overridden:
            return Handshake("barred", now_ns)
        case "on" if not enabled:
            return Handshake("clear", now_ns)
        case _:
            return shake
