"""What a by-wire module accepts from the bus: well-formed, counted and fresh commands."""

from dataclasses import dataclass, field
from functools import cache

from vehicle_agent.can.commands import COMMANDS, COUNTER_STEPS, FRAME_GAP_NS
from vehicle_agent.can.dbc import FrameError, MessageLayout, layouts
from vehicle_agent.signals import CanFrame

# Three periods of 30 Hz.
COMMAND_TIMEOUT_NS = 100_000_000
COUNTED = frozenset({"global_command", "supervisory_command"})


@dataclass(slots=True)
class CommandWatch:
    """Newest accepted command of each kind, and counts of what was refused.

    A counted frame is accepted when its complement is right and its counter follows the last one seen; a
    repeated frame therefore never counts as life. Frames closer than `gap_ns_min` are lost, as on a module
    whose receive buffer is one deep. A command is late once it is `timeout_ns` old.
    """

    gap_ns_min: int = FRAME_GAP_NS
    timeout_ns: int = COMMAND_TIMEOUT_NS
    crowded: int = 0
    malformed: int = 0
    miscounted: int = 0
    _values: dict[str, dict[str, float]] = field(default_factory=dict)
    _stamps_ns: dict[str, int] = field(default_factory=dict)
    _counters: dict[str, int] = field(default_factory=dict)
    _last_frame_ns: int | None = None

    def take(self, frame: CanFrame) -> str:
        """The name of the command, or "" when the frame is another module's or was refused."""
        layout = _commands().get(frame.arbitration_id)
        if layout is None:
            return ""
        if self._last_frame_ns is not None and frame.stamp_ns - self._last_frame_ns < self.gap_ns_min:
            self.crowded += 1
            return ""
        self._last_frame_ns = frame.stamp_ns
        try:
            values = layout.unpack(frame.data)
        except FrameError:
            self.malformed += 1
            return ""
        if layout.name in COUNTED and not self._counts(layout.name, values):
            self.miscounted += 1
            return ""
        self._values[layout.name] = values
        self._stamps_ns[layout.name] = frame.stamp_ns
        return layout.name

    def value(self, command: str, signal: str) -> float:
        """A signal of the newest accepted command, 0 before the first."""
        values = self._values.get(command)
        return 0.0 if values is None else values[signal]

    def is_late(self, command: str, now_ns: int) -> bool:
        stamp_ns = self._stamps_ns.get(command)
        return stamp_ns is None or now_ns - stamp_ns > self.timeout_ns

    def late(self, now_ns: int) -> tuple[str, ...]:
        """Commands that have not come in time."""
        return tuple(name for name in COMMANDS if self.is_late(name, now_ns))

    def _counts(self, name: str, values: dict[str, float]) -> bool:
        counter = int(values["counter"])
        before = self._counters.get(name)
        self._counters[name] = counter
        follows = before is None or counter == (before + 1) % COUNTER_STEPS
        return follows and values["complement"] == COUNTER_STEPS - 1 - counter


@cache
def _commands() -> dict[int, MessageLayout]:
    known = layouts()
    return {known[name].arbitration_id: known[name] for name in COMMANDS}
