"""The log format of all processes: one line an event, `noun.verb` with fields, on standard error."""

import logging
import sys
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


_PLAIN_TRACEBACKS = structlog.tracebacks.ExceptionDictTransformer(show_locals=False)


def write_journal(level: int = logging.INFO) -> None:
    """Set up structlog for this process: JSON lines, or plain text on a terminal."""
    terminal = sys.stderr.isatty()
    console = structlog.dev.ConsoleRenderer(
        exception_formatter=structlog.dev.RichTracebackFormatter(show_locals=False)
    )
    renderer = console if terminal else structlog.processors.JSONRenderer()
    # Without local variables: they hold ride tokens and codes.
    errors = [] if terminal else [structlog.processors.ExceptionRenderer(_PLAIN_TRACEBACKS)]
    structlog.configure(
        processors=[
            structlog.processors.add_log_level,
            structlog.processors.TimeStamper(fmt="iso", utc=True),
            *errors,
            renderer,
        ],
        wrapper_class=structlog.make_filtering_bound_logger(level),
        logger_factory=structlog.PrintLoggerFactory(LastingStream(sys.stderr)),  # type: ignore[arg-type]
        cache_logger_on_first_use=False,
    )
