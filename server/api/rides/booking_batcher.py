"""Bookings that arrive while others are being decided are decided together, on one snapshot of the fleet."""

import asyncio

from server.domain.errors import StoreFailure
from server.domain.rides.rides import BookRide
from server.usecases.ports.unit_of_work import Transactions
from server.usecases.rides import rides

TOGETHER_MAX = 32


class BookingBatcher:
    """Answers in the order of arrival. A first booking does not wait for others."""

    def __init__(self, transactions: Transactions) -> None:
        self._transactions = transactions
        self._waiting: list[tuple[BookRide, asyncio.Future[rides.BookingResult]]] = []
        self._worker: asyncio.Task[None] | None = None

    async def book(self, request: BookRide) -> rides.BookingResult:
        """Raises what `rides.book` raises."""
        answer: asyncio.Future[rides.BookingResult] = asyncio.get_running_loop().create_future()
        self._waiting.append((request, answer))
        if self._worker is None:
            self._worker = asyncio.get_running_loop().create_task(self._work(), name="booking-batcher")
        return await answer

    async def _work(self) -> None:
        try:
            while self._waiting:
                together = self._waiting[:TOGETHER_MAX]
                del self._waiting[: len(together)]
                await self._decide(together)
        finally:
            self._worker = None

    async def _decide(self, together: list[tuple[BookRide, asyncio.Future[rides.BookingResult]]]) -> None:
        """Decide all in one transaction. If that fails, decide each one alone, so that one harms no other.

        If the database fails, all get its error: a booking whose outcome is unknown is not made twice.
        """
        requests = [request for request, _ in together]
        work = self._transactions.run(lambda uow: rides.book_all(uow, requests))
        (booked,) = await asyncio.gather(work, return_exceptions=True)
        if isinstance(booked, list):
            for (_, answer), result in zip(together, booked, strict=True):
                _settle(answer, result)
        elif len(together) == 1 or isinstance(booked, StoreFailure):
            for _, answer in together:
                _settle(answer, booked)
        else:
            for one in together:
                await self._decide([one])


def _settle(answer: asyncio.Future[rides.BookingResult], result: rides.BookingResult | BaseException) -> None:
    """Answer the caller, unless it has gone. Its booking is made all the same."""
    if answer.done():
        return
    if isinstance(result, BaseException):
        answer.set_exception(result)
    else:
        answer.set_result(result)
