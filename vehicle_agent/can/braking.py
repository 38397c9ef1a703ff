"""What the gate must know of a by-wire: the small door behind which PACMod and servo differ."""

from typing import Protocol

from vehicle_agent.signals import CanFrame


class CommandSetError(Exception):
    """A tick's frames are not one whole, consistent set of commands; the message says why."""


class Braking(Protocol):
    """Stateless; one for each kind of by-wire (`vehicle_agent.can.by_wire`).

    frame_gap_ns  the pause that the module wants between two frames
    """

    frame_gap_ns: int

    def command_ids(self) -> frozenset[int]:
        """Identifiers of the commands: what the gate itself sends."""
        ...

    def checked_counter(self, frames: tuple[CanFrame, ...]) -> int:
        """The set's counter. Raises CommandSetError unless it is one whole, consistent set."""
        ...

    def braking_frames(self, last: tuple[CanFrame, ...], steps: int, now_ns: int) -> tuple[CanFrame, ...]:
        """Full brake, no throttle, all else as in the last sound set; the counter `steps` further on."""
        ...
