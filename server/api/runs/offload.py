"""The two kinds of `server.usecases.ports.offload.Offload`: a thread, and at once."""

import asyncio
from collections.abc import Callable
from typing import TypeVar

T = TypeVar("T")


class ThreadOffload:
    """Live: the loop's thread pool."""

    async def run(self, work: Callable[[], T]) -> T:
        return await asyncio.to_thread(work)


class InlineOffload:
    """Virtual time, where nothing else may run meanwhile."""

    async def run(self, work: Callable[[], T]) -> T:
        return work()
