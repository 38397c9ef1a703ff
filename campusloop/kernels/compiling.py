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

from campusloop.kernels.caches import CachesNotWritable, KernelCaches
from campusloop.kernels.groups import GROUPS
from campusloop.kernels.sources import Sources
from campusloop.telemetry.journal_console import journal_console

PACKAGES = ("contract", "server", "vehicle_agent", "simulator", "workshop", "campusloop")
_POLL_S = 0.2
_PR_SET_PDEATHSIG = 1

# How many kernels this process has compiled, in its own slot of an array that its parent reads.
_counts: Any = None


class KernelError(Exception):
    """A group could not be compiled; the message says which and why."""


@dataclass(slots=True)
class _CompileJob:
    group: str
    future: Future[float]
    begun_s: float = 0.0
    task: Any = field(default=None)


def compile_kernels(groups: tuple[str, ...], console: Console) -> None:
    """Compile the missing kernels of these groups, so that no tick and no booking waits for the compiler.

    Prints nothing if all are compiled. Raises KernelError and CachesNotWritable.
    """
    caches = _caches()
    missing = caches.missing(groups)
    if missing:
        _compile(missing, caches.record_complete, console)


def uncompiled_kernels(groups: tuple[str, ...]) -> tuple[str, ...]:
    """Which of these groups the next command may have to compile. Changes no file."""
    return _caches().not_known_complete(groups)


def prepare_kernels(groups: tuple[str, ...], console: Console) -> None:
    """`compile_kernels` for a command that goes on where the caches cannot be written: its processes then
    compile at each start. Raises KernelError."""
    try:
        compile_kernels(groups, console)
    except CachesNotWritable as error:
        console.print(
            f"compiled kernels cannot be kept, so that every start takes longer: {error}", highlight=False
        )


def ensure_kernels(groups: tuple[str, ...]) -> None:
    """`prepare_kernels` for a command that prints to stdout. Exits when a kernel does not compile."""
    try:
        prepare_kernels(groups, journal_console(sys.stderr))
    except KernelError as error:
        raise SystemExit(str(error)) from error


def _caches() -> KernelCaches:
    return KernelCaches(Sources(Path(__file__).parents[2], PACKAGES))


def _compile(groups: tuple[str, ...], on_complete: Callable[[str], None], console: Console) -> None:
    started = time.perf_counter()
    spawning = multiprocessing.get_context("spawn")
    compiled = spawning.Array("q", len(GROUPS))
    cores = min(len(groups), os.cpu_count() or 1)
    console.print(f"compiling kernels on {cores} cores, once: {', '.join(groups)}", highlight=False)
    numbers = {name: number for number, name in enumerate(GROUPS)}
    with (
        ProcessPoolExecutor(
            cores, mp_context=spawning, initializer=_start_worker, initargs=(compiled, os.getpid())
        ) as pool,
        _progress(console) as progress,
    ):
        jobs = [_CompileJob(name, pool.submit(_warm, GROUPS[name].warm, numbers[name])) for name in groups]
        bars = {job.group: progress.add_task(job.group, start=False, total=None, compiled=0) for job in jobs}
        open_jobs = list(jobs)
        while open_jobs:
            time.sleep(_POLL_S)
            for job in list(open_jobs):
                count = compiled[numbers[job.group]]
                if job.future.running() or job.future.done():
                    progress.start_task(bars[job.group])
                progress.update(bars[job.group], compiled=count)
                if not job.future.done():
                    continue
                took_s = _result(job)
                on_complete(job.group)
                progress.stop_task(bars[job.group])
                progress.update(bars[job.group], visible=False)
                open_jobs.remove(job)
                done = len(jobs) - len(open_jobs)
                console.print(
                    f"kernels {done}/{len(jobs)}: {job.group}, {count} compiled in {took_s:.0f} s",
                    highlight=False,
                )
    console.print(f"kernels ready after {time.perf_counter() - started:.0f} s", highlight=False)


def _result(job: _CompileJob) -> float:
    try:
        return job.future.result()
    except BrokenProcessPool as error:
        raise KernelError(
            f"the process that compiled the kernels of {job.group} was killed; is there too little memory?"
        ) from error
    except Exception as error:
        raise KernelError(f"the kernels of {job.group} do not compile: {error}") from error


def _progress(console: Console) -> Progress:
    """Disabled where the console is no terminal."""
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


def _start_worker(compiled: Any, parent: int) -> None:
    """In a process of the pool: end with the parent process, and let Ctrl-C end this process at once."""
    global _counts
    _counts = compiled
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
    if os.getppid() != parent:
        sys.exit(0)


def _warm(target: str, slot: int) -> float:
    """Call the group's warm function, which calls each kernel. Returns the wall time in seconds."""
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
