"""The second layer of safety: between the tick and the CAN bus, and the only owner of the bus.

Small enough to read aloud. It knows nothing of roads or plans: fresh, consistent commands pass; anything
else is answered with the gate's own brake sequence, for as long as it takes.
"""

from vehicle_agent.can.braking import Braking, CommandSetError
from vehicle_agent.signals import CanFrame

TICK_NS = 20_000_000
# Two missed ticks, and half a tick of slack for the scheduler.
FRESH_NS = 2 * TICK_NS + TICK_NS // 2


class Gate:
    """refused: why the last set of commands was not let through, empty when it was.
    braking: the gate itself is braking, because the tick has gone silent."""

    def __init__(self, by_wire: Braking) -> None:
        self._by_wire = by_wire
        self.refused = ""
        self.braking = False
        self._pending: tuple[CanFrame, ...] = ()
        self._last: tuple[CanFrame, ...] = ()
        self._last_counter = -1
        self._last_ns = 0
        self._braked_steps = 0

    def take(self, frames: tuple[CanFrame, ...], now_ns: int) -> None:
        """One tick's command frames. A set that is inconsistent or repeats the one before is refused: a
        stale command must not look alive."""
        try:
            counter = self._by_wire.checked_counter(frames)
        except CommandSetError as error:
            self.refused = str(error)
            return
        if counter == self._last_counter:
            self.refused = "the counter stands still"
            return
        self.refused = ""
        self._last, self._pending = frames, frames
        self._last_counter, self._last_ns = counter, now_ns
        self._braked_steps = 0

    def step(self, now_ns: int) -> tuple[CanFrame, ...]:
        """Frames for the bus now, called every 20 ms: the tick's, or nothing yet, or the gate's brake."""
        if self._pending:
            frames, self._pending = self._pending, ()
            self.braking = False
            return frames
        if not self._last or now_ns - self._last_ns <= FRESH_NS:
            return ()
        self.braking = True
        self._braked_steps += 1
        return self._by_wire.braking_frames(self._last, self._braked_steps, now_ns)
