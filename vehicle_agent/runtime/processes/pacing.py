"""A beat of 20 ms: late beats run once, and no burst catches up."""

from vehicle_agent.runtime.processes.clock import MONOTONIC, Clock
from vehicle_agent.signals.rates import TICK_NS


class Pacer:
    """late_ns: how far behind its moment the last beat began."""

    def __init__(self, clock: Clock = MONOTONIC) -> None:
        self.late_ns = 0
        self._clock = clock
        self._next_ns = clock.now_ns() + TICK_NS

    def wait(self) -> int:
        """Sleep until the next beat; returns the stamp at which it begins."""
        while (now_ns := self._clock.now_ns()) < self._next_ns:
            self._clock.wait(self._next_ns)
        self.late_ns = now_ns - self._next_ns
        missed = self.late_ns // TICK_NS
        self._next_ns += (1 + missed) * TICK_NS
        return now_ns
