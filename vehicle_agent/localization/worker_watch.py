"""Whether the localization worker answers: a worker that is gone, or gets no scans, says nothing."""

import msgspec

# Ten scans a second, and a search that takes half of one; a process that is started again takes a few.
SILENT_NS = 3_000_000_000


class WorkerWatch(msgspec.Struct, frozen=True):
    """since_ns  of the last answer, or of the first job if there was none; 0: nothing was asked yet"""

    since_ns: int = 0

    def after(self, now_ns: int, *, asks: bool, answered: bool) -> "WorkerWatch":
        """The watch after a tick that asks or does not, and in which an answer came or none did."""
        if not asks:
            return WorkerWatch()
        return WorkerWatch(now_ns) if answered or self.since_ns == 0 else self

    def is_silent(self, now_ns: int) -> bool:
        return self.since_ns > 0 and now_ns - self.since_ns >= SILENT_NS
