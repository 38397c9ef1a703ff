"""What the gate must know of a by-wire: the small door behind which PACMod and servo differ."""

from collections.abc import Callable
from typing import Protocol

import msgspec

from vehicle_agent.can.dbc import FrameError, MessageLayout
from vehicle_agent.signals import CanFrame


class CommandSetError(Exception):
    """A tick's frames are not one whole, consistent set of commands; the message says why."""


class CommandedActuation(msgspec.Struct, frozen=True):
    """What a sound set asks for: front-wheel angle, left positive, and pedals of 0..1.

    counter  the set's number, counted on modulo the by-wire's `counter_steps`
    enable   by-wire shall have the vehicle
    """

    counter: int
    enable: bool
    steer_rad: float
    throttle_ratio: float
    brake_ratio: float


Values = dict[str, dict[str, float]]


def unpacked_set(
    frames: tuple[CanFrame, ...],
    names: tuple[str, ...],
    known: dict[str, MessageLayout],
    unpack: Callable[[MessageLayout, bytes], dict[str, float]],
) -> Values:
    """The values of each of the named commands. CommandSetError unless they are these frames, in order."""
    if tuple(frame.arbitration_id for frame in frames) != tuple(known[n].arbitration_id for n in names):
        raise CommandSetError(f"not the {len(names)} command frames in order")
    try:
        return {name: unpack(known[name], frame.data) for name, frame in zip(names, frames, strict=True)}
    except FrameError as error:
        raise CommandSetError(str(error)) from error


class ByWireBraking(Protocol):
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

    def commanded(self, frames: tuple[CanFrame, ...]) -> CommandedActuation:
        """What the set says. Raises CommandSetError unless it is one whole, consistent set."""
        ...

    def braking_frames(
        self, last: tuple[CanFrame, ...], steps: int, now_ns: int, brake_ratio: float = 1.0
    ) -> tuple[CanFrame, ...]:
        """Brake, no throttle, all else as in the last sound set; the counter `steps` further on."""
        ...
