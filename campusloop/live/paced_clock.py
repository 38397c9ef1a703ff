"""A clock for a whole live campus on one machine. It runs slower where the machine does not keep up.

Every process that beats says by when it will have looked again (`PacedClock.wait`). The simulator's process
keeps the clock (`KeptClock`): it runs with the computer's, but never further than SLACK_NS past the earliest
of those moments. A process that got no processor is late on the wall and on time by the clock, so that no
neighbour brakes for it. No vehicle is told: on a vehicle the same processes have the computer's clock.

A process that has ended, or has stood still for PATIENCE_NS, is not waited for: a tick that hangs is a silent
tick here, too.
"""

import mmap
import os
import select
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path

BEAT_NS = 20_000_000
# Well under the half beat that the gate leaves the scheduler.
SLACK_NS = 5_000_000
PATIENCE_NS = 5_000_000_000
# How soon a clock that stands is looked at again.
LOOK_NS = 1_000_000
_NO_LIMIT = 2**62
_NOBODY = 0
# The fields of the clock's file and of each process's.
_UTC_OFFSET, _HELD, _LIMIT = range(3)
_PID, _DUE = range(2)

Monotonic = Callable[[], int]


@dataclass(frozen=True, slots=True)
class PacedClocks:
    """Where the clock is kept: a folder, best in memory. Vehicles' processes open their clocks by it."""

    folder: Path

    def make(self) -> None:
        """Begin now. The clock runs with the computer's clocks until a process keeps it."""
        self.folder.mkdir(parents=True, exist_ok=True)
        fields = _fields(self._clock, 3)
        fields[_UTC_OFFSET] = time.time_ns() - time.monotonic_ns()
        fields[_HELD], fields[_LIMIT] = 0, _NO_LIMIT

    def open(self, name: str) -> "PacedClock":
        return PacedClock(_fields(self._clock, 3), _fields(self.folder / f"{name.replace(' ', '-')}.beat", 2))

    def keep(self) -> "KeptClock":
        """For the one process that all others follow."""
        return KeptClock(_fields(self._clock, 3), self.folder)

    @property
    def _clock(self) -> Path:
        return self.folder / "clock"


class _Shared:
    """The clock as every process reads it: the computer's, less the time for which it was held."""

    def __init__(self, shared: memoryview, monotonic: Monotonic) -> None:
        self._shared = shared
        self._monotonic = monotonic
        self._last_ns = 0

    def now_ns(self) -> int:
        # The keeper writes what is held before a new limit: this order never sees the one without the other.
        limit_ns = self._shared[_LIMIT]
        now_ns = min(self._monotonic() - self._shared[_HELD], limit_ns)
        self._last_ns = max(self._last_ns, now_ns)
        return self._last_ns

    def utc_offset_ns(self) -> int:
        return self._shared[_UTC_OFFSET]

    def utc(self) -> datetime:
        stamp_ns = self.now_ns() + self.utc_offset_ns()
        return datetime(1970, 1, 1, tzinfo=UTC) + timedelta(microseconds=stamp_ns // 1000)

    def held_ns(self) -> int:
        """For how long the clock has stood so far."""
        standing_ns = self._monotonic() - self._shared[_HELD] - self._shared[_LIMIT]
        return self._shared[_HELD] + max(0, standing_ns)


class PacedClock(_Shared):
    """One process's view. From its first `wait` on the clock waits for it."""

    def __init__(
        self, shared: memoryview, beat: memoryview, monotonic: Monotonic = time.monotonic_ns
    ) -> None:
        super().__init__(shared, monotonic)
        self._beat = beat
        beat[_DUE] = _NOBODY
        beat[_PID] = os.getpid()

    def wait(self, due_ns: int, files: Sequence[int] = ()) -> None:
        """Until the clock has come to due_ns or one of the files can be read, a beat at most."""
        now_ns = self.now_ns()
        until_ns = min(due_ns, now_ns + BEAT_NS)
        self._beat[_DUE] = until_ns
        while now_ns < until_ns:
            stands = self._shared[_LIMIT] <= now_ns
            pause_s = (LOOK_NS if stands else until_ns - now_ns) * 1e-9
            if files:
                if select.select(files, [], [], pause_s)[0]:
                    return
            else:
                time.sleep(pause_s)
            now_ns = self.now_ns()

    def close(self) -> None:
        self._beat[_DUE] = _NOBODY


class KeptClock(_Shared):
    """The keeper's view. steps are its own beats; waiting for them, it lets the clock run."""

    def __init__(self, shared: memoryview, folder: Path, monotonic: Monotonic = time.monotonic_ns) -> None:
        super().__init__(shared, monotonic)
        self._folder = folder
        self._beats: dict[Path, memoryview] = {}
        self._found_ns = 0
        # By process: the moment that it has not got past, and since when on the computer's clock.
        self._standing: dict[Path, tuple[int, int]] = {}
        if shared[_LIMIT] == _NO_LIMIT:
            shared[_LIMIT] = self.now_ns()

    def wait(self, due_ns: int) -> None:
        """Until the clock has come to due_ns."""
        while True:
            self.let_run(due_ns)
            now_ns = self.now_ns()
            if now_ns >= due_ns:
                return
            # Early enough to move the limit before the clock runs into it.
            look_ns = min(due_ns, self._shared[_LIMIT] - SLACK_NS // 2)
            time.sleep(max(look_ns - now_ns, LOOK_NS) * 1e-9)

    def let_run(self, due_ns: int) -> None:
        """Move the limit to what the keeper's own next beat and those of all others allow."""
        earliest_ns = min([due_ns, *self._beats_ns()])
        limit_ns, now_ns = self._shared[_LIMIT], self._monotonic()
        if earliest_ns + SLACK_NS > limit_ns:
            # It goes on from where it stood.
            self._shared[_HELD] = max(self._shared[_HELD], now_ns - limit_ns)
            self._shared[_LIMIT] = earliest_ns + SLACK_NS

    def _beats_ns(self) -> list[int]:
        limit_ns, now_ns = self._shared[_LIMIT], self._monotonic()
        self._find_beats()
        found = []
        for path, beat in self._beats.items():
            due_ns = beat[_DUE]
            if due_ns == _NOBODY:
                continue
            if due_ns + SLACK_NS > limit_ns:
                self._standing.pop(path, None)
                found.append(due_ns)
                continue
            # The clock stands for this one.
            standing_ns, since_ns = self._standing.get(path, (due_ns, now_ns))
            if standing_ns != due_ns:
                since_ns = now_ns
            self._standing[path] = (due_ns, since_ns)
            if now_ns - since_ns < PATIENCE_NS and _is_alive(beat[_PID]):
                found.append(due_ns)
        return found

    def _find_beats(self) -> None:
        """Processes begin at any time; the folder's own moment tells when one has."""
        changed_ns = self._folder.stat().st_mtime_ns
        if changed_ns == self._found_ns:
            return
        self._found_ns = changed_ns
        for path in self._folder.glob("*.beat"):
            if path not in self._beats:
                self._beats[path] = _fields(path, 2)


def _is_alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


def _fields(path: Path, count: int) -> memoryview:
    """Whole numbers of 64 bits in a file that processes share; they are read and written one at a time."""
    with path.open("a+b") as file:
        if file.seek(0, os.SEEK_END) < 8 * count:
            file.truncate(8 * count)
        return memoryview(mmap.mmap(file.fileno(), 8 * count)).cast("q")
