"""A vehicle's disk: the link's real outbox files, and what a crash leaves of a write that was under way."""

import random
from dataclasses import dataclass
from pathlib import Path

from vehicle_agent.link.bridge import LinkBridge, TickUpdate

EVENTS_FILE = "events.jsonl"


class ComputerCrashed(Exception):
    """The vehicle's computer lost its power in the middle of a write."""


@dataclass
class VehicleDisk:
    """crash_pending: the computer loses its power in the next write; torn: a part of that write is there."""

    folder: Path
    rng: random.Random
    crash_pending: bool = False
    torn_writes: int = 0

    def process(self, bridge: LinkBridge, update: TickUpdate, now_ns: int) -> None:
        """As the link process does: number, write, send. Raises ComputerCrashed, when that is due."""
        lines = bridge.number_events(update)
        writes = bool(lines) or update.memory is not None
        if not (self.crash_pending and writes):
            bridge.write(update, lines)
            bridge.send(update, now_ns)
            return
        self.crash_pending = False
        self._crash_in(bridge, update, lines)
        raise ComputerCrashed

    def _crash_in(self, bridge: LinkBridge, update: TickUpdate, lines: bytes) -> None:
        """Before the write, within it or after it; never sent."""
        when = self.rng.random()
        if when < 0.25:
            return
        if when < 0.5:
            bridge.write(update, lines)
            return
        self._tear(bridge, update, lines)

    def _tear(self, bridge: LinkBridge, update: TickUpdate, lines: bytes) -> None:
        """The write of the events stops at some byte; what the bridge writes before them is complete."""
        size = self._size()
        bridge.write(update, lines)
        if lines:
            kept = size + self.rng.randrange(len(lines))
            with (self.folder / EVENTS_FILE).open("r+b") as file:
                file.truncate(kept)
            self.torn_writes += 1

    def _size(self) -> int:
        return (self.folder / EVENTS_FILE).stat().st_size
