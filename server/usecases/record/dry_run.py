"""Runs a use case in a transaction that is rolled back."""

from collections.abc import Callable
from typing import TypeVar

from server.usecases.ports.unit_of_work import Transactions, UnitOfWork

T = TypeVar("T")


class _RolledBack(Exception):
    """Carries the answer out of the transaction, which is rolled back because of it."""

    def __init__(self, answer: object) -> None:
        super().__init__()
        self.answer = answer


async def roll_back(transactions: Transactions, work: Callable[[UnitOfWork], T]) -> T:
    """The answer that `work` would give now. Nothing is stored or published."""

    def tried(uow: UnitOfWork) -> T:
        answer = work(uow)
        raise _RolledBack(answer)

    try:
        return await transactions.run(tried)
    except _RolledBack as undone:
        answer: T = undone.answer  # type: ignore[assignment]
        return answer
