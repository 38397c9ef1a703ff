"""The module's reports as motion, for a reader without the tick's state: the gate."""

from typing import Generic, Protocol, TypeVar

from vehicle_agent.signals import CanFrame, VehicleMotion

State = TypeVar("State")


class ReportDecoder(Protocol[State]):
    """The decoding half of a codec."""

    def initial(self) -> State: ...
    def decode(
        self, state: State, frames: tuple[CanFrame, ...], now_ns: int
    ) -> tuple[VehicleMotion, State]: ...


class MotionReports(Protocol):
    """Decodes frames to the vehicle's motion; earlier reports are remembered."""

    def decode(self, frames: tuple[CanFrame, ...], now_ns: int) -> VehicleMotion: ...


class DecodedReports(Generic[State]):
    """`MotionReports` by a codec; keeps the codec's state."""

    def __init__(self, codec: ReportDecoder[State]) -> None:
        self._codec = codec
        self._state = codec.initial()

    def decode(self, frames: tuple[CanFrame, ...], now_ns: int) -> VehicleMotion:
        motion, self._state = self._codec.decode(self._state, frames, now_ns)
        return motion
