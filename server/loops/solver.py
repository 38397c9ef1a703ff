"""Where the dispatcher's long computations run."""

import asyncio
import os
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context

from server.dispatch.problem import Problem
from server.dispatch.solve import Budget, Solution, solve
from server.dispatch.warm import warm_kernels
from server.supervision.parent_end import end_with_parent


class InlineSolver:
    """For virtual time: in the caller's own step, with the whole budget."""

    async def solve(self, problem: Problem, budget: Budget, seed: int) -> Solution:
        return solve(problem, budget, seed)


class ProcessSolver:
    """In a child process, so that a long search does not delay bookings.

    within_s  no slice is begun later than this; the solution says how many ran
    begins    called first in the child process
    """

    def __init__(self, within_s: float = 1.0, begins: Callable[[], None] | None = None) -> None:
        self._begins = begins
        self._pool = _new_pool(begins)
        self._within_s = within_s

    async def solve(self, problem: Problem, budget: Budget, seed: int) -> Solution:
        """Raises BrokenProcessPool if the child has died; the next call has a new one."""
        try:
            return await asyncio.get_running_loop().run_in_executor(
                self._pool, _solve_within, problem, budget, seed, self._within_s
            )
        except BrokenProcessPool:
            self._pool.shutdown(wait=False)
            self._pool = _new_pool(self._begins)
            raise

    def close(self) -> None:
        self._pool.shutdown(cancel_futures=True)


def _new_pool(begins: Callable[[], None] | None) -> ProcessPoolExecutor:
    # Spawned: a fork would copy the store's threads and their locks in the middle of their work.
    return ProcessPoolExecutor(1, get_context("spawn"), _begin, (begins,))


def _begin(begins: Callable[[], None] | None) -> None:
    """Lower the priority: bookings and vehicles come first."""
    end_with_parent()
    if begins is not None:
        begins()
    if hasattr(os, "nice"):
        os.nice(10)
    warm_kernels()


def _solve_within(problem: Problem, budget: Budget, seed: int, within_s: float) -> Solution:
    deadline_s = time.monotonic() + within_s
    return solve(problem, budget, seed, lambda: time.monotonic() < deadline_s)
