"""Unacknowledged events and the mission's memory on disk, in one folder.

events.jsonl    appended and synced before an event is sent; rewritten at times without acknowledged events,
                as a new file that replaces the old one
memory.msgpack  the mission's memory (order, visits, riders aboard) with the events of the same tick, replaced
                whole: after a power loss between the two files, the memory brings back what it rests on
"""

import os
from io import FileIO
from pathlib import Path

import msgspec

from contract.wire.messages import VehicleEvent
from contract.wire.sequence import EventLog, LoggedEvent

REWRITE_AFTER_LINES = 2000
MEMORY_FILE = "memory.msgpack"
_ARRAY_OF_TWO = b"\x92"


class OutboxError(Exception):
    """The vehicle's folder cannot be used; the message says what to do."""


class SavedMemory(msgspec.Struct, frozen=True, array_like=True):
    """What memory.msgpack holds; lines: as they are in events.jsonl."""

    memory: bytes
    lines: bytes = b""


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
        # Of the file, as far as its lines are whole.
        self._lines = self._size = 0
        self._is_torn = False
        self._file: FileIO | None = None
        self._rewrite()

    def number_events(self, stamp_ns: int, bodies: tuple[VehicleEvent, ...]) -> bytes:
        """Numbers the events; returns the lines for `write`."""
        events = [self.log.append(stamp_ns, body) for body in bodies]
        return b"".join(msgspec.json.encode(event) + b"\n" for event in events)

    def write(self, lines: bytes) -> None:
        """Writes numbered events to disk; after that they may be sent. Blocks.

        Raises OSError, e.g. for a full disk; then it may be repeated, and no line is there twice.
        """
        if not lines:
            return
        assert self._file is not None, "the outbox is closed"
        if self._is_torn:
            self._file.truncate(self._size)
        self._is_torn = True
        unwritten = memoryview(lines)
        while unwritten:
            unwritten = unwritten[self._file.write(unwritten) :]
        if self._sync:
            os.fsync(self._file.fileno())
        self._is_torn = False
        self._size += len(lines)
        self._lines += lines.count(b"\n")

    def compact(self) -> None:
        """Rewrites the file without acknowledged events, once they are most of it. Raises OSError."""
        if self._lines > REWRITE_AFTER_LINES and len(self.log.pending()) < self._lines // 2:
            self._rewrite()

    def save_memory(self, memory: bytes, lines: bytes) -> None:
        """Replaces the mission's memory; returns when it is on disk. Raises OSError.

        lines  the events that it rests on
        """
        _replace(self._memory_path, msgspec.msgpack.encode(SavedMemory(memory, lines)), self._sync)

    def close(self) -> None:
        if self._file is not None:
            self._file.close()
            self._file = None

    def _read_pending(self) -> list[LoggedEvent]:
        """Events by boot and number. Those of the memory may be missing in the file, or be acknowledged."""
        events = self._read_events(self._path, self._path.read_bytes() if self._path.exists() else b"")
        saved = _saved_memory(self._memory_path)
        if saved is not None:
            events += self._read_events(self._memory_path, saved.lines)
        by_name = {(event.boot_id, event.sequence): event for event in events}
        boots = dict.fromkeys(boot_id for boot_id, _ in by_name)
        return [by_name[name] for boot_id in boots for name in sorted(n for n in by_name if n[0] == boot_id)]

    def _read_events(self, path: Path, data: bytes) -> list[LoggedEvent]:
        decoder = msgspec.json.Decoder(LoggedEvent)
        events = []
        for line_number, line in enumerate(data.split(b"\n")[:-1], start=1):
            try:
                events.append(decoder.decode(line))
            except msgspec.DecodeError as error:
                raise OutboxError(
                    f"{path}, line {line_number}: {error}. These events never reached the server; "
                    f"move the file away to go on without them"
                ) from error
        return events

    def _rewrite(self) -> None:
        pending = self.log.pending()
        data = b"".join(msgspec.json.encode(event) + b"\n" for event in pending)
        _replace(self._path, data, self._sync)
        self.close()
        # Unbuffered: what a full disk has refused is not written later by itself.
        self._file = self._path.open("ab", buffering=0)
        self._lines, self._size, self._is_torn = len(pending), len(data), False


def read_memory(folder: Path) -> bytes | None:
    """The mission's memory in an outbox folder; None on the first boot."""
    saved = _saved_memory(folder / MEMORY_FILE)
    return None if saved is None else saved.memory


def _saved_memory(path: Path) -> SavedMemory | None:
    if not path.exists():
        return None
    data = path.read_bytes()
    # Former versions wrote the memory alone, which is a map and no array.
    is_alone = data[:1] != _ARRAY_OF_TWO
    return SavedMemory(data) if is_alone else msgspec.msgpack.decode(data, type=SavedMemory)


def _replace(path: Path, data: bytes, sync: bool) -> None:
    """Writes a new file beside the old one and renames it, so that a complete file always exists."""
    new_path = os.path.splitext(path)[0] + ".new"
    with open(new_path, "wb") as file:
        file.write(data)
        file.flush()
        if sync:
            os.fsync(file.fileno())
    os.replace(new_path, path)
    if sync:
        folder = os.open(path.parent, os.O_RDONLY)
        try:
            os.fsync(folder)
        finally:
            os.close(folder)
