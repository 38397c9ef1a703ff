"""The end of a process that cannot do its work: a last word, then an exit code for what restarts it."""

import os
import threading
from contextlib import suppress

import uvicorn
from rich.console import Console

# EX_SOFTWARE of sysexits.h: an internal error; a service manager restarts the process.
CANNOT_WORK = 70
# What does not end by itself within this time is ended.
END_WITHIN_S = 55.0


class ProcessEnd:
    """`demand` stops the server; afterwards `text` says why."""

    def __init__(self, console: Console) -> None:
        self.text = ""
        self._console = console
        self._server: uvicorn.Server | None = None

    def stops(self, server: uvicorn.Server) -> None:
        self._server = server
        server.should_exit = server.should_exit or bool(self.text)

    def demand(self, text: str, error: BaseException) -> None:
        """Stop the server in order; if that hangs, end the process all the same."""
        if self.text:
            return
        self.text = text
        if self._server is not None:
            self._server.should_exit = True
        watchdog = threading.Timer(END_WITHIN_S, os._exit, (CANNOT_WORK,))
        watchdog.daemon = True
        watchdog.start()
        # A full disk may refuse even the last word; the exit code tells all the same.
        with suppress(OSError):
            self._console.print(f"campusloop serve ends: {text}", style="red", markup=False)
