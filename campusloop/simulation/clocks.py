"""Wall clocks that jump, and vehicles' clocks that begin at each boot and drift."""

from dataclasses import dataclass
from datetime import datetime, timedelta

from campusloop.simulation.schedule import TimeSource


@dataclass
class WallClock:
    """The server machine's clock: `begins` at start_ns, and `ahead_s` wrong, which a fault may set."""

    timeline: TimeSource
    begins: datetime
    start_ns: int
    ahead_s: float = 0.0

    def now(self) -> datetime:
        elapsed = timedelta(microseconds=(self.timeline.now_ns - self.start_ns) // 1000, seconds=self.ahead_s)
        return self.begins + elapsed


@dataclass(frozen=True, slots=True)
class BootClock:
    """A vehicle computer's monotonic clock: from 0 at its boot, faster or slower than time by `drift`."""

    timeline: TimeSource
    booted_ns: int
    drift: float

    def now_ns(self) -> int:
        return round((self.timeline.now_ns - self.booted_ns) * (1.0 + self.drift)) + 1
