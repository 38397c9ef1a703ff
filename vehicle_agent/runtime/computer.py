"""The vehicle computer without its devices: state, tick and recorder, for live, virtual time and replay."""

from collections.abc import Sequence

from vehicle_agent.onboard.car import Car
from vehicle_agent.onboard.state import OnboardState
from vehicle_agent.onboard.tick import tick
from vehicle_agent.runtime.inbox import inputs_from
from vehicle_agent.runtime.recording.recorder import Recorder, RunLogEntry
from vehicle_agent.signals import InboxItem, LinkState, Outputs


class VehicleComputer:
    """entries: the run-log entries of the last tick."""

    def __init__(
        self, car: Car, state: OnboardState, recorder: Recorder | None = None, utc_offset_ns: int = 0
    ) -> None:
        """utc_offset_ns  UTC minus vehicle clock; replaced by the server's offset once it is known."""
        self.state = state
        self.entries: list[RunLogEntry] = []
        self._car = car
        self._recorder = recorder
        self._utc_offset_ns = utc_offset_ns

    def run_tick(self, items: Sequence[InboxItem], stamp_ns: int, late_ns: int = 0) -> Outputs:
        """Runs one tick with the drained inbox.

        An exception in it is a bug and is not caught: frames end, and the gate brakes.
        """
        before = self.state
        self.state, outputs = tick(before, inputs_from(items, stamp_ns), self._car)
        for item in items:
            if isinstance(item.body, LinkState) and item.body.connected:
                self._utc_offset_ns = item.body.server_offset_ns
        if self._recorder is not None:
            self.entries = self._recorder.record(
                before, items, outputs, stamp_ns, late_ns, self._utc_offset_ns
            )
        return outputs

    @property
    def car(self) -> Car:
        return self._car

    def change_over(self, car: Car, state: OnboardState, recorder: Recorder | None) -> None:
        """From the next tick on, other rooms with this state, and a run log of its own: another map."""
        self._car, self.state, self._recorder = car, state, recorder

    def begin_segment(self) -> None:
        """The next tick's entries begin a segment of the run log, for some of the last ones were lost."""
        if self._recorder is not None:
            self._recorder.begin_segment()
