"""Runs work that would block the event loop: reading and hashing large files."""

import asyncio
from collections.abc import Callable
from typing import Protocol, TypeVar

T = TypeVar("T")


class Offload(Protocol):
    async def run(self, work: Callable[[], T]) -> T: ...


class ThreadOffload:
    """Live: the loop's thread pool."""

    async def run(self, work: Callable[[], T]) -> T:
        return await asyncio.to_thread(work)


class InlineOffload:
    """Virtual time, where nothing else may run meanwhile."""

    async def run(self, work: Callable[[], T]) -> T:
        return work()
