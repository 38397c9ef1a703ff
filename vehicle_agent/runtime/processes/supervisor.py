"""Keeps a set of processes running: starts them, restarts one that has ended, stops all on SIGTERM.

A child that keeps ending is restarted after longer and longer pauses; each exit is logged.
"""

import ctypes
import multiprocessing
import os
import signal
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from multiprocessing.context import SpawnProcess
from pathlib import Path
from types import FrameType

import structlog

from vehicle_agent.runtime.processes.journal import run_logged, write_journal

log = structlog.get_logger()

FIRST_PAUSE_S = 0.2
LONGEST_PAUSE_S = 10.0
STABLE_AFTER_S = 20.0
STOP_WITHIN_S = 8.0
CHECK_EVERY_S = 0.1
_PR_SET_PDEATHSIG = 1


@dataclass(frozen=True, slots=True)
class Job:
    """A process to keep running: a module-level function and its arguments.

    restart   restart it when it ends
    log_file  its output is appended here; None: the parent's output
    """

    name: str
    target: Callable[..., object]
    arguments: tuple[object, ...] = ()
    restart: bool = True
    log_file: Path | None = None


@dataclass(slots=True)
class _Child:
    job: Job
    process: SpawnProcess
    started_s: float
    pause_s: float = FIRST_PAUSE_S
    due_s: float = field(default=0.0)


class Supervisor:
    """pids: process ids of running jobs, by name."""

    def __init__(self, jobs: list[Job]) -> None:
        """Jobs are started in order and stopped in reverse order."""
        self._context = multiprocessing.get_context("spawn")
        self._jobs = jobs
        self._children: dict[str, _Child] = {}
        self._stopping = False

    @property
    def pids(self) -> dict[str, int]:
        return {
            name: child.process.pid
            for name, child in self._children.items()
            if child.process.pid is not None and child.process.is_alive()
        }

    def start(self) -> None:
        for job in self._jobs:
            self._children[job.name] = _Child(job, self._spawn(job), time.monotonic())

    def restart_ended(self) -> None:
        """Restarts the jobs that have ended and are due."""
        now_s = time.monotonic()
        for name, child in self._children.items():
            if child.process.is_alive() or not child.job.restart:
                continue
            if child.due_s == 0.0:
                if now_s - child.started_s > STABLE_AFTER_S:
                    child.pause_s = FIRST_PAUSE_S
                child.due_s = now_s + child.pause_s
                child.pause_s = min(2.0 * child.pause_s, LONGEST_PAUSE_S)
                log.error("process.ended", name=name, exit_code=child.process.exitcode)
            if now_s >= child.due_s:
                child.process, child.started_s, child.due_s = self._spawn(child.job), now_s, 0.0
                log.info("process.restarted", name=name, pid=child.process.pid)

    def has_ended(self, name: str) -> bool:
        """True if a job that is not restarted has ended."""
        return not self._children[name].process.is_alive()

    def stop(self) -> None:
        """Sends SIGTERM to every child, last started first, and SIGKILL to one that does not end in time."""
        for child in reversed(self._children.values()):
            if child.process.is_alive():
                child.process.terminate()
        deadline_s = time.monotonic() + STOP_WITHIN_S
        for name, child in self._children.items():
            child.process.join(max(0.0, deadline_s - time.monotonic()))
            if child.process.is_alive():
                log.error("process.killed", name=name)
                child.process.kill()
                child.process.join()

    def run(self) -> None:
        """Runs until SIGTERM or SIGINT."""
        signal.signal(signal.SIGTERM, self._stop)
        signal.signal(signal.SIGINT, self._stop)
        self.start()
        while not self._stopping:
            self.restart_ended()
            time.sleep(CHECK_EVERY_S)
        self.stop()

    def _spawn(self, job: Job) -> SpawnProcess:
        process = self._context.Process(target=_run, args=(job, os.getpid()), name=job.name, daemon=False)
        process.start()
        return process

    def _stop(self, _number: int, _frame: FrameType | None) -> None:
        self._stopping = True


def _run(job: Job, parent: int) -> None:
    """Runs a job in the child, in its own session and never without its parent.

    Ctrl-C then reaches the parent only, which stops its children in order.
    """
    os.setsid()
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
    if os.getppid() != parent:
        return
    if job.log_file is not None:
        file = os.open(job.log_file, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644)
        os.dup2(file, 1)
        os.dup2(file, 2)
    write_journal(job.name)
    run_logged(job.target, *job.arguments)
