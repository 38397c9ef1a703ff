"""Use cases run whole: all of one in one transaction, its messages sent only after the commit.

`GroupCommit` is live, on SQLite and on PostgreSQL: one writer thread, many use cases to a commit, each in its
own savepoint. `InlineTransactions` is virtual time: no threads, no waiting.
"""

import asyncio
import contextvars
import queue
import threading
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import Any, TypeVar

import structlog
from sqlalchemy import Engine

from server.domain.errors import DomainError, StoreUnavailable
from server.store.engine import read_only
from server.store.unit_of_work import Context, PublishedMessage, PublishedMessages, SqlUnitOfWork
from server.store.writing.failures import cause_of, is_unavailable
from server.store.writing.retries import NO_RETRIES, Retries
from server.store.writing.writer import Job, Kept, Work, Writer
from server.usecases.ports.bus import Bus

T = TypeVar("T")

GROUP_MAX = 256
READERS = 4

log = structlog.get_logger("store")


class InlineTransactions:
    """Runs everything at once, on one connection, in the caller's own step. It never waits or repeats."""

    def __init__(self, engine: Engine, context: Context, bus: Bus) -> None:
        self._writer = Writer(engine, context, NO_RETRIES)
        self._context = context
        self._bus = bus

    async def run(self, work: Work[T]) -> T:
        job = Job(work)
        self._writer.write([job])
        result, messages = job.result()
        await _send(self._bus, messages)
        return result

    async def read(self, work: Work[T]) -> T:
        connection = self._writer.connection()
        with read_only(connection):
            return work(SqlUnitOfWork(connection, self._context))

    async def close(self) -> None:
        self._writer.close()


class _WaitingJob(Job[T]):
    """A use case that waits for its turn, and the future of its caller."""

    def __init__(self, work: Work[T], loop: asyncio.AbstractEventLoop) -> None:
        super().__init__(_in_this_context(work))
        self._loop = loop
        self.future: asyncio.Future[tuple[T, PublishedMessages]] = loop.create_future()

    def tell(self) -> None:
        """Answer the caller from the writer's thread, unless its event loop has ended."""
        with Kept():
            self._loop.call_soon_threadsafe(self._settle)

    def _settle(self) -> None:
        if self.future.done():
            return
        if self.failure is not None:
            self.future.set_exception(self.failure)
        elif self.done is not None:
            self.future.set_result(self.done)


def _look_at(running: "asyncio.Task[Any]") -> None:
    error = None if running.cancelled() else running.exception()
    if error is not None and not isinstance(error, DomainError):
        log.error("store.work_failed", exc_info=error)


class GroupCommit:
    """One thread writes; use cases that arrive while it commits share the next commit.

    retries  for a database that cannot be used: locked, full, restarting
    """

    def __init__(self, engine: Engine, context: Context, bus: Bus, retries: Retries | None = None) -> None:
        self._engine = engine
        self._context = context
        self._bus = bus
        self._closing = threading.Event()
        self._retries = retries or Retries(pause=lambda seconds: not self._closing.wait(seconds))
        self._jobs: queue.SimpleQueue[_WaitingJob[Any] | None] = queue.SimpleQueue()
        self._readers = ThreadPoolExecutor(READERS, thread_name_prefix="store-reader")
        self._writer = threading.Thread(target=self._write_all, name="store-writer", daemon=True)
        self._writer.start()

    async def run(self, work: Work[T]) -> T:
        running = asyncio.get_running_loop().create_task(self._run(work))
        try:
            return await asyncio.shield(running)
        except asyncio.CancelledError:
            # The work goes on. Its refusal would be reported as an error that was never looked at.
            running.add_done_callback(_look_at)
            raise

    async def read(self, work: Work[T]) -> T:
        loop = asyncio.get_running_loop()
        return await loop.run_in_executor(self._readers, self._read, _in_this_context(work))

    async def close(self) -> None:
        """Close after every job has been written, or refused once."""
        self._closing.set()
        self._jobs.put(None)
        await asyncio.get_running_loop().run_in_executor(None, self._writer.join)
        self._readers.shutdown(wait=True)
        self._engine.dispose()

    async def _run(self, work: Work[T]) -> T:
        job = _WaitingJob(work, asyncio.get_running_loop())
        self._jobs.put(job)
        result, messages = await job.future
        await _send(self._bus, messages)
        return result

    # ---------------------------------------------------------------- the writer's thread

    def _write_all(self) -> None:
        going = True
        writer = Writer(self._engine, self._context, self._retries)
        while going:
            jobs, going = self._next_group()
            if jobs and not writer.write(jobs):
                late, going = self._refuse_waiting(jobs[0].failure, going)
                jobs += late
            for job in jobs:
                job.tell()
        writer.close()

    def _next_group(self) -> tuple[list[_WaitingJob[Any]], bool]:
        """Wait for one job and take all others that wait; False if the store is being closed."""
        group: list[_WaitingJob[Any]] = []
        job = self._jobs.get()
        while job is not None:
            group.append(job)
            if len(group) == GROUP_MAX or self._jobs.empty():
                return group, True
            job = self._jobs.get()
        return group, False

    def _refuse_waiting(
        self, error: BaseException | None, going: bool
    ) -> tuple[list[_WaitingJob[Any]], bool]:
        """Refuse what waits behind a database that cannot be used: each would wait as long again."""
        refused: list[_WaitingJob[Any]] = []
        while going and not self._jobs.empty():
            job = self._jobs.get()
            if job is None:
                return refused, False
            job.failure = error
            refused.append(job)
        return refused, going

    # ---------------------------------------------------------------- readers' threads

    def _read(self, work: Work[T]) -> T:
        """Read, again if the database could not be used. Raises StoreUnavailable."""
        patience = self._retries.begin()
        while True:
            kept = Kept()
            with kept, self._engine.connect() as connection, read_only(connection):
                return work(SqlUnitOfWork(connection, self._context))
            error = kept.failure
            assert error is not None
            if not is_unavailable(error):
                raise error
            if not patience.wait():
                raise StoreUnavailable(f"the database cannot be read now ({cause_of(error)})") from error


def _in_this_context(work: Work[T]) -> Work[T]:
    """The work with the caller's context: what it logs in another thread names the caller's request."""
    context = contextvars.copy_context()
    return lambda uow: context.run(work, uow)


async def _send(bus: Bus, messages: Iterable[PublishedMessage]) -> None:
    for message in messages:
        await bus.publish(message.topic, message.payload)
