"""Where forks of the past are computed."""

import asyncio
import os
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context

from server.domain.errors import ForksBusy
from server.supervision.parent_end import end_with_parent
from server.usecases.planning.forks import ForkInput, ForkResult, run_fork

# Under way or waiting for the child.
FORKS_MAX = 3


class InlineForks:
    """For virtual time: in the caller's own step."""

    async def run(self, fork: ForkInput) -> ForkResult:
        return run_fork(fork)


class ProcessForks:
    """In a child process of low priority, one after another. The child starts with the first fork.

    begins  called first in the child process
    """

    def __init__(self, begins: Callable[[], None] | None = None) -> None:
        self._begins = begins
        self._pool: ProcessPoolExecutor | None = None
        self._under_way = 0

    async def run(self, fork: ForkInput) -> ForkResult:
        """Raises ForksBusy, BrokenProcessPool if the child has died; the next call has a new one."""
        if self._under_way >= FORKS_MAX:
            raise ForksBusy(f"{FORKS_MAX} comparisons are computed already: try again when they are done")
        if self._pool is None:
            # Spawned: a fork would copy the store's threads and their locks in the middle of their work.
            self._pool = ProcessPoolExecutor(1, get_context("spawn"), _begin, (self._begins,))
        self._under_way += 1
        try:
            return await asyncio.get_running_loop().run_in_executor(self._pool, run_fork, fork)
        except BrokenProcessPool:
            self.close()
            raise
        finally:
            self._under_way -= 1

    def close(self) -> None:
        if self._pool is not None:
            self._pool.shutdown(wait=False, cancel_futures=True)
            self._pool = None


def _begin(begins: Callable[[], None] | None) -> None:
    """Lower the priority: bookings and vehicles come first."""
    end_with_parent()
    if begins is not None:
        begins()
    if hasattr(os, "nice"):
        os.nice(15)
