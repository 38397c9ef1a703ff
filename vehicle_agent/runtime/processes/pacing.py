"""Ticks every 20 ms: a late tick runs once, and missed ticks are not repeated."""

from vehicle_agent.runtime.processes.clock import MONOTONIC, Clock
from vehicle_agent.signals.rates import TICK_NS


class Pacer:
    """late_ns: how late the last tick began."""

    def __init__(self, clock: Clock = MONOTONIC) -> None:
        self.late_ns = 0
        self._clock = clock
        self._next_ns = clock.now_ns() + TICK_NS

    def wait(self) -> int:
        """Waits until the next tick; returns its stamp."""
        while (now_ns := self._clock.now_ns()) < self._next_ns:
            self._clock.wait(self._next_ns)
        self.late_ns = now_ns - self._next_ns
        missed = self.late_ns // TICK_NS
        self._next_ns += (1 + missed) * TICK_NS
        return now_ns
