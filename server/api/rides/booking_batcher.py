"""Bookings that arrive while others are being decided are decided together, on one snapshot of the fleet."""

import asyncio
from collections.abc import Sequence
from contextvars import Context
from dataclasses import dataclass

import structlog

from contract.tracing import RideSpans
from server.api.request_ids import current_request_id
from server.domain.errors import DomainError, StoreFailure
from server.domain.instants import ns_of
from server.domain.record.audit import AuditAction, Caller
from server.domain.rides.rides import BookRide
from server.usecases.ports.clock_and_ids import Clock
from server.usecases.ports.unit_of_work import Transactions, UnitOfWork
from server.usecases.record import audit
from server.usecases.rides import rides

TOGETHER_MAX = 32


@dataclass(frozen=True, slots=True)
class _Waiting:
    """A booking that is to be decided, and how it is answered. caller: a developer, for the audit log."""

    request: BookRide
    answer: asyncio.Future[rides.BookingResult]
    request_id: str
    caller: Caller | None


class _Decision:
    """The use case, and when it began and ended in the last attempt: it waits for its turn before."""

    def __init__(self, together: Sequence[_Waiting], clock: Clock) -> None:
        self._together, self._clock = together, clock
        self.begun = self.ended = clock.now()

    def make(self, uow: UnitOfWork) -> list[rides.BookingResult | DomainError]:
        self.begun = self._clock.now()
        results = rides.book_all(uow, [one.request for one in self._together])
        for one, result in zip(self._together, results, strict=True):
            if one.caller is not None:
                audit.append(uow, one.caller, _action(result))
        self.ended = self._clock.now()
        return results


class BookingBatcher:
    """Answers in the order of arrival. A first booking does not wait for others."""

    def __init__(self, transactions: Transactions, clock: Clock, spans: RideSpans | None = None) -> None:
        """spans: of the decided rides; None: they are not traced."""
        self._transactions, self._clock, self._spans = transactions, clock, spans
        self._waiting: list[_Waiting] = []
        self._worker: asyncio.Task[None] | None = None

    async def book(self, request: BookRide, caller: Caller | None = None) -> rides.BookingResult:
        """Raises what `rides.book` raises. caller: a developer, whose bookings are in the audit log"""
        answer: asyncio.Future[rides.BookingResult] = asyncio.get_running_loop().create_future()
        self._waiting.append(_Waiting(request, answer, current_request_id(), caller))
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
        # The worker's own context: a line of the log about several requests names all of them.
        structlog.contextvars.bind_contextvars(request_id=",".join(one.request_id for one in together))
        decision = _Decision(together, self._clock)
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


def _action(result: rides.BookingResult | DomainError) -> AuditAction:
    if isinstance(result, DomainError):
        return AuditAction("book_ride", outcome=result.code)
    return AuditAction("book_ride", result.ride.ride_id)


def _settle(answer: asyncio.Future[rides.BookingResult], result: rides.BookingResult | BaseException) -> None:
    """Answer the caller, unless it has gone. Its booking is made all the same."""
    if answer.done():
        return
    if isinstance(result, BaseException):
        answer.set_exception(result)
    else:
        answer.set_result(result)
