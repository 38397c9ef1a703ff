"""The log of every process: a line is a JSON object, text on a terminal.

Each line has `timestamp`, `level`, `event` and `process`, in this order, then what the event tells. Messages
of libraries, warnings and errors that end the process are lines like all others.
"""

import json
import logging
import math
import sys
import threading
import warnings
from collections.abc import Callable, MutableMapping
from datetime import UTC, datetime
from types import TracebackType
from typing import Any, TextIO

import structlog

# Without local variables: they hold ride tokens and codes.
_PLAIN_TRACEBACKS = structlog.tracebacks.ExceptionDictTransformer(show_locals=False)

log = structlog.get_logger()

Fields = MutableMapping[str, Any]


class LastingStream:
    """A text stream whose failures end nothing: a full disk must not stop the work that the log tells of.

    Once lines can be written again, the first one says how many were lost.
    """

    def __init__(self, stream: TextIO, process: str = "") -> None:
        self._stream, self._process = stream, process
        self._lost = 0

    def write(self, text: str) -> int:
        try:
            if self._lost:
                self._stream.write(self._lost_line())
            self._stream.write(text)
            self._stream.flush()
            self._lost = 0
        except OSError:
            self._lost += 1
        return len(text)

    def flush(self) -> None:
        """Every write is flushed."""

    def _lost_line(self) -> str:
        fields = {
            "timestamp": datetime.now(UTC).isoformat().replace("+00:00", "Z"),
            "level": "error",
            "event": "journal.lost",
            "process": self._process,
            "writes": self._lost,
        }
        return json.dumps(fields) + "\n"


def write_journal(process: str, stream: TextIO | None = None, level: int = logging.INFO) -> None:
    """Set up the log of this process, also for what libraries log, for warnings and for uncaught errors.

    process  its name, in every line
    stream   None: standard error
    """
    stream = stream or sys.stderr
    is_terminal, lasting = stream.isatty(), LastingStream(stream, process)
    common: list[structlog.typing.Processor] = [
        structlog.contextvars.merge_contextvars,
        structlog.processors.add_log_level,
        structlog.processors.TimeStamper(fmt="iso", utc=True),
        _named(process),
    ]
    ends = _text() if is_terminal else _json_lines()
    structlog.configure(
        processors=[*common, *ends],
        wrapper_class=structlog.make_filtering_bound_logger(level),
        # One write for each line: processes that share a stream do not mix their lines.
        logger_factory=structlog.WriteLoggerFactory(lasting),  # type: ignore[arg-type]
        cache_logger_on_first_use=False,
    )
    handler = logging.StreamHandler(lasting)
    handler.setFormatter(
        structlog.stdlib.ProcessorFormatter(
            foreign_pre_chain=[*common, structlog.stdlib.add_logger_name],
            processors=[structlog.stdlib.ProcessorFormatter.remove_processors_meta, *ends],
        )
    )
    # Above INFO only: libraries tell whole addresses there, and a ride's address is its secret.
    logging.basicConfig(level=max(level, logging.WARNING), handlers=[handler], force=True)
    for name in logging.root.manager.loggerDict:
        # Libraries may have set up loggers of their own, e.g. uvicorn.
        library = logging.getLogger(name)
        library.handlers.clear()
        library.propagate = True
    warnings.showwarning = _log_warning
    sys.excepthook = _log_end
    threading.excepthook = _log_end_of_thread
    sys.unraisablehook = _log_unraisable


def run_logged(work: Callable[..., object], *arguments: object) -> None:
    """Run the work of a whole process. An error that it raises is logged and ends the process with 1."""
    try:
        work(*arguments)
    except Exception as error:
        log.critical("process.failed", exc_info=error)
        raise SystemExit(1) from error


def _named(process: str) -> structlog.typing.Processor:
    def add_process(_logger: object, _method: str, fields: Fields) -> Fields:
        fields["process"] = process
        return fields

    return add_process


def _text() -> list[structlog.typing.Processor]:
    errors = structlog.dev.RichTracebackFormatter(show_locals=False)
    return [structlog.dev.ConsoleRenderer(exception_formatter=errors)]


def _json_lines() -> list[structlog.typing.Processor]:
    errors = structlog.processors.ExceptionRenderer(_PLAIN_TRACEBACKS)
    return [errors, _in_order, structlog.processors.JSONRenderer()]


def _in_order(_logger: object, _method: str, fields: Fields) -> Fields:
    """The keys of every line first. JSON has no NaN and no infinity: they are texts."""
    first = {key: fields.pop(key) for key in ("timestamp", "level", "event", "process")}
    rest = {
        key: str(value) if isinstance(value, float) and not math.isfinite(value) else value
        for key, value in fields.items()
    }
    return first | rest


def _log_warning(
    message: Warning | str,
    category: type[Warning],
    filename: str,
    lineno: int,
    file: TextIO | None = None,
    line: str | None = None,
) -> None:
    log.warning("python.warning", category=category.__name__, detail=str(message), at=f"{filename}:{lineno}")


def _log_end(kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
    if issubclass(kind, KeyboardInterrupt):
        log.info("process.interrupted")
    else:
        log.critical("process.failed", exc_info=(kind, error, trace))


def _log_end_of_thread(ended: threading.ExceptHookArgs) -> None:
    if ended.exc_value is not None and ended.exc_type is not SystemExit:
        name = ended.thread.name if ended.thread is not None else ""
        log.critical("thread.failed", thread=name, exc_info=ended.exc_value)


def _log_unraisable(unraisable: "sys.UnraisableHookArgs") -> None:
    log.error("python.unraisable", detail=unraisable.err_msg or "", exc_info=unraisable.exc_value)
