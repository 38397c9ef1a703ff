"""The gate's interface to a by-wire: what PACMod and servo do differently for checks and braking."""

from collections.abc import Callable
from typing import Protocol

import msgspec

from vehicle_agent.can.dbc import FrameError, MessageLayout
from vehicle_agent.signals import CanFrame


class CommandSetError(Exception):
    """A tick's frames are not one complete, consistent set of commands; the message says why."""


class CommandedActuation(msgspec.Struct, frozen=True):
    """The actuation that a valid set commands: front-wheel angle, left positive, and pedals of 0..1.

    counter  the set's number, modulo the by-wire's `counter_steps`
    enable   by-wire is requested
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
    """The values of each named command. CommandSetError unless the frames are these, in order."""
    if tuple(frame.arbitration_id for frame in frames) != tuple(known[n].arbitration_id for n in names):
        raise CommandSetError(f"not the {len(names)} command frames in order")
    try:
        return {name: unpack(known[name], frame.data) for name, frame in zip(names, frames, strict=True)}
    except FrameError as error:
        raise CommandSetError(str(error)) from error


class ByWireBraking(Protocol):
    """Stateless; one for each kind of by-wire (`vehicle_agent.can.by_wire`).

    frame_gap_ns   the pause that the module needs between two frames
    counter_steps  a set's counter runs from 0 to one less
    """

    @property
    def frame_gap_ns(self) -> int: ...
    @property
    def counter_steps(self) -> int: ...

    def command_ids(self) -> frozenset[int]:
        """Identifiers of the command frames, which the gate sends itself."""
        ...

    def commanded(self, frames: tuple[CanFrame, ...]) -> CommandedActuation:
        """The actuation of a set. Raises CommandSetError unless it is one complete, consistent set."""
        ...

    def braking_frames(
        self, last: tuple[CanFrame, ...], steps: int, now_ns: int, brake_ratio: float
    ) -> tuple[CanFrame, ...]:
        """Frames that brake, without throttle, else as in the last valid set; the counter `steps` later."""
        ...
