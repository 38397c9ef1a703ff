"""Compiles the kernels that are missing, on all cores, and shows the progress."""

import ctypes
import multiprocessing
import os
import signal
import sys
import time
from collections.abc import Callable
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

from campusloop.kernels.caches import KernelCaches
from campusloop.kernels.groups import GROUPS
from campusloop.kernels.sources import Sources

PACKAGES = ("contract", "server", "vehicle_agent", "simulator", "campusloop")
_LOOK_EVERY_S = 0.2
_PR_SET_PDEATHSIG = 1

# How many kernels a process has compiled so far: in its own slot of an array that its parent reads.
_counts: Any = None


class KernelError(Exception):
    """A group could not be compiled; the message says which and why."""


@dataclass(slots=True)
class _Work:
    group: str
    future: Future[float]
    begun_s: float = 0.0
    task: Any = field(default=None)


def compile_kernels(groups: tuple[str, ...], console: Console) -> None:
    """Have the kernels of these groups on disk, so that no tick and no booking meets the compiler.

    Says nothing when they are there already. Raises KernelError.
    """
    caches = KernelCaches(Sources(Path(__file__).parents[2], PACKAGES))
    missing = caches.missing(groups)
    if missing:
        _compile(missing, caches.note, console)


def ready_kernels(groups: tuple[str, ...]) -> None:
    """`compile_kernels` for a command whose own output goes to stdout; ends the process when that fails."""
    try:
        compile_kernels(groups, Console(stderr=True))
    except KernelError as error:
        raise SystemExit(str(error)) from error


def _compile(groups: tuple[str, ...], note: Callable[[str], None], console: Console) -> None:
    started = time.perf_counter()
    spawning = multiprocessing.get_context("spawn")
    compiled = spawning.Array("q", len(GROUPS))
    cores = min(len(groups), os.cpu_count() or 1)
    console.print(f"compiling kernels on {cores} cores, once: {', '.join(groups)}", highlight=False)
    numbers = {name: number for number, name in enumerate(GROUPS)}
    with (
        ProcessPoolExecutor(
            cores, mp_context=spawning, initializer=_begin, initargs=(compiled, os.getpid())
        ) as pool,
        _progress(console) as progress,
    ):
        works = [_Work(name, pool.submit(_warm, GROUPS[name].warm, numbers[name])) for name in groups]
        bars = {
            work.group: progress.add_task(work.group, start=False, total=None, compiled=0) for work in works
        }
        open_works = list(works)
        while open_works:
            time.sleep(_LOOK_EVERY_S)
            for work in list(open_works):
                count = compiled[numbers[work.group]]
                if work.future.running() or work.future.done():
                    progress.start_task(bars[work.group])
                progress.update(bars[work.group], compiled=count)
                if not work.future.done():
                    continue
                took_s = _result(work)
                note(work.group)
                progress.stop_task(bars[work.group])
                progress.update(bars[work.group], visible=False)
                open_works.remove(work)
                done = len(works) - len(open_works)
                console.print(
                    f"kernels {done}/{len(works)}: {work.group}, {count} compiled in {took_s:.0f} s",
                    highlight=False,
                )
    console.print(f"kernels ready after {time.perf_counter() - started:.0f} s", highlight=False)


def _result(work: _Work) -> float:
    try:
        return work.future.result()
    except BrokenProcessPool as error:
        raise KernelError(
            f"a process that compiled the kernels of {work.group} was ended; is there too little memory?"
        ) from error


def _progress(console: Console) -> Progress:
    """Nothing where it cannot be redrawn: there the lines say enough."""
    return Progress(
        SpinnerColumn(),
        TextColumn("compiling {task.description}"),
        TextColumn("{task.fields[compiled]} kernels"),
        TimeElapsedColumn(),
        console=console,
        transient=True,
        disable=not console.is_terminal,
        refresh_per_second=4,
    )


def _begin(compiled: Any, parent: int) -> None:
    """In a process of the pool: not without its parent, and Ctrl-C is the parent's to tell."""
    global _counts
    _counts = compiled
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
    if os.getppid() != parent:
        sys.exit(0)


def _warm(target: str, slot: int) -> float:
    """Call what calls each kernel of a group; how long it took."""
    from numba.core import event

    class Counting(event.Listener):
        def on_start(self, event: Any) -> None: ...

        def on_end(self, event: Any) -> None:
            if event.data["dispatcher"].py_func.__module__.startswith(PACKAGES):
                _counts[slot] += 1

    started = time.perf_counter()
    module, function = target.split(":")
    with event.install_listener("numba:compile", Counting()):
        getattr(import_module(module), function)()
    return time.perf_counter() - started
