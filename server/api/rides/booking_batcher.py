"""Bookings that arrive while others are being decided are decided together, on one snapshot of the fleet."""

import asyncio
from contextvars import Context
from dataclasses import dataclass

import structlog

from contract.tracing import RideSpans
from server.api.request_ids import current_request_id
from server.domain.errors import DomainError, StoreFailure
from server.domain.instants import ns_of
from server.domain.rides.rides import BookRide
from server.usecases.ports.clock_and_ids import Clock
from server.usecases.ports.unit_of_work import Transactions, UnitOfWork
from server.usecases.rides import rides

TOGETHER_MAX = 32


@dataclass(frozen=True, slots=True)
class _Waiting:
    """A booking that is to be decided, and how it is answered."""

    request: BookRide
    answer: asyncio.Future[rides.BookingResult]
    request_id: str


class _Decision:
    """The use case, and when it began and ended in the last attempt: it waits for its turn before."""

    def __init__(self, requests: list[BookRide], clock: Clock) -> None:
        self._requests, self._clock = requests, clock
        self.begun = self.ended = clock.now()

    def make(self, uow: UnitOfWork) -> list[rides.BookingResult | DomainError]:
        self.begun = self._clock.now()
        results = rides.book_all(uow, self._requests)
        self.ended = self._clock.now()
        return results


class BookingBatcher:
    """Answers in the order of arrival. A first booking does not wait for others."""

    def __init__(self, transactions: Transactions, clock: Clock, spans: RideSpans | None = None) -> None:
        """spans: of the decided rides; None: they are not traced."""
        self._transactions, self._clock, self._spans = transactions, clock, spans
        self._waiting: list[_Waiting] = []
        self._worker: asyncio.Task[None] | None = None

    async def book(self, request: BookRide) -> rides.BookingResult:
        """Raises what `rides.book` raises."""
        answer: asyncio.Future[rides.BookingResult] = asyncio.get_running_loop().create_future()
        self._waiting.append(_Waiting(request, answer, current_request_id()))
        if self._worker is None:
            self._worker = asyncio.get_running_loop().create_task(
                self._work(), name="booking-batcher", context=Context()
            )
        return await answer

    async def _work(self) -> None:
        try:
            while self._waiting:
                together = self._waiting[:TOGETHER_MAX]
                del self._waiting[: len(together)]
                await self._decide(together)
        finally:
            self._worker = None

    async def _decide(self, together: list[_Waiting]) -> None:
        """Decide all in one transaction. If that fails, decide each one alone, so that one harms no other.

        If the database fails, all get its error: a booking whose outcome is unknown is not made twice.
        """
        requests = [one.request for one in together]
        # The worker's own context: a line of the log about several requests names all of them.
        structlog.contextvars.bind_contextvars(request_id=",".join(one.request_id for one in together))
        decision = _Decision(requests, self._clock)
        begun = self._clock.now()
        (booked,) = await asyncio.gather(self._transactions.run(decision.make), return_exceptions=True)
        if self._spans is not None and isinstance(booked, list):
            ride_ids = [result.ride.ride_id for result in booked if isinstance(result, rides.BookingResult)]
            ended = self._clock.now()
            self._spans.add(ride_ids, "booking.transaction", ns_of(begun), ns_of(ended))
            self._spans.add(ride_ids, "booking.decision", ns_of(decision.begun), ns_of(decision.ended))
        if isinstance(booked, list):
            for one, result in zip(together, booked, strict=True):
                _settle(one.answer, result)
        elif len(together) == 1 or isinstance(booked, StoreFailure):
            for one in together:
                _settle(one.answer, booked)
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
