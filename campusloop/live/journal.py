"""The log format of all processes: one line an event, `noun.verb` with fields, on standard error."""

import logging
import sys

import structlog

from vehicle_agent.runtime.processes.journal import LastingStream

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
