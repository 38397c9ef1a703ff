"""Virtual time that jumps to the next thing that is due; every process has an event loop of its own."""

import heapq
import math
import random
from collections.abc import Callable

from campusloop.virtual.event_loop import VirtualLoop

GRID_NS = 10_000_000

Action = Callable[[], None]


class Timeline:
    """Owns `now_ns`. Actions that are due at one moment run in the order in which they were entered.

    Moments are rounded up to GRID_NS, so that what happens almost together takes one step.
    """

    def __init__(self, seed: int, start_ns: int) -> None:
        self.now_ns = start_ns
        self._seed = seed
        self._entered = 0
        self._due: list[tuple[int, int, Action]] = []
        self._loops: list[VirtualLoop] = []

    def rng(self, name: str) -> random.Random:
        """A separate random stream for each named purpose; a new consumer does not change the others."""
        return random.Random(f"{self._seed}/{name}")

    def at(self, due_ns: int, action: Action) -> None:
        """Run the action at due_ns, or at once if that is past."""
        heapq.heappush(self._due, (due_ns, self._entered, action))
        self._entered += 1

    def after(self, delay_s: float, action: Action) -> None:
        self.at(self.now_ns + round(delay_s * 1e9), action)

    def new_loop(self) -> VirtualLoop:
        """The event loop of a process that starts now."""
        loop = VirtualLoop()  # type: ignore[abstract]  # methods left out raise, as they should
        loop.now_ns = self.now_ns
        self._loops.append(loop)
        return loop

    def remove_loop(self, loop: VirtualLoop) -> None:
        """The process has ended."""
        self._loops.remove(loop)

    def run_until(self, end_ns: int) -> None:
        while True:
            due_ns = self._next_due_ns()
            if due_ns is None or due_ns > end_ns:
                self.now_ns = max(self.now_ns, end_ns)
                return
            self.now_ns = max(self.now_ns, math.ceil(due_ns / GRID_NS) * GRID_NS)
            while self._due and self._due[0][0] <= self.now_ns:
                heapq.heappop(self._due)[2]()
            for loop in tuple(self._loops):
                loop.run_until_idle(self.now_ns)

    def _next_due_ns(self) -> int | None:
        moments = [self._due[0][0]] if self._due else []
        moments += [due_ns for loop in self._loops if (due_ns := loop.next_due_ns()) is not None]
        return min(moments, default=None)
