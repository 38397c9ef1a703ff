"""A log stream that outlives a full disk."""

from typing import TextIO

import structlog


class LastingStream:
    """A text stream whose failures end nothing: a full disk must not stop the work that the log tells of.

    Once lines can be written again, the first one says how many were lost.
    """

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._lost = 0

    def write(self, text: str) -> int:
        try:
            if self._lost:
                self._stream.write(f'{{"event": "journal.lost", "level": "error", "writes": {self._lost}}}\n')
            self._stream.write(text)
            self._stream.flush()
            self._lost = 0
        except OSError:
            self._lost += 1
        return len(text)

    def flush(self) -> None:
        """Every write is flushed."""


def keep_logging(stream: TextIO) -> None:
    """Send this process's log to the stream, in the format that is set up; a full disk ends nothing."""
    factory = structlog.PrintLoggerFactory(LastingStream(stream))  # type: ignore[arg-type]
    structlog.configure(logger_factory=factory)
