"""Where forks of the past are computed."""

import asyncio
import os
import signal
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from dataclasses import replace
from multiprocessing import get_context

from server.domain.errors import ForksBusy, ForkStopped, ForkUnknown
from server.supervision.parent_end import end_with_parent
from server.usecases.planning.forks import ForkInput, ForkResult, run_fork

# Under way or waiting for the child.
FORKS_MAX = 3


class InlineForks:
    """For virtual time: in the caller's own step, so that none is ever under way."""

    async def run(self, fork: ForkInput, fork_id: str) -> ForkResult:
        return run_fork(fork)

    def stop(self, fork_id: str) -> None:
        raise _unknown(fork_id)


class ProcessForks:
    """In a child process of low priority, one after another. The child starts with the first fork.

    A fork that is stopped while it is computed ends its child: the computation itself looks for nothing. The
    next fork has another child.

    begins     called first in the child process
    computing  set while the child is at work on a fork, and does not only start
    """

    def __init__(self, begins: Callable[[], None] | None = None) -> None:
        self._begins = begins
        self._pool: ProcessPoolExecutor | None = None
        self._child_pid = 0
        self.computing = asyncio.Event()
        self._turn = asyncio.Lock()
        self._under_way: list[tuple[str, asyncio.Task[ForkResult]]] = []
        self._stopped: set[asyncio.Task[ForkResult]] = set()

    async def run(self, fork: ForkInput, fork_id: str) -> ForkResult:
        """Raises ForksBusy, ForkStopped, BrokenProcessPool if the child died: the next call has another."""
        if len(self._under_way) >= FORKS_MAX:
            raise ForksBusy(f"{FORKS_MAX} comparisons are computed already: try again when they are done")
        task = asyncio.get_running_loop().create_task(self._one(fork))
        entry = fork_id, task
        self._under_way.append(entry)
        try:
            return await task
        except asyncio.CancelledError:
            if task not in self._stopped:
                # The caller itself was cancelled, as when the server ends.
                task.cancel()
                raise
            raise ForkStopped("this comparison was stopped") from None
        finally:
            self._under_way.remove(entry)
            self._stopped.discard(task)

    def stop(self, fork_id: str) -> None:
        """Raises ForkUnknown."""
        found = [task for name, task in self._under_way if name and name == fork_id]
        if not found:
            raise _unknown(fork_id)
        for task in found:
            self._stopped.add(task)
            task.cancel()

    def close(self) -> None:
        if self._pool is not None:
            self._pool.shutdown(wait=False, cancel_futures=True)
            self._pool = None

    async def _one(self, fork: ForkInput) -> ForkResult:
        async with self._turn:
            pool = await self._child()
            self.computing.set()
            try:
                return await asyncio.get_running_loop().run_in_executor(pool, _timed, fork)
            except asyncio.CancelledError:
                self._end_child()
                raise
            except BrokenProcessPool:
                self.close()
                raise
            finally:
                self.computing.clear()

    async def _child(self) -> ProcessPoolExecutor:
        if self._pool is None:
            # Spawned: a fork would copy the store's threads and their locks in the middle of their work.
            pool = ProcessPoolExecutor(1, get_context("spawn"), _begin, (self._begins,))
            try:
                self._child_pid = await asyncio.get_running_loop().run_in_executor(pool, os.getpid)
            except asyncio.CancelledError:
                pool.shutdown(wait=False, cancel_futures=True)
                raise
            self._pool = pool
        return self._pool

    def _end_child(self) -> None:
        # It may have ended by itself, as when the whole server is killed.
        with suppress(ProcessLookupError):
            os.kill(self._child_pid, signal.SIGKILL)
        self.close()


def _unknown(fork_id: str) -> ForkUnknown:
    return ForkUnknown(f"no comparison {fork_id!r} is computed here; it may be done already")


def _timed(fork: ForkInput) -> ForkResult:
    began_s = time.process_time()
    result = run_fork(fork)
    return replace(result, computing_s=time.process_time() - began_s)


def _begin(begins: Callable[[], None] | None) -> None:
    """Lower the priority: bookings and vehicles come first."""
    end_with_parent()
    if begins is not None:
        begins()
    if hasattr(os, "nice"):
        os.nice(15)
