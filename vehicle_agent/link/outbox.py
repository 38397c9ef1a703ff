"""What the server has not yet acknowledged, and what the vehicle must not forget: on disk, in one folder.

events.jsonl   appended and synced before an event is sent; rewritten without its acknowledged part now and
               then, by writing a new file and renaming it
memory.msgpack the mission's memory (order, visits, riders aboard), replaced whole
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
    """The durable event log of one vehicle. A last line cut short by a power loss was never sent: dropped."""

    def __init__(self, folder: Path, boot_id: str, *, sync: bool = True) -> None:
        """sync=False leaves it to the operating system when bytes reach the disk (simulation)."""
        folder.mkdir(parents=True, exist_ok=True)
        self._path = folder / "events.jsonl"
        self._memory_path = folder / MEMORY_FILE
        self._sync = sync
        self.log = EventLog(boot_id, self._read_earlier())
        self._lines = 0
        self._rewrite()

    def number(self, stamp_ns: int, bodies: tuple[VehicleEvent, ...]) -> bytes:
        """Give the events their sequence numbers; returns the lines that `write` has to bring to disk."""
        events = [self.log.append(stamp_ns, body) for body in bodies]
        return b"".join(msgspec.json.encode(event) + b"\n" for event in events)

    def write(self, lines: bytes) -> None:
        """Bring numbered events to disk; after that they may be sent. Blocks while the disk works."""
        if not lines:
            return
        self._file.write(lines)
        self._file.flush()
        if self._sync:
            os.fsync(self._file.fileno())
        self._lines += lines.count(b"\n")

    def shrink(self) -> None:
        """Leave the acknowledged events out of the file when most of it is such."""
        if self._lines > REWRITE_AFTER_LINES and len(self.log.pending()) < self._lines // 2:
            self._file.close()
            self._rewrite()

    def save_memory(self, memory: bytes) -> None:
        """Replace the mission's memory; returns when it is on disk."""
        _replace(self._memory_path, memory, self._sync)

    def close(self) -> None:
        self._file.close()

    def _read_earlier(self) -> list[LoggedEvent]:
        if not self._path.exists():
            return []
        decoder = msgspec.json.Decoder(LoggedEvent)
        lines = self._path.read_bytes().split(b"\n")
        events = []
        for number, line in enumerate(lines[:-1], start=1):
            try:
                events.append(decoder.decode(line))
            except msgspec.DecodeError as error:
                raise OutboxError(
                    f"{self._path}, line {number}: {error}. These events never reached the server; "
                    f"move the file away to go on without them"
                ) from error
        return events

    def _rewrite(self) -> None:
        pending = self.log.pending()
        _replace(self._path, b"".join(msgspec.json.encode(event) + b"\n" for event in pending), self._sync)
        self._file = self._path.open("ab")
        self._lines = len(pending)


def read_memory(folder: Path) -> bytes | None:
    """The mission's memory in an outbox folder, or None on the first boot; for who only reads."""
    path = folder / MEMORY_FILE
    return path.read_bytes() if path.exists() else None


def _replace(path: Path, data: bytes, sync: bool) -> None:
    """Write a new file beside the old one and rename it: there is always a whole one."""
    fresh = path.with_suffix(".new")
    with fresh.open("wb") as file:
        file.write(data)
        file.flush()
        if sync:
            os.fsync(file.fileno())
    fresh.replace(path)
    if sync:
        folder = os.open(path.parent, os.O_RDONLY)
        try:
            os.fsync(folder)
        finally:
            os.close(folder)
