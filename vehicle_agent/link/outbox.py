"""Unacknowledged events and the mission's memory on disk, in one folder.

events.jsonl    appended and synced before an event is sent; rewritten at times without acknowledged events,
                as a new file that replaces the old one
memory.msgpack  the mission's memory (order, visits, riders aboard), replaced whole
"""

import os
from pathlib import Path

import msgspec

from contract.wire.messages import VehicleEvent
from contract.wire.sequence import EventLog, LoggedEvent

REWRITE_AFTER_LINES = 2000
MEMORY_FILE = "memory.msgpack"


class OutboxError(Exception):
    """The vehicle's folder cannot be used; the message says what to do."""


class Outbox:
    """The durable event log of one vehicle.

    A last line that a power loss has cut was never sent, and is dropped.
    """

    def __init__(self, folder: Path, boot_id: str, *, sync: bool = True) -> None:
        """sync=False: the operating system decides when bytes reach the disk (simulation)."""
        folder.mkdir(parents=True, exist_ok=True)
        self._path = folder / "events.jsonl"
        self._memory_path = folder / MEMORY_FILE
        self._sync = sync
        self.log = EventLog(boot_id, self._read_pending())
        self._lines = 0
        self._rewrite()

    def number_events(self, stamp_ns: int, bodies: tuple[VehicleEvent, ...]) -> bytes:
        """Numbers the events; returns the lines for `write`."""
        events = [self.log.append(stamp_ns, body) for body in bodies]
        return b"".join(msgspec.json.encode(event) + b"\n" for event in events)

    def write(self, lines: bytes) -> None:
        """Writes numbered events to disk; after that they may be sent. Blocks."""
        if not lines:
            return
        self._file.write(lines)
        self._file.flush()
        if self._sync:
            os.fsync(self._file.fileno())
        self._lines += lines.count(b"\n")

    def compact(self) -> None:
        """Rewrites the file without acknowledged events, once they are most of it."""
        if self._lines > REWRITE_AFTER_LINES and len(self.log.pending()) < self._lines // 2:
            self._file.close()
            self._rewrite()

    def save_memory(self, memory: bytes) -> None:
        """Replaces the mission's memory; returns when it is on disk."""
        _replace(self._memory_path, memory, self._sync)

    def close(self) -> None:
        self._file.close()

    def _read_pending(self) -> list[LoggedEvent]:
        if not self._path.exists():
            return []
        decoder = msgspec.json.Decoder(LoggedEvent)
        lines = self._path.read_bytes().split(b"\n")
        events = []
        for line_number, line in enumerate(lines[:-1], start=1):
            try:
                events.append(decoder.decode(line))
            except msgspec.DecodeError as error:
                raise OutboxError(
                    f"{self._path}, line {line_number}: {error}. These events never reached the server; "
                    f"move the file away to go on without them"
                ) from error
        return events

    def _rewrite(self) -> None:
        pending = self.log.pending()
        _replace(self._path, b"".join(msgspec.json.encode(event) + b"\n" for event in pending), self._sync)
        self._file = self._path.open("ab")
        self._lines = len(pending)


def read_memory(folder: Path) -> bytes | None:
    """The mission's memory in an outbox folder; None on the first boot."""
    path = folder / MEMORY_FILE
    return path.read_bytes() if path.exists() else None


def _replace(path: Path, data: bytes, sync: bool) -> None:
    """Writes a new file beside the old one and renames it, so that a complete file always exists."""
    new_path = path.with_suffix(".new")
    with new_path.open("wb") as file:
        file.write(data)
        file.flush()
        if sync:
            os.fsync(file.fileno())
    new_path.replace(path)
    if sync:
        folder = os.open(path.parent, os.O_RDONLY)
        try:
            os.fsync(folder)
        finally:
            os.close(folder)
