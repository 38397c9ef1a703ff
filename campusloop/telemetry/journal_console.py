"""What commands that run for long say: text on a terminal, else lines of the log."""

import sys
from typing import Literal, TextIO

import structlog
from rich.console import Console

log = structlog.get_logger()

Level = Literal["info", "error"]

# Lines of the log are not folded.
WIDTH = 10_000


class _JournalLines:
    """A text stream each of whose lines is an event of the log."""

    def __init__(self, level: str) -> None:
        self._level, self._begun = level, ""

    def write(self, text: str) -> int:
        *lines, self._begun = (self._begun + text).split("\n")
        for line in lines:
            if line.strip():
                getattr(log, self._level)("command.message", text=line.rstrip())
        return len(text)

    def flush(self) -> None:
        """Lines are written when they end."""

    def isatty(self) -> bool:
        return False


def journal_console(stream: TextIO | None = None, level: Level = "info") -> Console:
    """A console on the stream if it is a terminal, else one that writes events `command.message`.

    stream  None: standard output
    level   of these events
    """
    stream = stream or sys.stdout
    if stream.isatty():
        return Console(file=stream, highlight=False, soft_wrap=True)
    lines: TextIO = _JournalLines(level)  # type: ignore[assignment]
    return Console(file=lines, width=WIDTH, force_terminal=False, no_color=True, highlight=False)
