"""What a bad bus does to frames: some never arrive, some arrive with a wrong bit."""

from collections.abc import Callable

from vehicle_agent.signals import CanFrame

Frames = tuple[CanFrame, ...]


def flipped(frame: CanFrame, bit: int) -> CanFrame:
    """The frame with one bit of its data, counted from the first byte's highest, the other way round."""
    place = bit % (8 * len(frame.data))
    data = bytearray(frame.data)
    data[place // 8] ^= 0x80 >> place % 8
    return CanFrame(frame.stamp_ns, frame.arbitration_id, bytes(data))


def unharmed(frames: Frames) -> Frames:
    return frames


class BusFaults:
    """Of one vehicle's bus, both ways; a sound bus at first.

    spoil_to_module, spoil_to_vehicle  make of the frames of a step what arrives
    spoiled_to_vehicle  reports that were not let through as they were sent
    """

    def __init__(self) -> None:
        self.loses_to_module = False
        self.loses_to_vehicle = False
        self.spoiled_to_vehicle = 0
        self.spoil_to_module: Callable[[Frames], Frames] = unharmed
        self.spoil_to_vehicle: Callable[[Frames], Frames] = unharmed

    def to_module(self, frames: Frames) -> Frames:
        return () if self.loses_to_module else self.spoil_to_module(frames)

    def to_vehicle(self, frames: Frames) -> Frames:
        arrived = () if self.loses_to_vehicle else self.spoil_to_vehicle(frames)
        self.spoiled_to_vehicle += len(set(frames) - set(arrived))
        return arrived
