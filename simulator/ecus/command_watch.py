"""The commands that a by-wire module accepts from the bus: well-formed, counted and recent ones."""

from collections.abc import Callable
from dataclasses import dataclass, field

from vehicle_agent.can.dbc import PACMOD, SERVO, FrameError, MessageLayout, layouts
from vehicle_agent.can.pacmod.commands import COMMANDS, COUNTER_STEPS, DRIVING_COMMANDS, FRAME_GAP_NS
from vehicle_agent.can.servo.commands import SERVO_COMMANDS, SERVO_COUNTER_STEPS, unpack_checked
from vehicle_agent.signals import CanFrame

# Three periods of 30 Hz.
COMMAND_TIMEOUT_NS = 100_000_000


@dataclass(frozen=True, slots=True)
class CommandProtocol:
    """The commands of one kind of module.

    counted       the commands that carry a counter
    complemented  the counter's complement is sent too and must match
    unpack        the values of a frame; FrameError if its length or check byte is wrong
    driving       the commands without which by-wire ends
    """

    file: str
    commands: tuple[str, ...]
    counted: frozenset[str]
    counter_steps: int
    complemented: bool
    unpack: Callable[[MessageLayout, bytes], dict[str, float]]
    driving: tuple[str, ...]


PACMOD_PROTOCOL = CommandProtocol(
    PACMOD,
    COMMANDS,
    frozenset({"global_command", "supervisory_command"}),
    COUNTER_STEPS,
    True,
    MessageLayout.unpack,
    DRIVING_COMMANDS,
)
SERVO_PROTOCOL = CommandProtocol(
    SERVO,
    SERVO_COMMANDS,
    frozenset(SERVO_COMMANDS),
    SERVO_COUNTER_STEPS,
    False,
    unpack_checked,
    SERVO_COMMANDS,
)


@dataclass(slots=True)
class CommandWatch:
    """The newest accepted command of each kind, and counts of the refused frames.

    A counted frame is accepted if its complement is right and its counter follows the last one; a repeated
    frame therefore does not reset the timeout. Frames closer than `gap_ns_min` are lost, as on a module with
    a receive buffer for one frame. A command is late once it is `timeout_ns` old.
    """

    gap_ns_min: int = FRAME_GAP_NS
    timeout_ns: int = COMMAND_TIMEOUT_NS
    protocol: CommandProtocol = PACMOD_PROTOCOL
    crowded: int = 0
    malformed: int = 0
    miscounted: int = 0
    _values: dict[str, dict[str, float]] = field(default_factory=dict)
    _stamps_ns: dict[str, int] = field(default_factory=dict)
    _counters: dict[str, int] = field(default_factory=dict)
    _last_frame_ns: int | None = None
    _known: dict[int, MessageLayout] = field(init=False)

    def __post_init__(self) -> None:
        known = layouts(self.protocol.file)
        self._known = {known[name].arbitration_id: known[name] for name in self.protocol.commands}

    def take(self, frame: CanFrame) -> str:
        """The name of the command, or "" if the frame is for another module or is refused."""
        layout = self._known.get(frame.arbitration_id)
        if layout is None:
            return ""
        if self._last_frame_ns is not None and frame.stamp_ns - self._last_frame_ns < self.gap_ns_min:
            self.crowded += 1
            return ""
        self._last_frame_ns = frame.stamp_ns
        try:
            values = self.protocol.unpack(layout, frame.data)
        except FrameError:
            self.malformed += 1
            return ""
        if layout.name in self.protocol.counted and not self._counts(layout.name, values):
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
        return tuple(name for name in self.protocol.commands if self.is_late(name, now_ns))

    def stops_driving(self, now_ns: int) -> bool:
        """A command without which by-wire ends has not come in time."""
        return any(self.is_late(name, now_ns) for name in self.protocol.driving)

    def _counts(self, name: str, values: dict[str, float]) -> bool:
        counter = int(values["counter"])
        before = self._counters.get(name)
        self._counters[name] = counter
        steps = self.protocol.counter_steps
        follows = before is None or counter == (before + 1) % steps
        return follows and (not self.protocol.complemented or values["complement"] == steps - 1 - counter)
