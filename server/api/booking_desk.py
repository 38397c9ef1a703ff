"""Bookings that come in while others are being decided are decided together, on one look at the fleet."""

import asyncio
from dataclasses import dataclass

from server.domain.decisions import Alternative
from server.domain.errors import DomainError
from server.domain.rides import BookRide, Ride
from server.usecases import rides
from server.usecases.ports import Transactions, UnitOfWork

TOGETHER_MAX = 32


@dataclass(frozen=True, slots=True)
class Booked:
    """alternatives  for a refused ride"""

    ride: Ride
    alternatives: tuple[Alternative, ...] = ()


class BookingDesk:
    """Answers in the order of coming. Whoever comes first waits for nobody."""

    def __init__(self, transactions: Transactions) -> None:
        self._transactions = transactions
        self._waiting: list[tuple[BookRide, asyncio.Future[Booked]]] = []
        self._worker: asyncio.Task[None] | None = None

    async def book(self, wish: BookRide) -> Booked:
        """See `rides.book` for what it raises."""
        answer: asyncio.Future[Booked] = asyncio.get_running_loop().create_future()
        self._waiting.append((wish, answer))
        if self._worker is None:
            self._worker = asyncio.get_running_loop().create_task(self._work(), name="booking-desk")
        return await answer

    async def _work(self) -> None:
        try:
            while self._waiting:
                together = self._waiting[:TOGETHER_MAX]
                del self._waiting[: len(together)]
                await self._decide(together)
        finally:
            self._worker = None

    async def _decide(self, together: list[tuple[BookRide, asyncio.Future[Booked]]]) -> None:
        """All in one transaction; where that fails, each on its own, so that one harms no other."""
        wishes = [wish for wish, _ in together]
        work = self._transactions.run(lambda uow: _booked(uow, wishes))
        (booked,) = await asyncio.gather(work, return_exceptions=True)
        if isinstance(booked, list):
            for (_, answer), result in zip(together, booked, strict=True):
                _settle(answer, result)
        elif len(together) == 1:
            _settle(together[0][1], booked)
        else:
            for one in together:
                await self._decide([one])


def _booked(uow: UnitOfWork, wishes: list[BookRide]) -> list[Booked | DomainError]:
    return [
        answer if isinstance(answer, DomainError) else Booked(answer, rides.alternatives_for(uow, answer))
        for answer in rides.book_all(uow, wishes)
    ]


def _settle(answer: asyncio.Future[Booked], result: Booked | BaseException) -> None:
    """Who has gone away meanwhile has still booked."""
    if answer.done():
        return
    if isinstance(result, BaseException):
        answer.set_exception(result)
    else:
        answer.set_result(result)
