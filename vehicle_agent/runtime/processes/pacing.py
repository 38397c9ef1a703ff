"""A beat of 20 ms on the wall clock: late beats run once, and no burst catches up."""

import time

from vehicle_agent.onboard.rates import TICK_NS


class Pacer:
    """late_ns: how far behind its moment the last beat began."""

    def __init__(self) -> None:
        self.late_ns = 0
        self._next_ns = time.monotonic_ns() + TICK_NS

    def wait(self) -> int:
        """Sleep until the next beat; returns the stamp at which it begins."""
        pause_ns = self._next_ns - time.monotonic_ns()
        if pause_ns > 0:
            time.sleep(pause_ns / 1e9)
        now_ns = time.monotonic_ns()
        self.late_ns = now_ns - self._next_ns
        missed = self.late_ns // TICK_NS
        self._next_ns += (1 + missed) * TICK_NS
        return now_ns
