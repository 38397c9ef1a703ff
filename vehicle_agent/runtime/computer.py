"""The vehicle computer without its devices: state, tick and recorder, for live, virtual time and replay."""

import time
from collections.abc import Sequence

from contract.wire.messages import OnboardScene, TickTimes, TracksBy
from vehicle_agent.onboard.car import Car
from vehicle_agent.onboard.onboard_scene import SceneSource
from vehicle_agent.onboard.state import OnboardState
from vehicle_agent.onboard.tick import tick
from vehicle_agent.runtime.inbox import inputs_from
from vehicle_agent.runtime.recording.recorder import Recorder, RunLogEntry
from vehicle_agent.runtime.room_times import TickStopwatch
from vehicle_agent.signals import InboxItem, LinkState, Outputs


class VehicleComputer:
    """entries: the run-log entries of the last tick; shown: the scene for an operator who looks, if any."""

    def __init__(
        self,
        car: Car,
        state: OnboardState,
        recorder: Recorder | None = None,
        utc_offset_ns: int = 0,
        stopwatch: TickStopwatch | None = None,
        tracks_by: TracksBy = "",
    ) -> None:
        """utc_offset_ns  UTC minus vehicle clock; replaced by the server's offset once it is known.

        stopwatch  times the rooms on a vehicle; None in virtual time, where a seed repeats a run log
        tracks_by  who finds road users, for those who look (`Profile.perception`)
        """
        self.state = state
        self.entries: list[RunLogEntry] = []
        self.shown: OnboardScene | None = None
        self._car = car if stopwatch is None else stopwatch.timed(car)
        self._stopwatch = stopwatch
        self._tick_times: TickTimes | None = None
        self._scenes = SceneSource(tracks_by)
        self._recorder = recorder
        self._utc_offset_ns = utc_offset_ns

    def run_tick(self, items: Sequence[InboxItem], stamp_ns: int, late_ns: int = 0) -> Outputs:
        """Runs one tick with the drained inbox.

        An exception in it is a bug and is not caught: frames end, and the gate brakes.
        """
        begun_ns = 0 if self._stopwatch is None else time.perf_counter_ns()
        before = self.state
        self.state, outputs = tick(before, inputs_from(items, stamp_ns), self._car)
        for item in items:
            if isinstance(item.body, LinkState) and item.body.connected:
                self._utc_offset_ns = item.body.server_offset_ns
        if self._stopwatch is not None:
            self._stopwatch.note(time.perf_counter_ns() - begun_ns, late_ns)
        self._scenes.observe(items, outputs, stamp_ns)
        if self._recorder is not None:
            self.entries = self._recorder.record(
                before,
                items,
                outputs,
                stamp_ns,
                late_ns,
                self._utc_offset_ns,
                self._recorded_scene,
                self._scenes.new_scan,
            )
        self.shown = None
        if self._scenes.is_due(stamp_ns):
            self.shown = self._scenes.scene(outputs.flow, stamp_ns, self._tick_times, with_points=True)
        return outputs

    @property
    def car(self) -> Car:
        return self._car

    def change_over(self, car: Car, state: OnboardState, recorder: Recorder | None) -> None:
        """From the next tick on, other rooms with this state, and a run log of its own: another map."""
        self._car = car if self._stopwatch is None else self._stopwatch.timed(car)
        self.state, self._recorder = state, recorder

    def begin_run(self, recorder: Recorder | None) -> None:
        """From the next tick on, a run log of its own: the rooms go on, something beside them has changed."""
        self._recorder = recorder

    def begin_segment(self) -> None:
        """The next tick's entries begin a segment of the run log, for some of the last ones were lost."""
        if self._recorder is not None:
            self._recorder.begin_segment()

    def _recorded_scene(self, outputs: Outputs, stamp_ns: int) -> OnboardScene:
        self._tick_times = None if self._stopwatch is None else self._stopwatch.take()
        return self._scenes.scene(outputs.flow, stamp_ns, self._tick_times, with_points=False)
