"""Where the dispatcher's long computations run."""

import asyncio
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np

from server.dispatch.problem import Problem
from server.dispatch.solve import Budget, Solution, solve


class InlineSolver:
    """In the caller's own step: for virtual time."""

    async def solve(self, problem: Problem, budget: Budget, seed: int) -> Solution:
        return solve(problem, budget, np.random.default_rng(seed))


class ProcessSolver:
    """In a child process, so that a long search does not hold up bookings. Same seed, same answer."""

    def __init__(self) -> None:
        # Spawned: a fork would copy the store's threads and their locks in the middle of their work.
        self._pool = ProcessPoolExecutor(max_workers=1, mp_context=get_context("spawn"))

    async def solve(self, problem: Problem, budget: Budget, seed: int) -> Solution:
        return await asyncio.get_running_loop().run_in_executor(
            self._pool, _solve_seeded, problem, budget, seed
        )

    def close(self) -> None:
        self._pool.shutdown(cancel_futures=True)


def _solve_seeded(problem: Problem, budget: Budget, seed: int) -> Solution:
    return solve(problem, budget, np.random.default_rng(seed))
