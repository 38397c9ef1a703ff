"""The server's store with the faults of a real one: full disks, a foreign lock, slow commits, and ends of the
process around a commit."""

import asyncio
import random
import sqlite3
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, TypeVar

from sqlalchemy import Connection, Engine, event
from sqlalchemy.exc import OperationalError

from server.store.engine import open_engine
from server.store.schema import upgrade_to_head
from server.store.transactions import InlineTransactions
from server.store.writing.writer import Work

T = TypeVar("T")


class SimulatedDatabase:
    """An SQLite database in memory that outlives the server processes that use it.

    The disk is full by SQLite's own page limit, so its errors and what is rolled back are the real ones. A
    lock of another process is SQLite's error at the beginning of a transaction.
    """

    def __init__(self) -> None:
        self.engine: Engine = open_engine("sqlite://")
        self._is_locked = False
        upgrade_to_head(self.engine)

    @property
    def is_locked(self) -> bool:
        return self._is_locked

    @is_locked.setter
    def is_locked(self, locked: bool) -> None:
        # Listening to every statement costs time, so only while it is locked.
        if locked != self._is_locked:
            self._is_locked = locked
            change = event.listen if locked else event.remove
            change(self.engine, "before_cursor_execute", _refuse_to_begin)

    def fill_disk(self) -> None:
        """No page can be added from now on."""
        self._pragma("max_page_count=1")

    def free_disk(self) -> None:
        self._pragma("max_page_count=4294967294")

    def _pragma(self, text: str) -> None:
        raw = self.engine.raw_connection()
        try:
            raw.cursor().execute(f"PRAGMA {text}").close()
        finally:
            raw.close()


def _refuse_to_begin(_connection: Connection, _cursor: Any, statement: str, *_: object) -> None:
    if statement == "BEGIN IMMEDIATE":
        raise locked_error(statement)


def locked_error(statement: str) -> Exception:
    """What the driver raises for SQLITE_BUSY, as SQLAlchemy wraps it."""
    error = sqlite3.OperationalError("database is locked")
    error.sqlite_errorcode = sqlite3.SQLITE_BUSY
    return OperationalError(statement, None, error)


@dataclass
class StoreFaults:
    """The present faults of a process's store.

    slow_s         the longest time a transaction takes before and after its commit
    ends_after     the process ends after this many further commits, before anyone learns of the last one
    ends_before    the same, before the commit
    """

    slow_s: float = 0.0
    ends_after: int | None = None
    ends_before: int | None = None


@dataclass
class ProcessTransactions:
    """The transactions of one server process; after its end they are no more.

    end  ends the process, now
    """

    inner: InlineTransactions
    faults: StoreFaults
    rng: random.Random
    end: Callable[[str], None]
    is_over: bool = False
    commits: int = 0
    _order: asyncio.Lock = field(default_factory=asyncio.Lock)

    async def run(self, work: Work[T]) -> T:
        self._require_alive()
        if self.faults.slow_s:
            return await self._run_slowly(work)
        return await self._commit(work)

    async def read(self, work: Work[T]) -> T:
        self._require_alive()
        return await self.inner.read(work)

    async def _run_slowly(self, work: Work[T]) -> T:
        async with self._order:
            await asyncio.sleep(self.rng.uniform(0.0, self.faults.slow_s))
            result = await self._commit(work)
        await asyncio.sleep(self.rng.uniform(0.0, self.faults.slow_s))
        self._require_alive()
        return result

    async def _commit(self, work: Work[T]) -> T:
        self._require_alive()
        if self._is_due("ends_before"):
            self.end("before a commit")
            self._require_alive()
        result = await self.inner.run(work)
        self.commits += 1
        if self._is_due("ends_after"):
            self.end("after a commit")
        self._require_alive()
        return result

    def _is_due(self, which: str) -> bool:
        left = getattr(self.faults, which)
        if left is None:
            return False
        setattr(self.faults, which, left - 1 if left > 0 else None)
        return bool(left == 0)

    def _require_alive(self) -> None:
        if self.is_over:
            raise asyncio.CancelledError("this process has ended")
