"""The only connection that writes: groups of use cases, each group one transaction under the campus's lock.

Whatever the database does, callers are told what is true of their group: stored, not stored, or unknown.
After a failure the connection is replaced and the memory is forgotten, so no half of a transaction is left.
After a lock or a full disk the connection is as good as before: what was changed in memory is taken back.
"""

from collections.abc import Callable, Sequence
from contextlib import nullcontext
from types import TracebackType
from typing import Any, Generic, TypeVar

import structlog
from sqlalchemy import Connection, Engine

from server.domain.errors import DomainError, OutcomeUnknown, PlanChanged, StoreUnavailable
from server.store.cache.memory import RowCache
from server.store.database_file import database_file
from server.store.engine import is_in_memory
from server.store.unit_of_work import Context, PublishedMessages, SqlUnitOfWork
from server.store.writing.campus_lock import CampusLock, take_campus_lock, was_committed
from server.store.writing.failures import (
    TransactionLost,
    cause_of,
    cause_of_loss,
    is_cut,
    is_in_transaction,
    is_unavailable,
    leaves_connection_whole,
)
from server.store.writing.retries import Patience, Retries
from server.usecases.ports.unit_of_work import UnitOfWork

T = TypeVar("T")
Work = Callable[[UnitOfWork], T]

ATTEMPTS = 8

log = structlog.get_logger("store")


class Kept:
    """As a context it keeps an exception from inside."""

    def __init__(self) -> None:
        self.failure: BaseException | None = None

    def __enter__(self) -> None:
        self.failure = None

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> bool:
        self.failure = error
        return error is not None


class Job(Kept, Generic[T]):
    """A use case, and then its result with its messages, or its failure."""

    def __init__(self, work: Work[T]) -> None:
        super().__init__()
        self.work = work
        self.done: tuple[T, PublishedMessages] | None = None

    def result(self) -> tuple[T, PublishedMessages]:
        """Raises the failure of the use case, StoreUnavailable or OutcomeUnknown."""
        if self.failure is not None:
            raise self.failure
        assert self.done is not None
        return self.done


class Writer:
    """Belongs to one thread at a time."""

    def __init__(self, engine: Engine, context: Context, retries: Retries) -> None:
        self._engine = engine
        self._context = context
        self._retries = retries
        self._memory = RowCache()
        self._file = database_file(engine)
        self._connection: Connection | None = None

    def write(self, jobs: Sequence[Job[Any]]) -> bool:
        """Run all jobs in one transaction; each one has its result or failure afterwards.

        False if the database could not be used for as long as the retries allow.
        """
        patience = self._retries.begin()
        while True:
            attempt = Kept()
            with attempt:
                # A job that is alone needs no savepoint: it is rolled back with the transaction.
                is_alone = len(jobs) == 1
                self._attempt(jobs, patience, 0 if is_alone else ATTEMPTS)
                if is_alone and isinstance(jobs[0].failure, PlanChanged):
                    self._attempt(jobs, patience, ATTEMPTS - 1)
            error = attempt.failure
            if error is None:
                return True
            if not (leaves_connection_whole(error) and self._is_rolled_back()):
                self._reset()
            unavailable = is_unavailable(error)
            if unavailable:
                _warn("store.unavailable", error)
            if not unavailable or not patience.wait():
                told = _refusal(error) if unavailable else error
                for job in jobs:
                    job.failure = job.failure or told
                return not isinstance(told, StoreUnavailable)

    def connection(self) -> Connection:
        """The open connection, for reads between transactions."""
        if self._connection is None:
            self._connection = self._engine.connect()
            if self._file is not None:
                self._file.opened()
        return self._connection

    def close(self) -> None:
        """Close the connection and forget all. A later use opens it again, as after a start."""
        self._memory.forget()
        if self._connection is not None:
            self._connection.close()
            self._connection = None

    # ---------------------------------------------------------------- one attempt

    def _attempt(self, jobs: Sequence[Job[Any]], patience: Patience, attempts: int) -> None:
        """attempts: of each job, in savepoints; 0 for one without any, of a job that is alone."""
        if self._file is not None and self._file.is_replaced():
            raise StoreUnavailable(
                "the database file was replaced while the server ran: stop the server, then restore the file"
            )
        connection = self.connection()
        transaction = connection.begin()
        lock = take_campus_lock(connection, self._context.campus_id, self._retries.chance())
        self._memory.begin(lock.found, lock.made)
        try:
            try:
                for job in jobs:
                    self._run(connection, lock, job, attempts)
            finally:
                lock.is_held = False
            if not lock.has_written or all(job.failure is not None for job in jobs):
                # PostgreSQL would flush the lock itself to the disk, for nothing.
                transaction.rollback()
                self._memory.is_at(lock.found)
                return
            commit = Kept()
            with commit:
                transaction.commit()
            if commit.failure is not None:
                self._require_committed(connection, lock, commit.failure, patience)
        except BaseException:
            self._memory.take_back(0)
            self._memory.is_at(lock.found)
            raise

    def _run(self, connection: Connection, lock: CampusLock, job: Job[Any], attempts: int) -> None:
        """Run a job. Its own failure is kept in it; one of the database is raised."""
        with job:
            in_savepoint = attempts > 0
            job.done = _repeated(lambda: self._decide(connection, lock, job.work, in_savepoint), attempts)
        error = job.failure
        if error is None:
            return
        is_lost = not is_in_transaction(connection)
        if is_lost or is_unavailable(error):
            # The whole group fails, and is told why all together.
            job.failure = None
            raise TransactionLost from cause_of_loss(error)

    def _decide(
        self, connection: Connection, lock: CampusLock, work: Work[T], in_savepoint: bool
    ) -> tuple[T, PublishedMessages]:
        """The result and the messages. After a failure the memory is as before.

        So are the rows with a savepoint; without one the caller rolls back.
        """
        mark = self._memory.mark()
        try:
            with connection.begin_nested() if in_savepoint else nullcontext():
                uow = SqlUnitOfWork(connection, self._context, lock=lock, memory=self._memory)
                result = work(uow)
                uow.flush()
                return result, tuple(uow.outgoing.messages.values())
        except BaseException:
            self._memory.take_back(mark)
            raise

    # ---------------------------------------------------------------- after a failure

    def _require_committed(
        self, connection: Connection, lock: CampusLock, error: BaseException, patience: Patience
    ) -> None:
        """A commit failed. Raises, unless it is stored all the same: its answer was lost with the connection.

        Raises OutcomeUnknown if the database cannot be asked, or cannot tell any more.
        """
        if not is_cut(connection, error):
            raise error
        self._reset()
        _warn("store.commit_cut", error)
        while patience.wait():
            asked = Kept()
            with asked, self._engine.connect() as other, other.begin():
                stored = was_committed(other, lock)
            if asked.failure is None and stored is not None:
                if stored:
                    return
                raise TransactionLost from error
            if asked.failure is None or not is_unavailable(asked.failure):
                break
        raise OutcomeUnknown(
            "the connection to the database was lost during the commit: the request may be stored or not; "
            "read before you ask again, or ask again with the same Idempotency-Key"
        ) from error

    def _is_rolled_back(self) -> bool:
        """Roll back what is left of a transaction on the same connection. False if that did not work."""
        undone = Kept()
        with undone:
            if self._connection is not None:
                self._connection.rollback()
        return undone.failure is None

    def _reset(self) -> None:
        """Roll back, whatever state the connection is in. A file or a server gets a new connection."""
        self._memory.forget()
        connection, self._connection = self._connection, None
        if connection is None:
            return
        undone = Kept()
        with undone:
            if not is_in_memory(self._engine):
                connection.invalidate()
            connection.close()
        if undone.failure is not None:
            _warn("store.connection_dropped", undone.failure)


def _warn(event: str, error: BaseException) -> None:
    """Log it, if the log can be written: a full disk may refuse that too."""
    with Kept():
        log.warning(event, cause=cause_of(error))


def _refusal(error: BaseException) -> DomainError:
    refusal = StoreUnavailable(f"the database cannot be used now ({cause_of(error)}); ask again in seconds")
    refusal.__cause__ = error
    return refusal


def _repeated(once: Callable[[], T], attempts: int) -> T:
    """Decide again on what has changed in the meantime, a bounded number of times."""
    for _ in range(attempts - 1):
        try:
            return once()
        except PlanChanged:
            continue
    return once()
