"""Injected faults of a CAN bus: lost and corrupted frames."""

from collections.abc import Callable

from vehicle_agent.signals import CanFrame

Frames = tuple[CanFrame, ...]


def flipped(frame: CanFrame, bit: int) -> CanFrame:
    """The frame with one bit of its data inverted, counted from the first byte's highest bit."""
    place = bit % (8 * len(frame.data))
    data = bytearray(frame.data)
    data[place // 8] ^= 0x80 >> place % 8
    return CanFrame(frame.stamp_ns, frame.arbitration_id, bytes(data))


def unchanged(frames: Frames) -> Frames:
    return frames


class BusFaults:
    """Faults of one vehicle's bus, in both directions; none at first.

    filter_to_module, filter_to_vehicle  change the frames of a step to those that arrive
    changed_to_vehicle  number of reports that did not arrive as they were sent
    """

    def __init__(self) -> None:
        self.loses_to_module = False
        self.loses_to_vehicle = False
        self.changed_to_vehicle = 0
        self.filter_to_module: Callable[[Frames], Frames] = unchanged
        self.filter_to_vehicle: Callable[[Frames], Frames] = unchanged

    def to_module(self, frames: Frames) -> Frames:
        return () if self.loses_to_module else self.filter_to_module(frames)

    def to_vehicle(self, frames: Frames) -> Frames:
        arrived = () if self.loses_to_vehicle else self.filter_to_vehicle(frames)
        self.changed_to_vehicle += len(set(frames) - set(arrived))
        return arrived
