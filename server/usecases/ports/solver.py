"""Where the dispatcher's long computations run."""

from typing import Protocol

from server.dispatch.problem import Problem
from server.dispatch.solve import Budget, Solution


class Solver(Protocol):
    """`dispatch.solve` somewhere: inline, or in a child process."""

    async def solve(self, problem: Problem, budget: Budget, seed: int) -> Solution: ...
