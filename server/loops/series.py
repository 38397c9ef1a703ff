"""Recurring bookings become rides as their days come near."""

from functools import partial

from server.domain.errors import DomainError, PlanChanged, StoreFailure
from server.supervision.standing_tasks import PeriodicTask
from server.supervision.steps import run_steps
from server.usecases.ports.unit_of_work import Transactions
from server.usecases.rides import series
from server.usecases.rides.series import DueRide

LEASE = "series"
PERIOD_S = 20.0
LEASE_S = 60.0


class SeriesScheduler:
    def __init__(self, transactions: Transactions, holder: str) -> None:
        self._transactions = transactions
        self._holder = holder
        self.task = PeriodicTask("series", self.run_once, PERIOD_S)

    async def run_once(self) -> None:
        """Book the days that are due. One replica at a time; a second one would find each day booked."""
        held = await self._transactions.run(
            lambda uow: uow.leases.take(LEASE, self._holder, uow.now, LEASE_S)
        )
        if held is None:
            return
        due_rides = await self._transactions.read(series.due_rides)
        finish = partial(self._transactions.run, series.finish_past)
        await run_steps([*(partial(self._book, due) for due in due_rides), finish])

    async def _book(self, due: DueRide) -> None:
        """A failed attempt is rolled back, and its reason is stored in a transaction of its own."""
        try:
            await self._transactions.run(lambda uow: series.book_occurrence(uow, due))
        except PlanChanged:
            return  # other writers were faster; the next period tries again
        except StoreFailure:
            raise
        except DomainError as error:
            reason, detail = error.rule or error.code, error.detail
            await self._transactions.run(lambda uow: series.record_failed_attempt(uow, due, reason, detail))
