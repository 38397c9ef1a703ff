"""Enabling by-wire: clear overrides in one tick, enable in the next, both at zero pedals.

off -> clear -> enable -> on. `barred` follows a takeover by the safety driver: the request must then end once
and be made again, so that the vehicle is never taken from a driver.
"""

from typing import Literal

import msgspec

Phase = Literal["off", "clear", "enable", "on", "barred"]

ANSWER_WITHIN_NS = 300_000_000


class Handshake(msgspec.Struct, frozen=True):
    """since_ns: when the phase began; refusals: requests without an answer since the last success."""

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
    def is_on(self) -> bool:
        """Pedal commands may be other than zero."""
        return self.phase == "on"


def advance(handshake: Handshake, requested: bool, enabled: bool, overridden: bool, now_ns: int) -> Handshake:
    """The handshake of this tick, from the guard's request and the module's last report.

    A module that drops out without the driver (a timeout) is requested again at once: without by-wire the
    vehicle cannot brake.
    """
    if not requested:
        return Handshake("off", now_ns) if handshake.phase != "off" else handshake
    match handshake.phase:
        case "off":
            return Handshake("clear", now_ns, handshake.refusals)
        case "clear":
            return Handshake("enable", now_ns, handshake.refusals)
        case "enable" if enabled and not overridden:
            return Handshake("on", now_ns)
        case "enable" if now_ns - handshake.since_ns > ANSWER_WITHIN_NS:
            phase: Phase = "barred" if overridden else "clear"
            return Handshake(phase, now_ns, handshake.refusals + 1)
        case "on" if overridden:
            return Handshake("barred", now_ns)
        case "on" if not enabled:
            return Handshake("clear", now_ns)
        case _:
            return handshake
