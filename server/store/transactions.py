"""Use cases run whole: all of one in one transaction, its messages sent only after the commit.

`GroupCommit` is SQLite live: one writer thread, many use cases to a commit, each in its own savepoint.
`PooledTransactions` is PostgreSQL live. `InlineTransactions` is virtual time: no threads, no waiting.
"""

import asyncio
import queue
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from types import TracebackType
from typing import Any, Generic, TypeVar

from sqlalchemy import Connection, Engine
from sqlalchemy.exc import OperationalError

from server.domain.errors import PlanChanged
from server.store.cache.memory import RowCache
from server.store.engine import read_only
from server.store.unit_of_work import Context, PublishedMessage, SqlUnitOfWork
from server.usecases.ports.bus import Bus
from server.usecases.ports.unit_of_work import UnitOfWork

T = TypeVar("T")
Work = Callable[[UnitOfWork], T]

ATTEMPTS = 8
GROUP_MAX = 256
READERS = 2
# Serialization failure and deadlock: PostgreSQL asks for the transaction to be repeated.
_REPEATABLE = frozenset({"40001", "40P01"})


class InlineTransactions:
    """Runs everything at once, on one connection, in the caller's own step."""

    def __init__(self, engine: Engine, context: Context, bus: Bus) -> None:
        self._connection = engine.connect()
        self._memory = RowCache() if engine.dialect.name == "sqlite" else None
        self._context = context
        self._bus = bus

    async def run(self, work: Work[T]) -> T:
        result, messages = _repeated(lambda: self._once(work))
        await _send(self._bus, messages)
        return result

    async def read(self, work: Work[T]) -> T:
        with read_only(self._connection):
            return work(SqlUnitOfWork(self._connection, self._context, writes=False))

    async def close(self) -> None:
        self._connection.close()

    def _once(self, work: Work[T]) -> tuple[T, Iterable[PublishedMessage]]:
        with _transaction(self._connection, self._memory):
            return _worked(work, SqlUnitOfWork(self._connection, self._context, memory=self._memory))


class PooledTransactions:
    """Many connections, each use case on its own; conflicts are repeated."""

    def __init__(self, engine: Engine, context: Context, bus: Bus, workers: int = 8) -> None:
        self._engine = engine
        self._context = context
        self._bus = bus
        self._threads = ThreadPoolExecutor(workers, thread_name_prefix="transactions")

    async def run(self, work: Work[T]) -> T:
        return await asyncio.shield(self._run(work))

    async def read(self, work: Work[T]) -> T:
        return await asyncio.get_running_loop().run_in_executor(self._threads, self._read, work)

    async def close(self) -> None:
        self._threads.shutdown(wait=True)
        self._engine.dispose()

    async def _run(self, work: Work[T]) -> T:
        loop = asyncio.get_running_loop()
        result, messages = await loop.run_in_executor(
            self._threads, lambda: _repeated(lambda: self._once(work))
        )
        await _send(self._bus, messages)
        return result

    def _once(self, work: Work[T]) -> tuple[T, Iterable[PublishedMessage]]:
        with self._engine.begin() as connection:
            return _worked(work, SqlUnitOfWork(connection, self._context))

    def _read(self, work: Work[T]) -> T:
        return _read(self._engine, self._context, work)


class _Job(Generic[T]):
    """A use case that waits for its turn, and the future of its caller.

    As a context it keeps an exception from inside for the waiting caller.
    """

    def __init__(self, work: Work[T], loop: asyncio.AbstractEventLoop) -> None:
        self.work = work
        self.loop = loop
        self.future: asyncio.Future[tuple[T, Iterable[PublishedMessage]]] = loop.create_future()
        self.done: tuple[T, Iterable[PublishedMessage]] | None = None
        self.failure: BaseException | None = None

    def __enter__(self) -> None:
        self.failure = None

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> bool:
        self.failure = error
        return error is not None

    def tell(self) -> None:
        if not self.loop.is_closed():
            self.loop.call_soon_threadsafe(self._settle)

    def _settle(self) -> None:
        if self.future.done():
            return
        if self.failure is not None:
            self.future.set_exception(self.failure)
        elif self.done is not None:
            self.future.set_result(self.done)


class GroupCommit:
    """One thread writes; use cases that arrive while it commits share the next commit."""

    def __init__(self, engine: Engine, context: Context, bus: Bus) -> None:
        self._engine = engine
        self._context = context
        self._bus = bus
        self._memory = RowCache()
        self._jobs: queue.SimpleQueue[_Job[Any] | None] = queue.SimpleQueue()
        self._readers = ThreadPoolExecutor(READERS, thread_name_prefix="store-reader")
        self._writer = threading.Thread(target=self._write_all, name="store-writer", daemon=True)
        self._writer.start()

    async def run(self, work: Work[T]) -> T:
        return await asyncio.shield(self._run(work))

    async def read(self, work: Work[T]) -> T:
        loop = asyncio.get_running_loop()
        return await loop.run_in_executor(self._readers, lambda: _read(self._engine, self._context, work))

    async def close(self) -> None:
        """Close after every job has been written."""
        self._jobs.put(None)
        await asyncio.get_running_loop().run_in_executor(None, self._writer.join)
        self._readers.shutdown(wait=True)
        self._engine.dispose()

    async def _run(self, work: Work[T]) -> T:
        job = _Job(work, asyncio.get_running_loop())
        self._jobs.put(job)
        result, messages = await job.future
        await _send(self._bus, messages)
        return result

    def _write_all(self) -> None:
        going = True
        with self._engine.connect() as connection:
            while going:
                jobs, going = self._next_group()
                if jobs:
                    self._write(connection, jobs)

    def _next_group(self) -> tuple[list[_Job[Any]], bool]:
        """Wait for one job and take all others that wait; False if the store is being closed."""
        group: list[_Job[Any]] = []
        job = self._jobs.get()
        while job is not None:
            group.append(job)
            if len(group) == GROUP_MAX or self._jobs.empty():
                return group, True
            job = self._jobs.get()
        return group, False

    def _write(self, connection: Connection, jobs: list[_Job[Any]]) -> None:
        commit: _Job[None] = _Job(_nothing, jobs[0].loop)
        with commit, _transaction(connection, self._memory):
            for job in jobs:
                with job:
                    job.done = _repeated(lambda job=job: self._in_savepoint(connection, job.work))  # type: ignore[misc]
        for job in jobs:
            job.failure = job.failure or commit.failure
            job.tell()

    def _in_savepoint(self, connection: Connection, work: Work[T]) -> tuple[T, Iterable[PublishedMessage]]:
        mark = self._memory.mark()
        try:
            with connection.begin_nested():
                return _worked(work, SqlUnitOfWork(connection, self._context, memory=self._memory))
        except BaseException:
            self._memory.take_back(mark)
            raise


def _worked(work: Work[T], uow: SqlUnitOfWork) -> tuple[T, Iterable[PublishedMessage]]:
    result = work(uow)
    uow.flush()
    return result, uow.outgoing.messages.values()


@contextmanager
def _transaction(connection: Connection, memory: RowCache | None) -> Iterator[None]:
    """One transaction. If it fails, its commit included, the memory forgets what it changed."""
    try:
        with connection.begin():
            if memory is not None:
                memory.begin(connection)
            yield
    except BaseException:
        if memory is not None:
            memory.forget()
        raise


def _nothing(_uow: UnitOfWork) -> None:
    return None


def _read(engine: Engine, context: Context, work: Work[T]) -> T:
    with engine.connect() as connection, read_only(connection):
        return work(SqlUnitOfWork(connection, context, writes=False))


def _repeated(once: Callable[[], T]) -> T:
    """Decide again on what has changed in the meantime, a bounded number of times."""
    for _ in range(ATTEMPTS - 1):
        try:
            return once()
        except PlanChanged:
            continue
        except OperationalError as error:
            if getattr(error.orig, "sqlstate", None) not in _REPEATABLE:
                raise
    return once()


async def _send(bus: Bus, messages: Iterable[PublishedMessage]) -> None:
    for message in messages:
        await bus.publish(message.topic, message.payload)
