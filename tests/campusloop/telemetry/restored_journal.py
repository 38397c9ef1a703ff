"""A process's log set up for one test only."""

import logging
import sys
import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager

import structlog


@contextmanager
def restored_journal() -> Iterator[None]:
    """Restore afterwards what `write_journal` sets."""
    config, root = structlog.get_config(), logging.getLogger()
    handlers, level = root.handlers[:], root.level
    show, hooks = warnings.showwarning, (sys.excepthook, threading.excepthook, sys.unraisablehook)
    # `basicConfig` closes the handlers that it replaces: those of the tests stay open.
    root.handlers.clear()
    try:
        yield
    finally:
        structlog.configure(**config)
        root.handlers[:], warnings.showwarning = handlers, show
        root.setLevel(level)
        sys.excepthook, threading.excepthook, sys.unraisablehook = hooks
