"""Deletes old telemetry, decisions and sessions, erases who rode, and learns the travel time factors."""

from functools import partial

import structlog

from server.supervision.standing_tasks import PeriodicTask
from server.supervision.steps import run_steps
from server.usecases.ports.unit_of_work import Transactions
from server.usecases.record import retention, travel_time_factors
from server.usecases.rides import erasure

log = structlog.get_logger("loops")

PERIOD_S = 3600.0
ERASURES_MAX = 100


class RetentionLoop:
    def __init__(self, transactions: Transactions) -> None:
        self._transactions = transactions
        self.task = PeriodicTask("retention", self.run_once, PERIOD_S)

    async def run_once(self) -> None:
        works = (retention.forget_old, travel_time_factors.learn)
        steps = [partial(self._transactions.run, work) for work in works]
        await run_steps([*steps, self._erase_riders, self._tell_audit_head])

    async def _tell_audit_head(self) -> None:
        """Into the log, which is kept elsewhere: entries that are cut off are noticed by it."""
        head = await self._transactions.read(lambda uow: uow.audit.head())
        log.info("audit.head", number=head.number, sha256=head.sha256)

    async def _erase_riders(self) -> None:
        """In small transactions, and at most so many in an hour: the rest is done in the next one."""
        for _ in range(ERASURES_MAX):
            # Found by a reader: looking through all rides would keep bookings waiting.
            rides, series = await self._transactions.read(erasure.due)
            if not rides and not series:
                return
            await self._transactions.run(partial(erasure.erase_due, ride_ids=rides, series_ids=series))
