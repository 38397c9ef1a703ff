"""The CAN bus of one vehicle in virtual time: ordered lists, without loss except for injected `faults`."""

from simulator.ecus.bus_faults import BusFaults
from vehicle_agent.signals import CanFrame


class ListBus:
    """Frames in the order of their stamps, in both directions."""

    def __init__(self) -> None:
        self.faults = BusFaults()
        self._to_vehicle: list[CanFrame] = []
        self._to_module: list[CanFrame] = []

    def send_from_vehicle(self, frames: tuple[CanFrame, ...]) -> None:
        self._to_module.extend(self.faults.to_module(frames))

    def send_from_module(self, frames: tuple[CanFrame, ...]) -> None:
        self._to_vehicle.extend(self.faults.to_vehicle(frames))

    def take_for_vehicle(self) -> tuple[CanFrame, ...]:
        """Everything since the last call, oldest first; frames of one stamp in sending order."""
        frames, self._to_vehicle = self._to_vehicle, []
        return tuple(sorted(frames, key=_stamp))

    def take_for_module(self, until_ns: int) -> tuple[CanFrame, ...]:
        """Frames stamped up to until_ns; later ones stay on the bus."""
        ordered = sorted(self._to_module, key=_stamp)
        self._to_module = [frame for frame in ordered if frame.stamp_ns > until_ns]
        return tuple(frame for frame in ordered if frame.stamp_ns <= until_ns)


def _stamp(frame: CanFrame) -> int:
    return frame.stamp_ns
