"""A use case tried out: what it would answer, with nothing of it kept."""

from collections.abc import Callable
from typing import TypeVar

from server.usecases.ports.unit_of_work import Transactions, UnitOfWork

T = TypeVar("T")


class _RolledBack(Exception):
    """Raised inside the transaction, which is rolled back for it, to carry the answer out."""

    def __init__(self, answer: object) -> None:
        super().__init__()
        self.answer = answer


async def dry_run(transactions: Transactions, work: Callable[[UnitOfWork], T]) -> T:
    """What `work` would answer now. Its transaction is rolled back, and nothing is published."""

    def tried(uow: UnitOfWork) -> T:
        answer = work(uow)
        raise _RolledBack(answer)

    try:
        return await transactions.run(tried)
    except _RolledBack as undone:
        answer: T = undone.answer  # type: ignore[assignment]
        return answer
