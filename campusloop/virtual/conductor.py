"""Virtual time: one synchronous step of 20 ms moves all participants, in a fixed order.

Nothing else advances time. A seed therefore repeats a day of vehicles, wire, server and simulated people, bit
for bit, on any machine with the same libraries.
"""

import heapq
from collections.abc import Callable
from typing import Protocol

import numpy as np

from campusloop.virtual.event_loop import VirtualLoop

STEP_NS = 20_000_000


class Steppable(Protocol):
    """A vehicle with everything around it: sensors, inbox drain, tick, gate, by-wire, plant."""

    def step(self, now_ns: int) -> None: ...


class Conductor:
    """Owns `now_ns`. Participants are stepped in the order of their names."""

    def __init__(self, seed: int, start_ns: int = 0) -> None:
        self.now_ns = start_ns
        self.loop = VirtualLoop()  # type: ignore[abstract]  # methods left out raise, as they should
        self.loop.now_ns = start_ns
        self._seed = seed
        self._participants: dict[str, Steppable] = {}
        self._posted: list[tuple[int, str, int, Callable[[], None]]] = []
        self._sequence = 0

    def rng(self, name: str) -> np.random.Generator:
        """A separate random stream for each named purpose; a new consumer does not change the others."""
        return np.random.default_rng([self._seed, *name.encode()])

    def add(self, name: str, participant: Steppable) -> None:
        """Raises ValueError for a name already taken."""
        if name in self._participants:
            raise ValueError(f"{name} is already conducted")
        self._participants[name] = participant
        self._participants = dict(sorted(self._participants.items()))

    def remove(self, name: str) -> None:
        del self._participants[name]

    def post(self, sender: str, due_ns: int, deliver: Callable[[], None]) -> None:
        """Call `deliver` in the first step at or after due_ns."""
        heapq.heappush(self._posted, (due_ns, sender, self._sequence, deliver))
        self._sequence += 1

    def step(self) -> None:
        """20 ms: messages due, then participants by name, then the event loop until it is idle."""
        self.now_ns += STEP_NS
        while self._posted and self._posted[0][0] <= self.now_ns:
            _, _, _, deliver = heapq.heappop(self._posted)
            deliver()
        for participant in self._participants.values():
            participant.step(self.now_ns)
        self.loop.run_until_idle(self.now_ns)

    def run_for(self, duration_s: float) -> None:
        for _ in range(round(duration_s * 1e9 / STEP_NS)):
            self.step()

    def run_until(self, condition: Callable[[], bool], timeout_s: float) -> bool:
        """Step until the condition holds (True) or the virtual time is over (False)."""
        deadline_ns = self.now_ns + round(timeout_s * 1e9)
        while not condition():
            if self.now_ns >= deadline_ns:
                return False
            self.step()
        return True
