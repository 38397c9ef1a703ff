"""A clock for a whole live campus on one machine. It stands where the machine does not keep up.

Every periodic process has a reservation: when it begins to wait, it writes the deadline by which it reads the
clock again (`PacedClock.wait`); one with a longer piece of work writes by when that is due (`work`). The
simulator's process has the master clock (`MasterClock`). The clock runs with the computer's, but never more
than SLACK_NS past the earliest deadline. A process that gets no processor time is late by the wall clock and
on time by this clock, so no other process brakes for it. The processes do not know which clock they have: on
a vehicle they have the computer's.

What the clock has lost in short stands it makes up: it runs at twice the speed while it is behind, still
never past the earliest deadline. So a step in which a lidar's scan is cast may take longer than a step, if
those beside it leave some time. More than BEHIND_NS_MAX is not made up: a campus that comes back from a long
stand does not race.

The master ignores the reservation of a process that has ended or has missed its deadline for
STALL_TIMEOUT_NS. A tick that hangs is therefore a silent tick here, too.
"""

import mmap
import os
import select
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path

PERIOD_NS = 20_000_000
# Well under the half period that the gate leaves for scheduling.
SLACK_NS = 5_000_000
STALL_TIMEOUT_NS = 5_000_000_000
# How often a process polls a clock that stands still.
POLL_NS = 1_000_000
# So much of what the clock has lost is made up, in jumps of at most JUMP_NS_MAX.
BEHIND_NS_MAX = 500_000_000
JUMP_NS_MAX = SLACK_NS // 2
# While the clock runs at twice the speed, half of a time passes by the computer's clock.
_HURRY = 2
_NO_LIMIT = 2**62
_NO_DEADLINE = 0
# The fields of the clock's file, and of each process's reservation.
CLOCK_FIELDS = 4
_UTC_OFFSET, _LAG, _LIMIT, _HURRIES = range(CLOCK_FIELDS)
_PID, _DEADLINE = range(2)

Monotonic = Callable[[], int]


@dataclass(frozen=True, slots=True)
class PacedClocks:
    """The folder of the clock's files, best in memory. Processes open their clocks from it."""

    folder: Path

    def create(self) -> None:
        """Create the clock. It runs with the computer's clocks until a process opens the master."""
        self.folder.mkdir(parents=True, exist_ok=True)
        fields = _fields(self._clock, CLOCK_FIELDS)
        fields[_UTC_OFFSET] = time.time_ns() - time.monotonic_ns()
        fields[_LAG], fields[_LIMIT], fields[_HURRIES] = 0, _NO_LIMIT, 0

    def open(self, name: str) -> "PacedClock":
        reservation = _fields(self.folder / f"{name.replace(' ', '-')}.reservation", 2)
        return PacedClock(_fields(self._clock, CLOCK_FIELDS), reservation)

    def open_master(self) -> "MasterClock":
        """For one process only."""
        return MasterClock(_fields(self._clock, CLOCK_FIELDS), self.folder)

    @property
    def _clock(self) -> Path:
        return self.folder / "clock"


class _Shared:
    """The clock as every process reads it: the computer's clock minus the lag."""

    def __init__(self, shared: memoryview, monotonic: Monotonic) -> None:
        self._shared = shared
        self._monotonic = monotonic
        self._last_ns = 0

    def now_ns(self) -> int:
        # The master writes the lag before the limit, and this reads the limit first: a new limit without its
        # lag is never seen.
        limit_ns = self._shared[_LIMIT]
        now_ns = min(self._monotonic() - self._shared[_LAG], limit_ns)
        self._last_ns = max(self._last_ns, now_ns)
        return self._last_ns

    def pause_s(self, span_ns: int) -> float:
        """How long a span of this clock takes by the computer's, while it does not stand."""
        return span_ns * 1e-9 / (_HURRY if self._shared[_HURRIES] else 1)

    def utc_offset_ns(self) -> int:
        return self._shared[_UTC_OFFSET]

    def utc(self) -> datetime:
        stamp_ns = self.now_ns() + self.utc_offset_ns()
        return datetime(1970, 1, 1, tzinfo=UTC) + timedelta(microseconds=stamp_ns // 1000)

    def lag_ns(self) -> int:
        """How far the clock is behind the computer's: what it has lost in stands and not made up."""
        standing_ns = self._monotonic() - self._shared[_LAG] - self._shared[_LIMIT]
        return self._shared[_LAG] + max(0, standing_ns)


class PacedClock(_Shared):
    """One process's view. From its first `wait` on, the clock waits for this process."""

    def __init__(
        self, shared: memoryview, reservation: memoryview, monotonic: Monotonic = time.monotonic_ns
    ) -> None:
        super().__init__(shared, monotonic)
        self._reservation = reservation
        reservation[_DEADLINE] = _NO_DEADLINE
        reservation[_PID] = os.getpid()

    def wait(self, due_ns: int, files: Sequence[int] = ()) -> None:
        """Wait until due_ns or until one of the files can be read, at most one period."""
        now_ns = self.now_ns()
        until_ns = min(due_ns, now_ns + PERIOD_NS)
        self._reservation[_DEADLINE] = until_ns
        while now_ns < until_ns:
            stands = self._shared[_LIMIT] <= now_ns
            pause_s = POLL_NS * 1e-9 if stands else self.pause_s(until_ns - now_ns)
            if files:
                if select.select(files, [], [], pause_s)[0]:
                    return
            else:
                time.sleep(pause_s)
            now_ns = self.now_ns()

    def work(self, until_ns: int) -> None:
        """The clock goes on until until_ns while the process works; then it waits for it."""
        self._reservation[_DEADLINE] = max(self._reservation[_DEADLINE], until_ns)

    def close(self) -> None:
        self._reservation[_DEADLINE] = _NO_DEADLINE


class MasterClock(_Shared):
    """The view of the process that moves the clock's limit, while it waits for its own next step."""

    def __init__(self, shared: memoryview, folder: Path, monotonic: Monotonic = time.monotonic_ns) -> None:
        super().__init__(shared, monotonic)
        self._folder = folder
        self._reservations: dict[Path, memoryview] = {}
        self._listed_ns = 0
        # A lag up to this is not made up; and up to when, by the computer's clock, the clock has made up.
        self._settled_ns = shared[_LAG]
        self._made_up_ns = monotonic()
        # By process: the deadline that it has missed, and since when by the computer's clock.
        self._stalled: dict[Path, tuple[int, int]] = {}
        if shared[_LIMIT] == _NO_LIMIT:
            shared[_LIMIT] = self.now_ns()

    def wait(self, due_ns: int) -> None:
        """Wait until due_ns."""
        while True:
            self.advance_limit(due_ns)
            self._make_up()
            now_ns = self.now_ns()
            if now_ns >= due_ns:
                return
            # Early enough to move the limit before the clock reaches it.
            pause_ns = min(due_ns, self._shared[_LIMIT] - SLACK_NS // 2) - now_ns
            if self._shared[_HURRIES]:
                pause_ns = min(pause_ns // _HURRY, JUMP_NS_MAX)
            time.sleep(max(pause_ns, POLL_NS) * 1e-9)

    def advance_limit(self, due_ns: int) -> None:
        """Move the limit to SLACK_NS past the earliest deadline; due_ns is the master's own."""
        earliest_ns = min([due_ns, *self._deadlines_ns()])
        limit_ns, now_ns = self._shared[_LIMIT], self._monotonic()
        if earliest_ns + SLACK_NS > limit_ns:
            # The clock continues from where it stood.
            self._shared[_LAG] = max(self._shared[_LAG], now_ns - limit_ns)
            self._shared[_LIMIT] = earliest_ns + SLACK_NS

    def _make_up(self) -> None:
        """Bring the clock forward by as much as has passed since the last call, while it is behind."""
        now_ns = self._monotonic()
        passed_ns, self._made_up_ns = now_ns - self._made_up_ns, now_ns
        lag_ns = self._shared[_LAG]
        self._settled_ns = max(self._settled_ns, lag_ns - BEHIND_NS_MAX)
        behind_ns = lag_ns - self._settled_ns
        self._shared[_LAG] = lag_ns - min(behind_ns, passed_ns, JUMP_NS_MAX)
        self._shared[_HURRIES] = behind_ns > JUMP_NS_MAX

    def _deadlines_ns(self) -> list[int]:
        """The deadlines that the clock waits for."""
        limit_ns, now_ns = self._shared[_LIMIT], self._monotonic()
        self._list_reservations()
        deadlines_ns = []
        for path, reservation in self._reservations.items():
            deadline_ns = reservation[_DEADLINE]
            if deadline_ns == _NO_DEADLINE:
                continue
            if deadline_ns + SLACK_NS > limit_ns:
                self._stalled.pop(path, None)
                deadlines_ns.append(deadline_ns)
                continue
            # The clock stands still for this process.
            missed_ns, since_ns = self._stalled.get(path, (deadline_ns, now_ns))
            if missed_ns != deadline_ns:
                since_ns = now_ns
            self._stalled[path] = (deadline_ns, since_ns)
            if now_ns - since_ns < STALL_TIMEOUT_NS and _is_alive(reservation[_PID]):
                deadlines_ns.append(deadline_ns)
        return deadlines_ns

    def _list_reservations(self) -> None:
        """Processes start at any time; the folder's modification time shows when one has."""
        changed_ns = self._folder.stat().st_mtime_ns
        if changed_ns == self._listed_ns:
            return
        self._listed_ns = changed_ns
        for path in self._folder.glob("*.reservation"):
            if path not in self._reservations:
                self._reservations[path] = _fields(path, 2)


def _is_alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


def _fields(path: Path, count: int) -> memoryview:
    """64-bit integers in a file that processes share; each is read and written by itself."""
    with path.open("a+b") as file:
        if file.seek(0, os.SEEK_END) < 8 * count:
            file.truncate(8 * count)
        return memoryview(mmap.mmap(file.fileno(), 8 * count)).cast("q")
