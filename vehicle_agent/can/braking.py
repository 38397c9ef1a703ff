"""What the gate must know of a by-wire: the small door behind which PACMod and servo differ."""

from typing import Protocol

import msgspec

from vehicle_agent.signals import CanFrame


class CommandSetError(Exception):
    """A tick's frames are not one whole, consistent set of commands; the message says why."""


class Commanded(msgspec.Struct, frozen=True):
    """What a sound set asks for: front-wheel angle, left positive, and pedals of 0..1.

    counter  the set's number, counted on modulo the by-wire's `counter_steps`
    enable   by-wire shall have the vehicle
    """

    counter: int
    enable: bool
    steer_rad: float
    throttle_ratio: float
    brake_ratio: float


class Braking(Protocol):
    """Stateless; one for each kind of by-wire (`vehicle_agent.can.by_wire`).

    frame_gap_ns   the pause that the module wants between two frames
    counter_steps  a set's counter runs from 0 to one less
    """

    @property
    def frame_gap_ns(self) -> int: ...
    @property
    def counter_steps(self) -> int: ...

    def command_ids(self) -> frozenset[int]:
        """Identifiers of the commands: what the gate itself sends."""
        ...

    def commanded(self, frames: tuple[CanFrame, ...]) -> Commanded:
        """What the set says. Raises CommandSetError unless it is one whole, consistent set."""
        ...

    def braking_frames(
        self, last: tuple[CanFrame, ...], steps: int, now_ns: int, brake_ratio: float = 1.0
    ) -> tuple[CanFrame, ...]:
        """Brake, no throttle, all else as in the last sound set; the counter `steps` further on."""
        ...
