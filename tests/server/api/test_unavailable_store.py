"""What clients are told while the database cannot be used."""

import asyncio
from collections.abc import Callable
from typing import Any, TypeVar

import pytest

from server.adapters import SystemClock
from server.api.rides.booking_batcher import BookingBatcher
from server.domain.errors import DomainError, OutcomeUnknown, StoreUnavailable
from server.domain.rides.rides import BookRide
from server.usecases.ports.unit_of_work import UnitOfWork
from tests.server.api.server_under_test import ServerUnderTest

T = TypeVar("T")


class FailingTransactions:
    """Transactions on a database that is lost."""

    def __init__(self, error: DomainError) -> None:
        self.error = error
        self.runs = 0

    async def run(self, work: Callable[[UnitOfWork], T]) -> T:
        self.runs += 1
        raise self.error

    async def read(self, work: Callable[[UnitOfWork], T]) -> T:
        raise self.error


@pytest.mark.parametrize("error", [StoreUnavailable("locked"), OutcomeUnknown("cut")], ids=lambda e: e.code)
def test_a_booking_is_answered_with_503_and_when_to_ask_again(
    server: ServerUnderTest, monkeypatch: pytest.MonkeyPatch, error: DomainError
) -> None:
    monkeypatch.setattr(server.transactions, "run", FailingTransactions(error).run)
    answer = server.post("/rides", {"from_stop": "NN7", "to_stop": "C6", "party": 1})
    assert answer.status_code == 503
    assert answer.json()["code"] == error.code
    assert int(answer.headers["retry-after"]) >= 1


@pytest.mark.parametrize("error", [StoreUnavailable("locked"), OutcomeUnknown("cut")], ids=lambda e: e.code)
def test_bookings_that_were_decided_together_are_not_tried_again_one_by_one(error: DomainError) -> None:
    transactions = FailingTransactions(error)
    batcher = BookingBatcher(transactions, SystemClock())

    async def scenario() -> list[Any]:
        requests = [BookRide("NN7", "C6", 1) for _ in range(3)]
        return await asyncio.gather(*(batcher.book(one) for one in requests), return_exceptions=True)

    assert asyncio.run(scenario()) == [error] * 3
    assert transactions.runs == 1
