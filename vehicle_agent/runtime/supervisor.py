"""Keeps a set of processes running: starts them, starts one again that has ended, stops all on SIGTERM.

A child that keeps ending is started less and less often; its exit is logged every time.
"""

import multiprocessing
import signal
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from multiprocessing.context import SpawnProcess
from types import FrameType
from typing import Any

import structlog

log = structlog.get_logger()

FIRST_PAUSE_S = 0.2
LONGEST_PAUSE_S = 10.0
STABLE_AFTER_S = 20.0
STOP_WITHIN_S = 8.0
LOOK_EVERY_S = 0.1


@dataclass(frozen=True, slots=True)
class Job:
    """A process to keep running: a module-level function and its arguments. restart: start it again."""

    name: str
    target: Callable[..., None]
    arguments: tuple[Any, ...] = ()
    restart: bool = True


@dataclass(slots=True)
class _Child:
    job: Job
    process: SpawnProcess
    started_s: float
    pause_s: float = FIRST_PAUSE_S
    due_s: float = field(default=0.0)


class Supervisor:
    """pids: process ids by job name, for whoever wants to look or to kill."""

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

    def look(self) -> None:
        """Start again what has ended and is due."""
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
        """Whether a job that is not restarted has ended."""
        return not self._children[name].process.is_alive()

    def stop(self) -> None:
        """SIGTERM to every child, last started first; SIGKILL for who does not end in time."""
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
        """Until SIGTERM or SIGINT."""
        signal.signal(signal.SIGTERM, self._stop)
        signal.signal(signal.SIGINT, self._stop)
        self.start()
        while not self._stopping:
            self.look()
            time.sleep(LOOK_EVERY_S)
        self.stop()

    def _spawn(self, job: Job) -> SpawnProcess:
        process = self._context.Process(target=job.target, args=job.arguments, name=job.name, daemon=False)
        process.start()
        return process

    def _stop(self, _number: int, _frame: FrameType | None) -> None:
        self._stopping = True
